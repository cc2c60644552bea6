#include "inertial/attitude.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "elementary/arctangent.hpp"

namespace truenorth {

double wrap_angle(double angle) {
    constexpr double turn = 2.0 * std::numbers::pi;
    if (angle >= -std::numbers::pi && angle < std::numbers::pi) {
        return angle;
    }
    // Just below an odd multiple of pi, rounding may take one turn too many.
    return std::max(angle - turn * std::floor((angle + std::numbers::pi) / turn), -std::numbers::pi);
}

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0.0, -a.z(), a.y(),  //
        a.z(), 0.0, -a.x(),   //
        -a.y(), a.x(), 0.0;
    return m;
}

Eigen::Matrix3d dcm(const EulerAngles& angles) {
    return dcm(sincos(Eigen::Array3d(angles.roll, angles.pitch, angles.heading)));
}

Eigen::Matrix3d dcm(const SineCosine<Eigen::Array3d>& angles) {
    const auto [sr, sp, sh] = std::array{angles.sine[0], angles.sine[1], angles.sine[2]};
    const auto [cr, cp, ch] = std::array{angles.cosine[0], angles.cosine[1], angles.cosine[2]};
    Eigen::Matrix3d C_bn;
    C_bn << ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr,  //
        ch * sp * sr - sh * cr, ch * cp, -sh * sr - ch * sp * cr,     //
        -cp * sr, sp, cp * cr;
    return C_bn;
}

EulerAngles euler_angles(const Eigen::Matrix3d& C_bn) {
    // Third row of C_bn: (-cos p sin r, sin p, cos p cos r); second column: (sin h cos p, cos h cos p, sin
    // p).
    const double level = std::sqrt(C_bn(2, 0) * C_bn(2, 0) + C_bn(2, 2) * C_bn(2, 2));
    const Eigen::Array3d angles = arctangent(Eigen::Array3d(-C_bn(2, 0), C_bn(2, 1), C_bn(0, 1)),
                                             Eigen::Array3d(C_bn(2, 2), level, C_bn(1, 1)));
    double heading = angles[2];
    if (heading < 0.0) {
        heading += 2.0 * std::numbers::pi;
    }
    return {.roll = angles[0],
            .pitch = angles[1],
            .heading = heading < 2.0 * std::numbers::pi
                           ? heading
                           : 0.0};  // a tiny negative one has become a whole turn
}

Eigen::Quaterniond quaternion(const Eigen::Vector3d& rotation_vector) {
    const double angle2 = rotation_vector.squaredNorm();
    // Below 1e-4 rad two terms of the series are exact to double precision, and safe at zero.
    double sine_over_angle = 0.5 - angle2 / 48.0;
    double cosine = 1.0 - angle2 / 8.0;
    if (angle2 > 1e-8) {
        const double angle = std::sqrt(angle2);
        const SineCosine<double> half = sincos(0.5 * angle);
        sine_over_angle = half.sine / angle;
        cosine = half.cosine;
    }
    const Eigen::Vector3d v = sine_over_angle * rotation_vector;
    return {cosine, v.x(), v.y(), v.z()};
}

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& q) {
    const double sign = q.w() < 0.0 ? -1.0 : 1.0;
    const double sine = q.vec().norm();
    if (sine < 1e-12) {
        return 2.0 * sign * q.vec();
    }
    return (2.0 * arctangent(sine, sign * q.w()) / sine) * sign * q.vec();
}

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
    return rotation_vector(a.conjugate() * b).norm();
}

Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double share) {
    return a * quaternion(share * rotation_vector(a.conjugate() * b));
}

Eigen::Matrix3d about_up(double angle) {
    const auto [sine, cosine] = sincos(angle);
    Eigen::Matrix3d R;
    R << cosine, -sine, 0.0,  //
        sine, cosine, 0.0,    //
        0.0, 0.0, 1.0;
    return R;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& C) { return rotation_vector(Eigen::Quaterniond(C)); }

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& rotation_vector) {
    const double angle2 = rotation_vector.squaredNorm();
    // Below 1e-3 rad two terms of the series are exact to double precision, and safe at zero.
    double first = 0.5 - angle2 / 24.0;
    double second = 1.0 / 6.0 - angle2 / 120.0;
    if (angle2 > 1e-6) {
        const double angle = std::sqrt(angle2);
        const Eigen::Array2d sine = sincos(Eigen::Array2d(0.5 * angle, angle)).sine;
        first = 2.0 * sine[0] * sine[0] / angle2;
        second = (angle - sine[1]) / (angle2 * angle);
    }
    const Eigen::Matrix3d A = skew(rotation_vector);
    return Eigen::Matrix3d::Identity() + first * A + second * A * A;
}

}  // namespace truenorth
