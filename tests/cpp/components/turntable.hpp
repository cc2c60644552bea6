// A vehicle that stands on a turntable: its heading changes at a constant rate (or not at all), and what
// ideal sensors on it measure has a closed form.
#pragma once

#include <cmath>
#include <utility>

#include "filter/gnss_input.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth {

struct Turntable {
    double roll = 0.02;    // [rad]
    double pitch = -0.03;  // [rad]
    double heading = 0.7;  // at time 0 [rad]
    double rate = 0.0;     // of the heading [rad/s]
    earth::Position position{0.56, 2.06, 30.0};
    Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           // [rad/s]
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // [m/s2]

    [[nodiscard]] double heading_at(double time) const { return heading + rate * time; }

    [[nodiscard]] NavigationState state_at(double time) const {
        NavigationState state;
        state.q_bn = Eigen::Quaterniond(dcm({roll, pitch, heading_at(time)}));
        state.position = position;
        return state;
    }

    // C_bn = Rz(-heading) T: integrals of Rz(heading) w_ie, then T^T.
    [[nodiscard]] ImuIncrement increment(double from, double to) const {
        const double dt = to - from;
        const Eigen::Matrix3d T = dcm({roll, pitch, 0.0});
        const Eigen::Vector3d w = earth::rate(position.latitude);
        const double a = heading_at(from);
        const double b = heading_at(to);
        const double sine = rate == 0.0 ? dt * std::sin(a) : (std::cos(a) - std::cos(b)) / rate;
        const double cosine = rate == 0.0 ? dt * std::cos(a) : (std::sin(b) - std::sin(a)) / rate;
        const Eigen::Vector3d turned(-w.y() * sine, w.y() * cosine, (w.z() - rate) * dt);
        const Eigen::Vector3d up(0.0, 0.0, earth::gravity(position.latitude, position.height) * dt);
        return {dt, T.transpose() * turned + gyro_bias * dt, T.transpose() * up + accelerometer_bias * dt};
    }

    [[nodiscard]] GnssFix fix(double time, const Eigen::Vector3d& lever_arm = Eigen::Vector3d::Zero()) const {
        const NavigationState state = state_at(time);
        const Eigen::Vector3d omega_eb_b = state.q_bn.conjugate() * Eigen::Vector3d(0.0, 0.0, -rate);
        return {time, point_position(state, lever_arm), point_velocity(state, omega_eb_b, lever_arm)};
    }
};

}  // namespace truenorth
