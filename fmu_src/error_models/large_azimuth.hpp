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
//     dv'  = (I - C^T) f' + C^T C_b^{n'} nabla - (2 w_ie + w_en) x dv - dw_en x (v + dv)   horizontal rows
//
// with f' = C_b^{n'} f^b the computed force. Zhou 2011 writes (C - I) f^n with the force of the *true* frame,
// which nobody has; `VelocityForm` offers the ways to read it. v is the velocity that the filter trusts, v +
// dv that of the mechanisation: open loop they are as far apart as the start was wrong, and -dw_en x dv is
// 1.6e-4 m/s2 for 40 m/s. The transport terms are bilinear in velocity and error: the rows of Zhou 2011 eq.
// 14 have this one not at all if its V is read as v, twice if as v + dv. Velocity error, misalignment and
// biases are computed minus true; the measurement is INS minus GNSS velocity.
#pragma once

#include <array>

#include "error_models/misalignment.hpp"
#include "error_models/navigation_interval.hpp"
#include "error_models/vector_model.hpp"
#include "estimation/shear.hpp"

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

    // The trusted velocity is that of the mechanisation less the estimate of its error.
    struct Interval : NavigationInterval {
        Interval(const IntervalAverage& average, const earth::Position& position, const State& x);
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
        propagate_vectors(*this, x, deviations, interval);
    }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Points<kStates, Count>& noise,
                   const Interval& interval) const {
        propagate_vectors(*this, x, deviations, noise, interval);
    }

    [[nodiscard]] Matrix<kStates> transition(const State& x, const Interval& interval) const;

    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    [[nodiscard]] static Eigen::Vector2d residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Eigen::Matrix2d measurement_noise(const State& x, const Fix& fix) const;

    // Heading times horizontal force makes velocity, and the computed force is horizontal by the tilts and
    // accelerometer biases that are not known yet: a first-order filter takes that for a sight of the
    // heading. What a correction says that they have done to the velocity was none.
    [[nodiscard]] Shear<kStates> hindsight(const Matrix<kStates>& prior, const State& correction) const;

    // dx/dt of every column of x, and its Jacobian at x.
    template <class Set>
    [[nodiscard]] Set rate(const Set& x, const Interval& interval) const;
    [[nodiscard]] Matrix<kStates> jacobian(const State& x, const Interval& interval) const;

    // The navigation state corrected by the estimate: attitude and horizontal velocity.
    [[nodiscard]] static NavigationState corrected(const NavigationState& computed, const State& x);

    // Jacobian of the remaining errors with respect to the errors, when the estimate x has been fed back and
    // n'' = the corrected frame takes the place of n'.
    [[nodiscard]] static Matrix<kStates> reset_jacobian(const State& x);
};

template <class Set>
Set LargeAzimuth::rate(const Set& x, const Interval& interval) const {
    using Row = Eigen::Array<double, 1, Set::ColsAtCompileTime>;
    const Components<Row> dv{x.row(kVelocityEast), x.row(kVelocityNorth), Row::Zero()};
    const Components<Row> dw = interval.transport_rate(dv);
    const Row phi_n = x.row(kPhiNorth);
    const MisalignmentMatrix<Row> C(Misalignment::large_azimuth, x.row(kPhiEast), phi_n, x.row(kPhiUp));

    const Eigen::Matrix3d& C_bn = interval.C_bn;
    const auto nabla = [&](int axis) -> Row {
        return C_bn(axis, 0) * x.row(kAccelerometerX).array() +
               C_bn(axis, 1) * x.row(kAccelerometerY).array();
    };
    const auto epsilon = [&](int axis) -> Row {
        return C_bn(axis, 0) * x.row(kGyroX).array() + C_bn(axis, 1) * x.row(kGyroY).array() +
               C_bn(axis, 2) * x.row(kGyroZ).array();
    };

    Set rate;
    rate.template bottomRows<kStates - kAccelerometerX>().setZero();

    // Misalignment.
    const Eigen::Vector3d w = interval.omega_ie + interval.omega_en;
    for (int i = 0; i < 3; ++i) {
        rate.row(kPhiEast + i) = w[i] - C.times(i, w) + dw[i] - epsilon(i);
    }

    // Velocity: force and accelerometer bias.
    const Eigen::Vector3d& f = interval.force;
    std::array<Row, 2> force{Row::Zero(), Row::Zero()};
    switch (velocity_form) {
        case VelocityForm::transposed: {
            const Components<Row> g{f.x() - nabla(0), f.y() - nabla(1), f.z() - nabla(2)};
            force = {f.x() - C.transposed_times(0, g), f.y() - C.transposed_times(1, g)};
            break;
        }
        case VelocityForm::computed_force:
            force = {C.times(0, f) - f.x() + nabla(0), C.times(1, f) - f.y() + nabla(1)};
            break;
        case VelocityForm::vertical_force: {
            const Eigen::Vector3d vertical(0.0, 0.0, f.z());
            force = {C.times(0, vertical) + nabla(0), C.times(1, vertical) + nabla(1)};
            break;
        }
        case VelocityForm::printed:
            force = {C.times(0, f) - f.x() + phi_n * f.z() + nabla(0), C.times(1, f) - f.y() + nabla(1)};
            break;
    }

    // Velocity: Coriolis and transport terms.
    const Components<Row> coriolis = interval.coriolis_rate(dv, dw);
    rate.row(kVelocityEast) = force[0] + coriolis[0];
    rate.row(kVelocityNorth) = force[1] + coriolis[1];
    return rate;
}

}  // namespace truenorth
