// The group SE_2(3) of extended poses: attitude, velocity and position of a body in one element (Barrau and
// Bonnabel 2017).
//
// As 5 x 5 matrices its elements are [R v p; 0 1 0; 0 0 1], and multiply so. Tangent vectors are [rotation
// vector, velocity, position], three components each.
#pragma once

#include <Eigen/Geometry>

namespace truenorth {

struct ExtendedPose {
    using Tangent = Eigen::Matrix<double, 9, 1>;

    Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();

    // Exponential map, for any rotation vector, and its inverse for rotations of less than pi.
    static ExtendedPose exponential(const Tangent& tangent);
    [[nodiscard]] Tangent logarithm() const;

    [[nodiscard]] ExtendedPose inverse() const;
    friend ExtendedPose operator*(const ExtendedPose& a, const ExtendedPose& b);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(attitude, velocity, position);
    }
};

}  // namespace truenorth
