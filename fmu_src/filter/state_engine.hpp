// A model at work whose state is the navigation state: its sigma points are mechanised, increment by
// increment, and a correction moves the state itself.
#pragma once

#include "filter/engine.hpp"

namespace truenorth {

template <ErrorModel M>
    requires std::same_as<typename M::State, NavigationState>
class StateEngine : public Engine<M> {
  public:
    using Base = Engine<M>;
    using Base::estimator;
    using typename Base::Where;

    void start(const Start& start);

    // Carries state and covariance over an increment.
    Prediction mechanise(const ImuIncrement& increment);

    // Nothing waits: every increment has been predicted.
    [[nodiscard]] static constexpr bool waits() { return false; }
    [[nodiscard]] static double pending() { return 0.0; }
    [[nodiscard]] static Prediction predict() { return Prediction::sound; }

    [[nodiscard]] Innovation<Base::kStates, Base::kMeasurements> innovate(const Sighting& /*seen*/,
                                                                          const typename M::Fix& fix) const {
        return estimator.innovate(fix);
    }

    // Corrects the state. The correction must have been used. `constants`: of the sensors, after it, if it
    // measured them.
    Change apply(const Correction<Base::kStates, Base::kMeasurements>& correction,
                 const Appended* constants = nullptr);

    // Starts again with the prior, an attitude of these sigmas [rad], and as proposed. Returns what changed.
    Change start_again(const Change& proposal, const Eigen::Vector3d& attitude_sigma,
                       const Discrepancy& /*off*/, bool /*has_fixes*/ = true) {
        this->forget(attitude_sigma);
        estimator.state = proposal.of(estimator.state);
        mechanisation_.state = estimator.state;
        return proposal;
    }

    [[nodiscard]] const NavigationState& best() const { return estimator.state; }

    // Of its errors, computed minus true; a deviation leads to the true one.
    [[nodiscard]] static Matrix<aiding::kErrors, Base::kStates> navigation_errors() {
        return -Base::errors_of_states();
    }
    [[nodiscard]] const Matrix<Base::kStates>& covariance() const { return estimator.covariance; }

    // As handed over: the model does not estimate them.
    [[nodiscard]] const Eigen::Vector3d& gyro_bias() const { return this->gyro_bias_; }
    [[nodiscard]] const Eigen::Vector3d& accelerometer_bias() const { return this->accelerometer_bias_; }

    // What the last fix found [rad].
    [[nodiscard]] const Eigen::Vector3d& misalignment() const { return this->found_; }

  private:
    using Base::mechanisation_;
};

template <ErrorModel M>
    requires std::same_as<typename M::State, NavigationState>
void StateEngine<M>::start(const Start& start) {
    this->set_out(start);
    estimator.state = start.state;
}

template <ErrorModel M>
    requires std::same_as<typename M::State, NavigationState>
Prediction StateEngine<M>::mechanise(const ImuIncrement& increment) {
    const ImuIncrement compensated = this->compensated(increment);
    const Prediction prediction =
        estimator.predict({.mechanisation = mechanisation_, .increment = compensated});
    mechanisation_.advance(compensated);
    mechanisation_.state = estimator.state;
    return prediction;
}

template <ErrorModel M>
    requires std::same_as<typename M::State, NavigationState>
Change StateEngine<M>::apply(const Correction<Base::kStates, Base::kMeasurements>& correction,
                             const Appended* constants) {
    const NavigationState before = estimator.state;
    estimator.apply(correction, constants);
    mechanisation_.state = estimator.state;
    if (!estimator.state.finite() || !estimator.covariance.allFinite()) {
        return {.finite = false};
    }
    this->found_ = -components(correction.deviation, Where::attitude);
    return Change::between(before, estimator.state);
}

}  // namespace truenorth
