// Large azimuth misalignment, 10 states: the alignment model of Zhou 2011, section 3, corrected.
//
// n is the true navigation frame (ENU), n' the computed one, C = C_n^{n'} with small horizontal angles
// (Zhou 2011 eq. 13 = Zhao 2012 eq. 3):
//
//         [        c                 s           -phi_n ]      c = cos phi_u
//     C = [       -s                 c            phi_e ]      s = sin phi_u
//         [ phi_n c + phi_e s  phi_n s - phi_e c     1  ]
//
//     phi' = (I - C) w_in + dw_in - C_b^{n'} eps                                          (Zhou 2011 eq. 12)
//     dv'  = (I - C^T) f' + C^T C_b^{n'} nabla - (2 w_ie + w_en) x dv - dw_en x v          horizontal rows
//
// with f' = C_b^{n'} f^b the computed force. Zhou 2011 writes (C - I) f^n with the force of the *true* frame,
// which nobody has; `VelocityForm` offers the ways to read it. Velocity error, misalignment and biases are
// computed minus true; the measurement is INS minus GNSS velocity.
#pragma once

#include "error_models/interval_average.hpp"
#include "estimation/gaussian.hpp"
#include "estimation/integration.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth {

class LargeAzimuth {
  public:
    enum StateIndex {
        kVelocityEast,  // [m/s]
        kVelocityNorth,
        kPhiEast,  // [rad]
        kPhiNorth,
        kPhiUp,
        kAccelerometerX,  // nabla, body right [m/s2]
        kAccelerometerY,  // nabla, body forward
        kGyroX,           // eps, body right [rad/s]
        kGyroY,
        kGyroZ,
        kStates
    };
    static constexpr int kMeasurements = 2;
    using State = Vector<kStates>;

    // How the velocity rows treat the force.
    enum class VelocityForm {
        transposed,      // (I - C^T) f' + C^T C_b^{n'} nabla: right, survives manoeuvres
        computed_force,  // (C - I) f' + C_b^{n'} nabla: Zhou 2011 eq. 12 read literally; biased
        vertical_force,  // (C - I) (0, 0, f_u) + C_b^{n'} nabla: wide priors on a vehicle that does not
                         // manoeuvre
        printed,         // computed_force without -f_u phi_n in the east row, as in Zhou 2011 eq. 14; useless
    };

    struct Noise {
        double angle_random_walk;     // gyro [rad/s^0.5]
        double velocity_random_walk;  // accelerometer [m/s^1.5]
        double velocity_sigma;        // GNSS [m/s]
    };

    // What drives the model over a filter interval, from the averages of the mechanisation.
    struct Interval {
        Interval(const IntervalAverage& average, const earth::Position& position, const State& x);

        double dt;                 // [s]
        Eigen::Matrix3d C_bn;      // C_b^{n'}
        Eigen::Vector3d force;     // f' [m/s2]
        Eigen::Vector3d velocity;  // that the filter trusts, ENU [m/s]
        Eigen::Vector3d omega_ie;  // [rad/s]
        Eigen::Vector3d omega_en;
        // dw_en = (-dv_n / (R_M + h), dv_e / (R_N + h), dv_e tan L / (R_N + h))
        double per_meridian_radius;        // [1/m]
        double per_prime_vertical_radius;  // [1/m]
        double tan_latitude;
    };

    // A GNSS velocity, seen from the mechanisation.
    struct Fix {
        Eigen::Vector2d velocity_difference;  // of the antenna, INS minus GNSS, east and north [m/s]
        Eigen::Vector3d lever_velocity;  // C_b^{n'} (w_eb^b x l): of the antenna relative to the IMU [m/s]
    };

    VelocityForm velocity_form = VelocityForm::transposed;
    Discretisation discretisation = Discretisation::runge_kutta;
    Noise noise{};

