// What a motion is at one instant: velocity and attitude, and their exact derivatives.
#pragma once

#include <Eigen/Core>

#include "inertial/attitude.hpp"

namespace truenorth::plant {

struct Kinematics {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // v^n, relative to the Earth [m/s]
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // dv^n/dt, of the components in n [m/s2]
    Eigen::Matrix3d C_bn = Eigen::Matrix3d::Identity();    // body (right, forward, up) to n (east, north, up)
    Eigen::Vector3d omega_nb_b = Eigen::Vector3d::Zero();  // w_nb^b, body relative to n [rad/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(velocity, acceleration, C_bn, omega_nb_b);
    }
};

// Attitude and body rate of Euler angles, given as the sines and cosines of roll, pitch and heading, whose
// derivatives are `rates`.
struct Turning {
    Eigen::Matrix3d C_bn;
    Eigen::Vector3d omega_nb_b;
};
Turning turning(const SineCosine<Eigen::Array3d>& angles, const EulerAngles& rates);

}  // namespace truenorth::plant
