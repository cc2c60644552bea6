// An error model at work: what the kinds of it share. NavigationEngine estimates the errors of a
// mechanisation that runs beside it, StateEngine the navigation state itself, InvariantEngine that on its
// group.
#pragma once

#include <cmath>

#include "components/hand_over.hpp"
#include "estimation/corrector.hpp"
#include "estimation/estimator.hpp"

namespace truenorth {

// What a correction did to the mechanisation.
struct Change {
    bool finite = true;  // false: the estimate is not, and cannot be used any more
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the computed attitude
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // [m/s]
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  // [m]

    // From one state to another.
    static Change between(const NavigationState& before, const NavigationState& after) {
        return {.rotation = (after.q_bn * before.q_bn.conjugate()).toRotationMatrix(),
                .velocity = after.velocity - before.velocity,
                .displacement = earth::displacement(before.position, after.position)};
    }
};

// From where a filter sets out.
struct Start {
    NavigationState state;
    Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           // [rad/s]
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // [m/s2]
    HandedCovariance covariance = HandedCovariance::Zero();        // zero: the prior
};

template <ErrorModel M>
class Engine {
  public:
    using Where = Adapter<M>;
    static constexpr int kStates = M::kStates;
    static constexpr int kMeasurements = M::kMeasurements;
    static constexpr bool kFindsPosition = Where::position.count > 0;

    // Settings; they follow from the parameters and are not part of a saved state, unlike what they learn.
    Estimator<M> estimator;
    Corrector<kStates, kMeasurements> corrector;
    Adapter<M> adapter;
    Vector<kStates> prior_sigma = Vector<kStates>::Ones();

    // Back to the prior covariance: the estimate stays, but nothing is known of its error.
    void forget() { estimator.covariance = prior_sigma.cwiseAbs2().asDiagonal(); }

    // What is known of attitude [rad] and velocity [m/s] becomes uncertain by so much more.
    void doubt(double angle, double velocity) {
        auto variance = estimator.covariance.diagonal();
        variance.segment(Where::attitude.first, Where::attitude.count).array() += angle * angle;
        variance.segment(Where::velocity.first, Where::velocity.count).array() += velocity * velocity;
    }

    // A model that has a coarse stage says when it is in it.
    [[nodiscard]] static constexpr bool is_coarse() { return false; }

    // Blames the navigation state: its variances are divided by alpha, its correlations stay. What is known
    // of the sensors is not touched: it comes from their makers, and no start can make it wrong.
    void blame(double alpha) {
        Vector<kStates> growth = Vector<kStates>::Constant(1.0 / std::sqrt(alpha));
        const auto spare = [&](Block block) { growth.segment(block.first, block.count).setOnes(); };
        spare(Where::gyro);
        spare(Where::accelerometer);
        if constexpr (requires { Where::markov; }) {
            spare(Where::markov);
        }
        auto& P = estimator.covariance;
        P = (growth.asDiagonal() * P * growth.asDiagonal()).eval();
    }

    [[nodiscard]] const Mechanisation& mechanisation() const { return mechanisation_; }

    // Of the misalignment that is estimated [rad].
    [[nodiscard]] Eigen::Vector3d misalignment_sigma() const {
        const Vector<kStates> sigma = estimator.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
        return components(sigma, Where::attitude);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(estimator, corrector, adapter, mechanisation_, gyro_bias_, accelerometer_bias_, found_);
    }

  protected:
    void set_out(const Start& start) {
        mechanisation_ = Mechanisation(start.state);
        gyro_bias_ = start.gyro_bias;
        accelerometer_bias_ = start.accelerometer_bias;
        found_.setZero();
        adapter = {};
        corrector.restart();
        forget();
        if (!start.covariance.isZero(0.0)) {
            take_covariance<Where>(estimator.covariance, start.covariance);
        }
    }

    // Freed of the biases that are known.
    [[nodiscard]] ImuIncrement compensated(ImuIncrement increment) const {
        increment.delta_angle -= gyro_bias_ * increment.dt;
        increment.delta_velocity -= accelerometer_bias_ * increment.dt;
        return increment;
    }

    Mechanisation mechanisation_;
    Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();           // known [rad/s]
    Eigen::Vector3d accelerometer_bias_ = Eigen::Vector3d::Zero();  // known [m/s2]
    Eigen::Vector3d found_ = Eigen::Vector3d::Zero();               // misalignment, by the last fix [rad]
};

}  // namespace truenorth
