// Euler platform error angles, 6 states: the alignment models of Zhao 2012, section 1.4, for a stationary
// base.
//
//     alpha' = C_w^-1 [ (I - C) w_ie + dw_en - C_b^{n'} w_g ]
//     dv'    = (I - C^T) f' - (2 w_ie + dw_en) x dv + C^T C_b^{n'} w_a
//
// with C = C_n^{n'} and dw_en = T dv; w_g and w_a are the white noises of gyros and accelerometers, whose
// biases the reduced filter leaves out. `form` chooses C: large (eq. 25), large azimuth (eq. 26) or small
// (eq. 27); in the last two C_w = I. Zhao 2012 writes (C - I) f^n with the force of the true frame, which on
// a base at rest is (0, 0, g); `VelocityForm` offers that and the form with the computed force f'. The two
// agree at the true angles, but while the tilts are still being found the rows with f' depend on the heading
// and seem to measure it. Errors are computed minus true. The large form is singular where alpha_x is a
// quarter turn.
//
// The base does not move, so the computed velocity is the error: the measurement is the velocity of the
// mechanisation itself, all three components. Zhao 2012 damps the mechanisation: after every fix, `damp`
// takes the estimated velocity error out of its velocity and leaves the angles to the filter, so that the
// Coriolis and transport terms that the mechanisation computes stay those of a base at rest. Position is to
// be kept as known. Feeding back the angles as well (`corrected`, `reset_jacobian`) works as with any other
// model.
#pragma once

#include "error_models/misalignment.hpp"
#include "error_models/navigation_interval.hpp"
#include "error_models/vector_model.hpp"

namespace truenorth {

class EulerPlatform {
  public:
    enum StateIndex {
        kAlphaX,        // about east [rad]
        kAlphaY,        // about north
        kAlphaZ,        // about up
        kVelocityEast,  // [m/s]
        kVelocityNorth,
        kVelocityUp,
        kStates
    };
    static constexpr int kMeasurements = 3;
    using State = Vector<kStates>;

    // How the velocity rows treat the force.
    enum class VelocityForm {
        transposed,      // (I - C^T) f'
        vertical_force,  // (C - I) (0, 0, g): eqs. 25 to 27 as printed, for a base at rest; no false heading
    };

    struct Noise {
        double angle_random_walk;     // gyro [rad/s^0.5]
        double velocity_random_walk;  // accelerometer [m/s^1.5]
        double velocity_sigma;        // of the zero-velocity fix [m/s]
    };

    // The trusted velocity is zero.
    struct Interval : NavigationInterval {
        Interval(const IntervalAverage& average, const earth::Position& position, const State& x);
    };

    // A zero-velocity fix.
    struct Fix {
        Eigen::Vector3d velocity;  // of the mechanisation, ENU [m/s]
    };

    Misalignment form = Misalignment::large;
    VelocityForm velocity_form = VelocityForm::transposed;
    Discretisation discretisation = Discretisation::runge_kutta;
    Noise noise{};

    [[nodiscard]] static State retract(const State& x, const State& deviation) { return x + deviation; }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Interval& interval) const {
        propagate_vectors(*this, x, deviations, interval);
    }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Points<kStates, Count>& noise,
                   const Interval& interval) const {
        propagate_vectors(*this, x, deviations, noise, interval);
    }

    [[nodiscard]] Matrix<kStates> transition(const State& x, const Interval& interval) const;

    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    [[nodiscard]] static Eigen::Vector3d residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Eigen::Matrix3d measurement_noise(const State& x, const Fix& fix) const;

    // dx/dt of every column of x, and its Jacobian at x.
    template <class Set>
    [[nodiscard]] Set rate(const Set& x, const Interval& interval) const;
    [[nodiscard]] Matrix<kStates> jacobian(const State& x, const Interval& interval) const;

    // The navigation state corrected by the estimate: attitude and velocity.
    [[nodiscard]] static NavigationState corrected(const NavigationState& computed, const State& x);

    // Jacobian of the remaining errors with respect to the errors, when `corrected` has been fed back.
    [[nodiscard]] static Matrix<kStates> reset_jacobian(const State& x);

    // Damping: moves the estimated velocity error from the filter into the mechanisation. The covariance
    // stays.
    static void damp(NavigationState& computed, State& x);
};

template <class Set>
Set EulerPlatform::rate(const Set& x, const Interval& interval) const {
    using Row = Eigen::Array<double, 1, Set::ColsAtCompileTime>;
    const Row alpha_x = x.row(kAlphaX);
    const Row alpha_y = x.row(kAlphaY);
    const MisalignmentMatrix<Row> C(form, alpha_x, alpha_y, x.row(kAlphaZ));
    const Components<Row> dv{x.row(kVelocityEast), x.row(kVelocityNorth), x.row(kVelocityUp)};
    const Components<Row> dw = interval.transport_rate(dv);

    // Rate of n' relative to n, eq. 17.
    const Eigen::Vector3d w = interval.omega_ie + interval.omega_en;
    Components<Row> turn;
    for (int i = 0; i < 3; ++i) {
        turn[i] = w[i] - C.times(i, w) + dw[i];
    }

    Set rate;
    if (form == Misalignment::large) {  // C_w^-1, eq. 18
        const auto [sx, cx] = sincos(alpha_x);
        const auto [sy, cy] = sincos(alpha_y);
        const Row about_z = cy * turn[2] - sy * turn[0];
        rate.row(kAlphaX) = cy * turn[0] + sy * turn[2];
        rate.row(kAlphaY) = turn[1] - sx / cx * about_z;
        rate.row(kAlphaZ) = about_z / cx;
    } else {
        rate.row(kAlphaX) = turn[0];
        rate.row(kAlphaY) = turn[1];
        rate.row(kAlphaZ) = turn[2];
    }

    // Velocity.
    const Eigen::Vector3d& f = interval.force;
    const Eigen::Vector3d vertical(0.0, 0.0, interval.gravity);
    const auto force = [&](int i) -> Row {
        return velocity_form == VelocityForm::vertical_force ? Row(C.times(i, vertical) - vertical[i])
                                                             : Row(f[i] - C.transposed_times(i, f));
    };
    const Components<Row> coriolis = interval.coriolis_rate(dv, dw);
    for (int i = 0; i < 3; ++i) {
        rate.row(kVelocityEast + i) = force(i) + coriolis[i];
    }
    return rate;
}

}  // namespace truenorth