    [[nodiscard]] static State retract(const State& x, const State& deviation) { return x + deviation; }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Interval& interval) const {
        using Set = Points<kStates, Count>;
        const Set start = deviations.colwise() + x;
        const Set end = integrate(
            start, [&](const Set& points) { return rate(points, interval); }, interval.dt, discretisation);
        x = end.col(0);
        deviations = end.colwise() - x;
    }

    [[nodiscard]] Matrix<kStates> transition(const State& x, const Interval& interval) const {
        return truenorth::transition(jacobian(x, interval), interval.dt, discretisation);
    }

    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    [[nodiscard]] static Eigen::Vector2d residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Eigen::Matrix2d measurement_noise(const State& x, const Fix& fix) const;

    // dx/dt of every column of x, and its Jacobian at x.
    template <class Set>
    [[nodiscard]] Set rate(const Set& x, const Interval& interval) const;
    [[nodiscard]] Matrix<kStates> jacobian(const State& x, const Interval& interval) const;

    // The true frame from the computed one: C_n^{n'} of the estimate, as a rotation without approximation
    // (Zhao 2012 eq. 2, C_y C_x C_z).
    [[nodiscard]] static Eigen::Matrix3d misalignment_matrix(const State& x);

    // The navigation state corrected by the estimate: attitude and horizontal velocity.
    [[nodiscard]] static NavigationState corrected(const NavigationState& computed, const State& x);

    // Jacobian of the remaining errors with respect to the errors, when the estimate x has been fed back and
    // n'' = the corrected frame takes the place of n'.
    [[nodiscard]] static Matrix<kStates> reset_jacobian(const State& x);
};

template <class Set>
Set LargeAzimuth::rate(const Set& x, const Interval& interval) const {
    using Row = Eigen::Array<double, 1, Set::ColsAtCompileTime>;
    const Row dv_e = x.row(kVelocityEast);
    const Row dv_n = x.row(kVelocityNorth);
    const Row phi_e = x.row(kPhiEast);
    const Row phi_n = x.row(kPhiNorth);
    const Row c = x.row(kPhiUp).array().cos();
    const Row s = x.row(kPhiUp).array().sin();
    const Row C31 = phi_n * c + phi_e * s;
    const Row C32 = phi_n * s - phi_e * c;

    const Eigen::Matrix3d& C_bn = interval.C_bn;
    const auto nabla = [&](int axis) -> Row {
        return C_bn(axis, 0) * x.row(kAccelerometerX).array() +
               C_bn(axis, 1) * x.row(kAccelerometerY).array();
    };
    const auto epsilon = [&](int axis) -> Row {
        return C_bn(axis, 0) * x.row(kGyroX).array() + C_bn(axis, 1) * x.row(kGyroY).array() +
               C_bn(axis, 2) * x.row(kGyroZ).array();
    };
    const Row dw_e = -dv_n * interval.per_meridian_radius;
    const Row dw_n = dv_e * interval.per_prime_vertical_radius;
    const Row dw_u = dw_n * interval.tan_latitude;

    Set rate = Set::Zero();

    // Misalignment.
    const Eigen::Vector3d w = interval.omega_ie + interval.omega_en;
    rate.row(kPhiEast) = (1.0 - c) * w.x() - s * w.y() + phi_n * w.z() + dw_e - epsilon(0);
    rate.row(kPhiNorth) = s * w.x() + (1.0 - c) * w.y() - phi_e * w.z() + dw_n - epsilon(1);
    rate.row(kPhiUp) = -C31 * w.x() - C32 * w.y() + dw_u - epsilon(2);

    // Velocity: force and accelerometer bias.
    const Eigen::Vector3d& f = interval.force;
    Row force_e = Row::Zero();
    Row force_n = Row::Zero();
    switch (velocity_form) {
        case VelocityForm::transposed: {
            const Row g_e = f.x() - nabla(0);
            const Row g_n = f.y() - nabla(1);
            const Row g_u = f.z() - nabla(2);
            force_e = f.x() - (c * g_e - s * g_n + C31 * g_u);
            force_n = f.y() - (s * g_e + c * g_n + C32 * g_u);
            break;
        }
        case VelocityForm::computed_force:
            force_e = (c - 1.0) * f.x() + s * f.y() - phi_n * f.z() + nabla(0);
            force_n = -s * f.x() + (c - 1.0) * f.y() + phi_e * f.z() + nabla(1);
            break;
        case VelocityForm::vertical_force:
            force_e = -phi_n * f.z() + nabla(0);
            force_n = phi_e * f.z() + nabla(1);
            break;
        case VelocityForm::printed:
            force_e = (c - 1.0) * f.x() + s * f.y() + nabla(0);
            force_n = -s * f.x() + (c - 1.0) * f.y() + phi_e * f.z() + nabla(1);
            break;
    }

    // Velocity: Coriolis and transport terms.
    const double W_u = 2.0 * interval.omega_ie.z() + interval.omega_en.z();
    const Eigen::Vector3d& v = interval.velocity;
    rate.row(kVelocityEast) = force_e + W_u * dv_n - (dw_n * v.z() - dw_u * v.y());
    rate.row(kVelocityNorth) = force_n - W_u * dv_e - (dw_u * v.x() - dw_e * v.z());
    return rate;
}

}  // namespace truenorth
