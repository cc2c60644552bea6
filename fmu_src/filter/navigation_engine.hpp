// An error-state model at work: the mechanisation, the estimator beside it, and the corrector between the
// two.
//
// With feedback every correction is moved into the mechanisation and its sensor biases, and the estimate
// starts again from zero; without, the mechanisation runs open loop and `best` alone is corrected
// (EulerPlatform then damps its velocity, Zhao 2012).
#pragma once

#include <algorithm>
#include <limits>
#include <numbers>

#include "contract/time_tolerance.hpp"
#include "estimation/delayed.hpp"
#include "filter/engine.hpp"

namespace truenorth {

template <ErrorModel M>
class NavigationEngine : public Engine<M> {
  public:
    using Base = Engine<M>;
    using Base::estimator;
    using typename Base::Where;

    static constexpr bool kStartsWhereItIs = true;
    static constexpr bool kKeepsHeading = !requires { Where::small_angles; };

    bool feedback = true;
    // Prior sigmas, for a model that has no states for them [rad/s], [m/s2].
    double gyro_bias_sigma = 0.0;
    double accelerometer_bias_sigma = 0.0;

    void start(const Start& start);

    // Carries the mechanisation over an increment; without feedback the estimate too.
    Prediction mechanise(const ImuIncrement& increment);

    // Whether what is known of the estimate stays as it is until it is predicted or corrected.
    [[nodiscard]] bool waits() const { return feedback; }

    // Time since the estimate was last carried forward [s].
    [[nodiscard]] double pending() const { return average_.duration(); }

    // Carries the estimate to the present; pending() must be positive.
    Prediction predict();

    // A fix that is late is compared with the estimate as it was at its time.
    [[nodiscard]] Innovation<Base::kStates, Base::kMeasurements> innovate(const Sighting& seen,
                                                                          const typename M::Fix& fix) const;

    // Corrects the estimate and feeds it back. The correction must have been used. `constants`: of the
    // sensors, after it, if it measured them.
    Change apply(const Correction<Base::kStates, Base::kMeasurements>& correction,
                 const Appended* constants = nullptr);

    // Moves the mechanisation in what the model has no states for: velocity [m/s] and position [m], ENU.
    void move(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement);

    // Starts again where it is but for a turn of the mechanisation about up, with the prior and an attitude
    // of these sigmas [rad]; position and velocity are as uncertain as the fix is far off. Tilts and what has
    // been learned of the sensors stay: with them the equations of its errors find the heading sooner.
    // Returns what changed.
    Change start_again(const Change& proposal, const Eigen::Vector3d& attitude_sigma, const Discrepancy& off,
                       bool has_fixes = true);

    // The navigation state, corrected by the estimate.
    [[nodiscard]] NavigationState best() const { return estimated(mechanisation_.state); }
    [[nodiscard]] NavigationState estimated(const NavigationState& mechanised) const;

    // Of the errors that `best` has left, with respect to those of the states.
    [[nodiscard]] Matrix<aiding::kErrors, Base::kStates> navigation_errors() const;

    // Of the errors that `best` has left. With feedback there is nothing to be taken out between two fixes.
    [[nodiscard]] Matrix<Base::kStates> covariance() const;

    [[nodiscard]] Eigen::Vector3d gyro_bias() const;
    [[nodiscard]] Eigen::Vector3d accelerometer_bias() const;

    // Of the misalignment that is estimated [rad].
    [[nodiscard]] Eigen::Vector3d misalignment_sigma() const;

    // With feedback the misalignment that the last fix found, without the one that is estimated [rad].
    [[nodiscard]] Eigen::Vector3d misalignment() const;

    template <class Archive>
    void serialize(Archive& archive) {
        Base::serialize(archive);
        archive(average_, lag_);
    }

  private:
    static constexpr bool kLeavesBiasesOut = Where::gyro.count == 0 && Where::accelerometer.count == 0;

    // What the estimate does not know of. A model without biases aligns with them: the tilts end off by
    // nabla / g, the heading by eps / (w_ie cos L) (Zhao 2012, section 3), and the velocity by what they add
    // to it before corrections take it away.
    [[nodiscard]] Uncertainty left_out() const;

