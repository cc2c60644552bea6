// The GNSS antenna at a lever arm from the IMU.
#pragma once

#include "error_models/navigation_error.hpp"

namespace truenorth {

struct Antenna {
    Eigen::Matrix3d C_bn;        // C_b^{n'} at the fix
    Eigen::Vector3d lever_arm;   // from the IMU, body [m]
    Eigen::Vector3d omega_eb_b;  // body rate relative to the Earth, body [rad/s]

    // Its error, position then velocity, computed minus true, of the errors of the navigation state: the
    // misalignment turns the lever arm l' and its velocity, C l = l' + phi x l'.
    [[nodiscard]] Matrix<6, navigation_error::kCount> error_of_navigation() const {
        using namespace navigation_error;
        Matrix<6, kCount> H = Matrix<6, kCount>::Zero();
        H.block<3, 3>(0, kPhi) = skew(C_bn * lever_arm);
        H.block<3, 3>(0, kPosition).setIdentity();
        H.block<3, 3>(3, kPhi) = skew(C_bn * omega_eb_b.cross(lever_arm));
        H.block<3, 3>(3, kVelocity).setIdentity();
        return H;
    }

    // Velocity error of a gyro bias: C_b^{n'} (eps x l).
    [[nodiscard]] Eigen::Matrix3d velocity_error_of_gyro_bias() const { return -C_bn * skew(lever_arm); }
};

// Covariance of a GNSS position [m] and velocity [m/s], east, north, up.
inline Matrix<6> fix_covariance(const Eigen::Vector3d& position_sigma,
                                const Eigen::Vector3d& velocity_sigma) {
    Vector<6> sigma;
    sigma << position_sigma, velocity_sigma;
    return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace truenorth
