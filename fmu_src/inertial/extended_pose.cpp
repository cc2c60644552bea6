#include "inertial/extended_pose.hpp"

#include <Eigen/LU>
#include <cmath>

#include "inertial/attitude.hpp"

namespace truenorth {

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& rotation_vector) {
    const double angle2 = rotation_vector.squaredNorm();
    // Below 1e-3 rad two terms of the series are exact to double precision, and safe at zero.
    double first = 0.5 - angle2 / 24.0;
    double second = 1.0 / 6.0 - angle2 / 120.0;
    if (angle2 > 1e-6) {
        const double angle = std::sqrt(angle2);
        first = 2.0 * std::pow(std::sin(0.5 * angle), 2) / angle2;
        second = (angle - std::sin(angle)) / (angle2 * angle);
    }
    const Eigen::Matrix3d A = skew(rotation_vector);
    return Eigen::Matrix3d::Identity() + first * A + second * A * A;
}

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