    // What unit biases have made of tilts and velocity since the start, corrections included.
    struct Lag {
        Eigen::Vector2d tilt = Eigen::Vector2d::Zero();   // about north and east, of a gyro [s]
        Eigen::Vector2d speed = Eigen::Vector2d::Zero();  // east and north, of the same gyro [m]
        double climb = 0.0;                               // of an accelerometer [s]
        double elapsed = 0.0;                             // since the start [s]

        void predict(double dt);

        // A correction has made one covariance of the other.
        void correct(const Matrix<Base::kStates>& before, const Matrix<Base::kStates>& after);

        template <class Archive>
        void serialize(Archive& archive) {
            archive(tilt, speed, climb, elapsed);
        }
    };

    using Base::mechanisation_;
    IntervalAverage average_;
    Lag lag_;  // where biases are left out
};

template <ErrorModel M>
void NavigationEngine<M>::start(const Start& start) {
    this->set_out(start);
    average_ = IntervalAverage{};
    lag_ = Lag{};
    estimator.state.setZero();
}

template <ErrorModel M>
Prediction NavigationEngine<M>::mechanise(const ImuIncrement& increment) {
    const NavigationState before = mechanisation_.state;
    mechanisation_.advance(this->compensated(increment));
    average_.add(before, mechanisation_, increment.dt);
    return feedback ? Prediction::sound : predict();  // `best` takes the one out of the other
}

template <ErrorModel M>
Prediction NavigationEngine<M>::predict() {
    const typename M::Interval interval(average_, mechanisation_.state.position, estimator.state);
    if constexpr (kLeavesBiasesOut) {
        lag_.predict(average_.duration());
    }
    average_ = IntervalAverage{};
    return estimator.predict(interval);
}

template <ErrorModel M>
auto NavigationEngine<M>::innovate(const Sighting& seen, const typename M::Fix& fix) const
    -> Innovation<Base::kStates, Base::kMeasurements> {
    if (seen.since.duration() <= kTimeTolerance) {
        return estimator.innovate(fix);
    }
    return innovate_delayed(estimator.model, estimator.state, estimator.covariance, fix,
                            typename M::Interval(seen.since, seen.then.position, estimator.state));
}

template <ErrorModel M>
Change NavigationEngine<M>::apply(const Correction<Base::kStates, Base::kMeasurements>& correction,
                                  const Appended* constants) {
    if constexpr (kLeavesBiasesOut) {
        const Matrix<Base::kStates> before = estimator.covariance;
        estimator.apply(correction, constants);
        lag_.correct(before, estimator.covariance);
    } else {
        estimator.apply(correction, constants);
    }
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

template <ErrorModel M>
void NavigationEngine<M>::move(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement) {
    mechanisation_.state.velocity += velocity;
    mechanisation_.state.position = earth::displaced(mechanisation_.state.position, displacement);
}

template <ErrorModel M>
Change NavigationEngine<M>::start_again(const Change& proposal, const Eigen::Vector3d& attitude_sigma,
                                        const Discrepancy& off, bool /*has_fixes*/) {
    mechanisation_.state = proposal.of(mechanisation_.state);
    if (!proposal.rotation.isIdentity()) {  // without feedback, it takes the place of an estimated heading
        auto misalignment = estimator.state.template segment<3>(Where::attitude.first);
        misalignment = (proposal.rotation * misalignment).eval();
        misalignment.z() = 0.0;
    }
    this->forget();
    this->add_uncertainty({.attitude = attitude_sigma.cwiseAbs2().asDiagonal(),
                           .velocity = off.velocity.cwiseAbs2().asDiagonal(),
                           .position = off.position.cwiseAbs2().asDiagonal()});
    return proposal;
}

template <ErrorModel M>
NavigationState NavigationEngine<M>::estimated(const NavigationState& mechanised) const {
    if (estimator.state.isZero(0.0)) {  // as it is after every fix with feedback
        return mechanised;
    }
    return M::corrected(mechanised, estimator.state);
}

template <ErrorModel M>
auto NavigationEngine<M>::navigation_errors() const -> Matrix<aiding::kErrors, Base::kStates> {
    if constexpr (Resettable<M>) {
        return Base::errors_of_states() * estimator.model.reset_jacobian(estimator.state);
    } else {
        return Base::errors_of_states();
    }
}

template <ErrorModel M>
auto NavigationEngine<M>::covariance() const -> Matrix<Base::kStates> {
    Matrix<Base::kStates> P = feedback ? estimator.covariance : estimator.covariance_of_remaining();
    if constexpr (kLeavesBiasesOut) {
        const Uncertainty more = left_out();
        P.template block<3, 3>(Where::attitude.first, Where::attitude.first) += more.attitude;
        P.template block<3, 3>(Where::velocity.first, Where::velocity.first) += more.velocity;
    }
    return P;
}

template <ErrorModel M>
Uncertainty NavigationEngine<M>::left_out() const {
    const double north_rate = earth::rate(mechanisation_.state.position.latitude).y();
    const double tilt = accelerometer_bias_sigma / earth::kStandardGravity;
    const double heading = std::min(gyro_bias_sigma / north_rate, std::numbers::pi);
    const double climb = accelerometer_bias_sigma * lag_.climb;
    Uncertainty more;
    more.attitude.diagonal() = Eigen::Vector3d(tilt, tilt, heading).cwiseAbs2();
    more.velocity.diagonal() << (gyro_bias_sigma * lag_.speed).cwiseAbs2(), climb * climb;
    return more;
}

// A gyro tilts the level frame, and gravity then moves the velocity that is across the tilt.
template <ErrorModel M>
void NavigationEngine<M>::Lag::predict(double dt) {
    speed += earth::kStandardGravity * dt * (tilt + Eigen::Vector2d::Constant(0.5 * dt));
    tilt.array() += dt;
    climb += dt;
    elapsed += dt;
}

// The gains are those by which a measured velocity changed itself and the tilt that it shows. Whatever they
// are, nothing is further off than it would be without corrections.
template <ErrorModel M>
void NavigationEngine<M>::Lag::correct(const Matrix<Base::kStates>& before,
                                       const Matrix<Base::kStates>& after) {
    constexpr int a = Where::attitude.first;
    constexpr int v = Where::velocity.first;
    const Matrix<Base::kStates> taken = before - after;
    const Eigen::Array3d variance =
        before.diagonal().template segment<3>(v).cwiseMax(std::numeric_limits<double>::min());
    const Eigen::Array3d gain =
        (taken.diagonal().template segment<3>(v).array() / variance).min(1.0).max(0.0);
    const Eigen::Array2d shown = Eigen::Array2d(taken(a + 1, v), taken(a, v + 1)).abs() / variance.head<2>();
    const double fallen = 0.5 * earth::kStandardGravity * elapsed * elapsed;
    tilt = (tilt.array() - shown * speed.array()).min(elapsed).max(-elapsed);
    speed = (speed.array() * (1.0 - gain.head<2>())).min(fallen).max(-fallen);
    climb *= 1.0 - gain(2);
}

template <ErrorModel M>
Eigen::Vector3d NavigationEngine<M>::misalignment_sigma() const {
    if constexpr (kLeavesBiasesOut) {
        return (Base::misalignment_sigma().cwiseAbs2() + left_out().attitude.diagonal()).cwiseSqrt();
    } else {
        return Base::misalignment_sigma();
    }
}

template <ErrorModel M>
Eigen::Vector3d NavigationEngine<M>::gyro_bias() const {
    return this->gyro_bias_ + components(estimator.state, Where::gyro);
}

template <ErrorModel M>
Eigen::Vector3d NavigationEngine<M>::accelerometer_bias() const {
    return this->accelerometer_bias_ + components(estimator.state, Where::accelerometer);
}

template <ErrorModel M>
Eigen::Vector3d NavigationEngine<M>::misalignment() const {
    return feedback ? this->found_ : components(estimator.state, Where::attitude);
}

}  // namespace truenorth
