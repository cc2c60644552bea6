// A motion over the WGS-84 ellipsoid, and what ideal inertial sensors on it measure:
//
//     w_ib^b = w_nb^b + C_n^b (w_ie + w_en)
//     f^b    = C_n^b (dv^n/dt + (2 w_ie + w_en) x v^n - g^n)
//
// Increments are integrals of these two over a sample interval, position is the integral of the velocity; all
// by Gauss-Lobatto quadrature with four nodes (order 6), whose end node is the begin node of the next
// interval.
#pragma once

#include <utility>

#include "inertial/earth.hpp"
#include "plant/kinematics.hpp"
#include "plant/motion.hpp"

namespace truenorth::plant {

class Trajectory {
  public:
    struct Increments {
        Eigen::Vector3d delta_angle = Eigen::Vector3d::Zero();     // integral of w_ib^b [rad]
        Eigen::Vector3d delta_velocity = Eigen::Vector3d::Zero();  // integral of f^b [m/s]

        template <class Archive>
        void serialize(Archive& archive) {
            archive(delta_angle, delta_velocity);
        }
    };

    // What is integrated, at one instant.
    struct Rates {
        Eigen::Vector3d omega_ib_b = Eigen::Vector3d::Zero();  // [rad/s]
        Eigen::Vector3d f_b = Eigen::Vector3d::Zero();         // [m/s2]
        Eigen::Vector3d position_rate =
            Eigen::Vector3d::Zero();  // latitude, longitude, height [rad/s, rad/s, m/s]

        template <class Archive>
        void serialize(Archive& archive) {
            archive(omega_ib_b, f_b, position_rate);
        }
    };

    struct State {
        double time = 0.0;  // [s]
        earth::Position start;
        Eigen::Vector3d travelled = Eigen::Vector3d::Zero();  // latitude, longitude, height since the start
        Kinematics kinematics;
        Rates rates;

        // Longitude in [-pi, pi).
        [[nodiscard]] earth::Position position() const;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(time, start, travelled, kinematics, rates);
        }
    };

    Trajectory(Motion motion, const earth::Position& start) : motion_(std::move(motion)), start_(start) {}

    [[nodiscard]] State begin(double time) const;

    // To time `to`; what the sensors measure on the way.
    Increments advance(State& state, double to) const;

  private:
    Motion motion_;
    earth::Position start_;
};

// Of a point of the body at `lever_arm` [m] from the IMU (right, forward, up): position (first order in the
// lever arm) and velocity v + C_bn (w_eb^b x l).
earth::Position displaced(const earth::Position& imu, const Kinematics& kinematics,
                          const Eigen::Vector3d& lever_arm);
Eigen::Vector3d velocity_at(const earth::Position& imu, const Kinematics& kinematics,
                            const Eigen::Vector3d& lever_arm);

}  // namespace truenorth::plant
