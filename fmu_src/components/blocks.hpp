// Where each error model keeps what the interface of a filter names.
#pragma once

#include "error_models/euler_platform.hpp"
#include "error_models/large_azimuth.hpp"

namespace truenorth {

// Consecutive states: the first of them and how many; none where the model lacks the quantity.
struct Block {
    int first = 0;
    int count = 0;
};

template <class Model>
struct Blocks;

template <>
struct Blocks<LargeAzimuth> {
    static constexpr Block attitude{.first = LargeAzimuth::kPhiEast, .count = 3};
    static constexpr Block velocity{.first = LargeAzimuth::kVelocityEast, .count = 2};
    static constexpr Block gyro{.first = LargeAzimuth::kGyroX, .count = 3};
    static constexpr Block accelerometer{.first = LargeAzimuth::kAccelerometerX, .count = 2};
};

template <>
struct Blocks<EulerPlatform> {
    static constexpr Block attitude{.first = EulerPlatform::kAlphaX, .count = 3};
    static constexpr Block velocity{.first = EulerPlatform::kVelocityEast, .count = 3};
    static constexpr Block gyro{};
    static constexpr Block accelerometer{};
};

// The three components of a block; those that the model lacks are `absent`.
template <int N>
Eigen::Vector3d components(const Vector<N>& x, Block block, double absent = 0.0) {
    Eigen::Vector3d v = Eigen::Vector3d::Constant(absent);
    v.head(block.count) = x.segment(block.first, block.count);
    return v;
}

}  // namespace truenorth
