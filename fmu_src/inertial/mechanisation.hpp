// Strapdown mechanisation in the local-level ENU frame, driven by increments.
//
// Attitude, velocity and position are carried by the two-sample algorithm of Savage (1998): the current
// and the previous increments give the coning and sculling corrections, exact for rates that change
// linearly over both intervals, which need not be equally long.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

// What an IMU's accumulators give: integrals of body rate [rad] and specific force [m/s] over the last
// `dt` seconds, in body axes (right, forward, up).
struct ImuIncrement {
    double dt = 0.0;
    Eigen::Vector3d delta_angle = Eigen::Vector3d::Zero();
    Eigen::Vector3d delta_velocity = Eigen::Vector3d::Zero();

    template <class Archive>
    void serialize(Archive& archive) {
        archive(dt, delta_angle, delta_velocity);
    }
};

// What an increment means for a body that turned and accelerated as the increment before suggests: its
// rotation vector over the interval [rad], coning included, and the integral of the specific force in body
// axes at the interval's start [m/s], sculling included.
struct BodyMotion {
    Eigen::Vector3d rotation;
    Eigen::Vector3d delta_velocity;
};
BodyMotion body_motion(const ImuIncrement& previous, const ImuIncrement& increment);

// Attitude (body to ENU), velocity in ENU [m/s] and geodetic position of the IMU.
struct NavigationState {
    Eigen::Quaterniond q_bn = Eigen::Quaterniond::Identity();
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    earth::Position position;

    [[nodiscard]] bool finite() const {
        return q_bn.coeffs().allFinite() && velocity.allFinite() && std::isfinite(position.latitude) &&
               std::isfinite(position.longitude) && std::isfinite(position.height);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(q_bn, velocity, position);
    }
};

class Mechanisation {
  public:
    NavigationState state;

    Mechanisation() = default;
    explicit Mechanisation(const NavigationState& start) : state(start) {}

    // Carries the state over one increment (dt > 0).
    void advance(const ImuIncrement& increment);

    // What the next increment means for the body after the last one.
    [[nodiscard]] BodyMotion motion(const ImuIncrement& increment) const {
        return body_motion(previous_, increment);
    }

    // dv/dt over the last increment, ENU [m/s2].
    [[nodiscard]] const Eigen::Vector3d& acceleration() const { return acceleration_; }

    // Integral of the specific force over the last increment, in n at its middle [m/s].
    [[nodiscard]] const Eigen::Vector3d& delta_velocity_n() const { return delta_velocity_n_; }

    // Rate of the body relative to the Earth at the end of the last increment, extrapolated from the last
    // two mean rates; body axes [rad/s].
    [[nodiscard]] const Eigen::Vector3d& omega_eb_b() const { return omega_eb_b_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(state, previous_, acceleration_, delta_velocity_n_, omega_eb_b_);
    }

  private:
    ImuIncrement previous_;  // dt = 0: there was none
    Eigen::Vector3d acceleration_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d delta_velocity_n_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d omega_eb_b_ = Eigen::Vector3d::Zero();
};

// Lever arm: position and velocity of a point fixed in the body at `lever_arm` (right, forward, up) [m]
// from the IMU, given the body's rate relative to the Earth [rad/s].
earth::Position point_position(const NavigationState& state, const Eigen::Vector3d& lever_arm);
Eigen::Vector3d point_velocity(const NavigationState& state, const Eigen::Vector3d& omega_eb_b,
                               const Eigen::Vector3d& lever_arm);

}  // namespace truenorth
