// Attitude: rotation vectors, Euler angles, small conveniences on SO(3).
//
// C_bn maps body (right, forward, up) to navigation (east, north, up) components: v_n = C_bn v_b.
// Heading is clockwise from north, pitch about the right axis (bow up positive), roll about the forward
// axis (right side down positive): C_bn = C_z(-heading) C_x(pitch) C_y(roll) as active rotations.
#pragma once

#include <Eigen/Geometry>
#include <numbers>

#include "elementary/sincos.hpp"

namespace truenorth {

// Euler angles [rad]; heading in [0, 2 pi), pitch in [-pi/2, pi/2], roll in (-pi, pi].
struct EulerAngles {
    double roll = 0.0;
    double pitch = 0.0;
    double heading = 0.0;
};

// Sigma of an angle of which nothing is known: uniform on the circle [rad].
inline constexpr double kUnknownAngle = std::numbers::pi / std::numbers::sqrt3;

// Angle wrapped to [-pi, pi) [rad].
double wrap_angle(double angle);

// Cross-product matrix: skew(a) b = a x b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

// Body-to-navigation matrix C_bn of the Euler angles, or of the sines and cosines of roll, pitch and heading,
// and back.
Eigen::Matrix3d dcm(const EulerAngles& angles);
Eigen::Matrix3d dcm(const SineCosine<Eigen::Array3d>& angles);
EulerAngles euler_angles(const Eigen::Matrix3d& C_bn);

// Unit quaternion of a rotation vector [rad]: v -> v rotated by |a| about a. Accurate for any |a|, 0
// included.
Eigen::Quaterniond quaternion(const Eigen::Vector3d& rotation_vector);

// Rotation vector [rad] of a unit quaternion, |a| <= pi.
Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& q);

// Angle between two attitudes [rad], and the attitude that lies between them at a share of the way, about a
// fixed axis.
double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);
Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double share);

// Rotation about the third axis, up in ENU [rad].
Eigen::Matrix3d about_up(double angle);

// Likewise, of a rotation matrix.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& C);

// J of the rotation vector a: exp(a + da) = exp(J da) exp(a) to first order, and J b is what the velocity or
// the position component b of a tangent vector of SE_2(3) becomes under the exponential map.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& rotation_vector);

}  // namespace truenorth
