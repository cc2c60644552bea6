#include "inertial/extended_pose.hpp"

#include <Eigen/LU>
#include <cmath>

#include "inertial/attitude.hpp"

namespace truenorth {

ExtendedPose ExtendedPose::exponential(const Tangent& tangent) {
    const Eigen::Vector3d rotation = tangent.head<3>();
    const Eigen::Matrix3d J = left_jacobian(rotation);
    return {.attitude = quaternion(rotation),
            .velocity = J * tangent.segment<3>(3),
            .position = J * tangent.tail<3>()};
}

ExtendedPose::Tangent ExtendedPose::logarithm() const {
    const Eigen::Vector3d rotation = rotation_vector(attitude);
    const Eigen::Matrix3d J_inverse = left_jacobian(rotation).inverse();
    Tangent tangent;
    tangent << rotation, J_inverse * velocity, J_inverse * position;
    return tangent;
}

ExtendedPose ExtendedPose::inverse() const {
    const Eigen::Quaterniond back = attitude.conjugate();
    return {.attitude = back, .velocity = -(back * velocity), .position = -(back * position)};
}

ExtendedPose operator*(const ExtendedPose& a, const ExtendedPose& b) {
    return {.attitude = (a.attitude * b.attitude).normalized(),
            .velocity = a.velocity + a.attitude * b.velocity,
            .position = a.position + a.attitude * b.position};
}

}  // namespace truenorth
