// An error-state model at work: the mechanisation, the estimator beside it, and the corrector between the
// two.
//
// With feedback every correction is moved into the mechanisation and its sensor biases, and the estimate
// starts again from zero; without, the mechanisation runs open loop and `best` alone is corrected
// (EulerPlatform then damps its velocity, Zhao 2012).
#pragma once

#include "components/engine.hpp"
#include "components/time_tolerance.hpp"
#include "estimation/delayed.hpp"

namespace truenorth {

template <ErrorModel M>
class NavigationEngine : public Engine<M> {
  public:
    using Base = Engine<M>;
    using Base::estimator;
    using typename Base::Where;

    bool feedback = true;

    void start(const Start& start) {
        this->set_out(start);
        average_ = IntervalAverage{};
        estimator.state.setZero();
    }

    // Carries the mechanisation over an increment.
    Prediction mechanise(const ImuIncrement& increment) {
        const NavigationState before = mechanisation_.state;
        mechanisation_.advance(this->compensated(increment));
        average_.add(before, mechanisation_, increment.dt);
        return Prediction::sound;
    }

    // Time since the estimate was last carried forward [s].
    [[nodiscard]] double pending() const { return average_.duration(); }

    // Carries the estimate to the present; pending() must be positive.
    Prediction predict() {
        const typename M::Interval interval(average_, mechanisation_.state.position, estimator.state);
        average_ = IntervalAverage{};
        return estimator.predict(interval);
    }

    // A fix that is late is compared with the estimate as it was at its time.
    [[nodiscard]] auto innovate(const Sighting& seen, const typename M::Fix& fix) const {
        if (seen.since.duration() <= kTimeTolerance) {
            return estimator.innovate(fix);
        }
        return innovate_delayed(estimator.model, estimator.state, estimator.covariance, fix,
                                typename M::Interval(seen.since, seen.then.position, estimator.state));
    }

    // Corrects the estimate and feeds it back. The correction must have been used.
    Change apply(const Correction<Base::kStates, Base::kMeasurements>& correction) {
        estimator.apply(correction);
        if (!estimator.state.allFinite() || !estimator.covariance.allFinite()) {
            return {.finite = false};
        }
        this->found_ = components(estimator.state, Where::attitude);
        const NavigationState before = mechanisation_.state;
        if (feedback) {
            mechanisation_.state = M::corrected(mechanisation_.state, estimator.state);
            this->gyro_bias_ += components(estimator.state, Where::gyro);
            this->accelerometer_bias_ += components(estimator.state, Where::accelerometer);
            estimator.reset();
        } else if constexpr (requires { M::damp(mechanisation_.state, estimator.state); }) {
            M::damp(mechanisation_.state, estimator.state);
        }
        return Change::between(before, mechanisation_.state);
    }

    // Moves the mechanisation in what the model has no states for: velocity [m/s] and position [m], ENU.
    void move(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement) {
        mechanisation_.state.velocity += velocity;
        mechanisation_.state.position = earth::displaced(mechanisation_.state.position, displacement);
    }

    // The navigation state, corrected by the estimate.
    [[nodiscard]] NavigationState best() const { return M::corrected(mechanisation_.state, estimator.state); }

    // Of the errors that `best` has left. With feedback there is nothing to be taken out between two fixes.
    [[nodiscard]] Matrix<Base::kStates> covariance() const {
        return feedback ? estimator.covariance : estimator.covariance_of_remaining();
    }

    [[nodiscard]] Eigen::Vector3d gyro_bias() const {
        return this->gyro_bias_ + components(estimator.state, Where::gyro);
    }
    [[nodiscard]] Eigen::Vector3d accelerometer_bias() const {
        return this->accelerometer_bias_ + components(estimator.state, Where::accelerometer);
    }

    // With feedback the misalignment that the last fix found, without the one that is estimated [rad].
    [[nodiscard]] Eigen::Vector3d misalignment() const {
        return feedback ? this->found_ : components(estimator.state, Where::attitude);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        Base::serialize(archive);
        archive(average_);
    }

  private:
    using Base::mechanisation_;
    IntervalAverage average_;
};

}  // namespace truenorth
