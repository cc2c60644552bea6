#include "plant/kinematics.hpp"

#include <cmath>

namespace truenorth::plant {

Eigen::Vector3d body_rate(const EulerAngles& angles, const EulerAngles& rates, const Eigen::Matrix3d& C_bn) {
    // Heading turns about -up of n, pitch about the right axis before roll, roll about forward of b.
    const Eigen::Vector3d right_before_roll(std::cos(angles.roll), 0.0, std::sin(angles.roll));
    return -rates.heading * C_bn.row(2).transpose() + rates.pitch * right_before_roll +
           rates.roll * Eigen::Vector3d::UnitY();
}

}  // namespace truenorth::plant
