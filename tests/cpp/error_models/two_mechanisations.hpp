// Brute force for error equations: a true and an erroneous mechanisation side by side, driven by constant
// rate and force, of which the second one measures `gyro_error` and `accelerometer_error` too much.
#pragma once

#include "inertial/mechanisation.hpp"

namespace truenorth {

struct TwoMechanisations {
    Mechanisation truth;
    Mechanisation computed;
    Eigen::Vector3d omega_b;
    Eigen::Vector3d force_b;
    Eigen::Vector3d gyro_error = Eigen::Vector3d::Zero();
    Eigen::Vector3d accelerometer_error = Eigen::Vector3d::Zero();

    [[nodiscard]] TwoMechanisations after(double dt) const {
        TwoMechanisations later = *this;
        later.truth.advance({.dt = dt, .delta_angle = dt * omega_b, .delta_velocity = dt * force_b});
        later.computed.advance({.dt = dt,
                                .delta_angle = dt * (omega_b + gyro_error),
                                .delta_velocity = dt * (force_b + accelerometer_error)});
        return later;
    }

    // d/dt of error(pair) at the start, to second order in the step h.
    template <class Error>
    [[nodiscard]] auto derivative(const Error& error, double h) const {
        return ((4.0 * error(after(h)) - error(after(2.0 * h)) - 3.0 * error(*this)) / (2.0 * h)).eval();
    }
};

}  // namespace truenorth
