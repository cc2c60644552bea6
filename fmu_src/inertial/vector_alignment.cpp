#include "inertial/vector_alignment.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>

#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

void VectorAlignment::add(const Preintegration& interval, const Fix& fix) {
    if (count_ > 0) {
        travelled_ = travelled_ * interval;
    }
    const Eigen::Quaterniond to_first = earth::turn(-travelled_.duration);
    const Eigen::Vector3d before = gravitation_;
    gravitation_ = to_first * earth::gravitation(fix.position);
    if (count_ > 0) {
        impulse_ += 0.5 * interval.duration * (before + gravitation_);
    }
    const Eigen::Vector3d b = to_first * fix.velocity - impulse_;
    const Eigen::Vector3d a = travelled_.change.velocity + travelled_.change.attitude * fix.velocity_arm;

    ++count_;
    const Eigen::Vector3d from_mean_a = a - mean_a_;
    const Eigen::Vector3d from_mean_b = b - mean_b_;
    mean_a_ += from_mean_a / count_;
    mean_b_ += from_mean_b / count_;
    const double weight = (count_ - 1.0) / count_;
    aa_ += weight * from_mean_a * from_mean_a.transpose();
    ba_ += weight * from_mean_b * from_mean_a.transpose();
    bb_ += weight * from_mean_b.squaredNorm();
}

std::optional<VectorAlignment::Solution> VectorAlignment::solve() const {
    if (count_ < 4) {
        return std::nullopt;
    }
    // Davenport's matrix for a quaternion (x, y, z, w): q^T K q = sum of b . R a.
    Eigen::Matrix4d K;
    K.topLeftCorner<3, 3>() = ba_ + ba_.transpose() - ba_.trace() * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d z(ba_(2, 1) - ba_(1, 2), ba_(0, 2) - ba_(2, 0), ba_(1, 0) - ba_(0, 1));
    K.topRightCorner<3, 1>() = z;
    K.bottomLeftCorner<1, 3>() = z.transpose();
    K(3, 3) = ba_.trace();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(K);
    Eigen::Quaterniond attitude;
    attitude.coeffs() = eigen.eigenvectors().col(3);

    // What is left when a may have the wrong scale, as an accelerometer bias along the vertical gives it.
    const double explained = eigen.eigenvalues()(3);
    constexpr double rounding = 1e-10;  // of velocities [m/s]
    const double size = std::max(aa_.trace(), rounding * rounding);
    const double variance =
        std::max(rounding * rounding, (bb_ - explained * explained / size) / (3.0 * count_ - 7.0));

    constexpr double nothing_known = 1.0 / (kUnknownAngle * kUnknownAngle);  // about each axis
    const Eigen::Matrix3d R = attitude.toRotationMatrix();
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d information =
        (aa_.trace() * I - R * aa_ * R.transpose()) / variance + nothing_known * I;
    const Eigen::Quaterniond to_now = earth::turn(travelled_.duration);
    return Solution{.at_first_fix = attitude,
                    .attitude = to_now * attitude * travelled_.change.attitude,
                    .covariance = to_now * information.inverse() * to_now.conjugate()};
}

Eigen::Quaterniond VectorAlignment::at_first_fix(const Eigen::Quaterniond& attitude,
                                                 const Eigen::Matrix<double, 6, 1>& bias) const {
    const Eigen::Quaterniond turned = travelled_.corrected(bias).attitude;
    return (earth::turn(-travelled_.duration) * attitude * turned.conjugate()).normalized();
}

}  // namespace truenorth
