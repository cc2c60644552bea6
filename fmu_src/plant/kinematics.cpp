#include "plant/kinematics.hpp"

namespace truenorth::plant {

Turning turning(const SineCosine<Eigen::Array3d>& angles, const EulerAngles& rates) {
    const Eigen::Matrix3d C_bn = dcm(angles);
    // Heading turns about -up of n, pitch about the right axis before roll, roll about forward of b.
    const Eigen::Vector3d right_before_roll(angles.cosine[0], 0.0, angles.sine[0]);
    return {.C_bn = C_bn,
            .omega_nb_b = -rates.heading * C_bn.row(2).transpose() + rates.pitch * right_before_roll +
                          rates.roll * Eigen::Vector3d::UnitY()};
}

}  // namespace truenorth::plant
