// An error model at work: the mechanisation, the estimator beside it, and the corrector between the two.
//
// With feedback every correction is moved into the mechanisation and its sensor biases, and the estimate
// starts again from zero; without, the mechanisation runs open loop and `best` alone is corrected
// (EulerPlatform then damps its velocity, Zhao 2012).
#pragma once

#include "components/blocks.hpp"
#include "error_models/interval_average.hpp"
#include "estimation/corrector.hpp"
#include "estimation/estimator.hpp"

namespace truenorth {

template <ErrorModel M>
class NavigationEngine {
  public:
    using Model = M;
    using Where = Blocks<M>;
    static constexpr int kStates = M::kStates;
    static constexpr int kMeasurements = M::kMeasurements;

    // Settings; they follow from the parameters and are not part of a saved state.
    Estimator<M> estimator;
    Corrector<kStates, kMeasurements> corrector;
    bool feedback = true;
    Vector<kStates> prior_sigma = Vector<kStates>::Ones();

    void start(const NavigationState& navigation) {
        mechanisation_ = Mechanisation(navigation);
        average_ = IntervalAverage{};
        estimator.state.setZero();
        gyro_bias_.setZero();
        accelerometer_bias_.setZero();
        fed_back_.setZero();
        corrector.restart();
        forget();
    }

    // Back to the prior covariance: the estimate stays, but nothing is known of its error.
    void forget() { estimator.covariance = prior_sigma.cwiseAbs2().asDiagonal(); }

    // What is known of attitude [rad] and velocity [m/s] becomes uncertain by so much more.
    void doubt(double angle, double velocity) {
        auto variance = estimator.covariance.diagonal();
        variance.segment(Where::attitude.first, Where::attitude.count).array() += angle * angle;
        variance.segment(Where::velocity.first, Where::velocity.count).array() += velocity * velocity;
    }

    // Carries the mechanisation over an increment, freed of the biases that were fed back.
    void mechanise(ImuIncrement increment) {
        increment.delta_angle -= gyro_bias_ * increment.dt;
        increment.delta_velocity -= accelerometer_bias_ * increment.dt;
        const NavigationState before = mechanisation_.state;
        mechanisation_.advance(increment);
        average_.add(before, mechanisation_, increment.dt);
    }

    // Time since the estimate was last carried forward [s].
    [[nodiscard]] double pending() const { return average_.duration(); }

    // Carries the estimate to the present; pending() must be positive.
    Prediction predict() {
        const typename M::Interval interval(average_, mechanisation_.state.position, estimator.state);
        average_ = IntervalAverage{};
        return estimator.predict(interval);
    }

    [[nodiscard]] auto innovate(const typename M::Fix& fix) const { return estimator.innovate(fix); }

    // What a correction did to the mechanisation.
    struct Change {
        bool finite = true;  // false: the estimate is not, and cannot be used any more
        Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the computed attitude
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // [m/s]
    };

    // Corrects the estimate and feeds it back. The correction must have been used.
    Change apply(const Correction<kStates, kMeasurements>& correction) {
        estimator.apply(correction);
        if (!estimator.state.allFinite() || !estimator.covariance.allFinite()) {
            return {.finite = false};
        }
        fed_back_ = components(estimator.state, Where::attitude);
        const NavigationState before = mechanisation_.state;
        if (feedback) {
            mechanisation_.state = M::corrected(mechanisation_.state, estimator.state);
            gyro_bias_ += components(estimator.state, Where::gyro);
            accelerometer_bias_ += components(estimator.state, Where::accelerometer);
            estimator.reset();
        } else if constexpr (requires { M::damp(mechanisation_.state, estimator.state); }) {
            M::damp(mechanisation_.state, estimator.state);
        }
        const NavigationState& after = mechanisation_.state;
        return {.rotation = (after.q_bn * before.q_bn.conjugate()).toRotationMatrix(),
                .velocity = after.velocity - before.velocity};
    }

    // Moves the mechanisation in what the model has no states for: velocity [m/s] and position [m], ENU.
    void move(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement) {
        mechanisation_.state.velocity += velocity;
        mechanisation_.state.position = earth::displaced(mechanisation_.state.position, displacement);
    }

    [[nodiscard]] const Mechanisation& mechanisation() const { return mechanisation_; }

    // The navigation state, corrected by the estimate.
    [[nodiscard]] NavigationState best() const { return M::corrected(mechanisation_.state, estimator.state); }

    [[nodiscard]] Eigen::Vector3d gyro_bias() const {
        return gyro_bias_ + components(estimator.state, Where::gyro);
    }
    [[nodiscard]] Eigen::Vector3d accelerometer_bias() const {
        return accelerometer_bias_ + components(estimator.state, Where::accelerometer);
    }

    // With feedback the misalignment that the last fix found, without the one that is estimated [rad].
    [[nodiscard]] Eigen::Vector3d misalignment() const {
        return feedback ? fed_back_ : components(estimator.state, Where::attitude);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(estimator, corrector, mechanisation_, average_, gyro_bias_, accelerometer_bias_, fed_back_);
    }

  private:
    Mechanisation mechanisation_;
    IntervalAverage average_;
    Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();           // fed back so far [rad/s]
    Eigen::Vector3d accelerometer_bias_ = Eigen::Vector3d::Zero();  // fed back so far [m/s2]
    Eigen::Vector3d fed_back_ = Eigen::Vector3d::Zero();            // misalignment of the last fix [rad]
};

}  // namespace truenorth
