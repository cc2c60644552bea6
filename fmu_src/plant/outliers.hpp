// Gross errors of a receiver.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "plant/noise_stream.hpp"

namespace truenorth::plant {

// With `probability`, every component is off by `size` in addition, each with a random sign.
struct Outliers {
    double probability = 0.0;
    double size = 0.0;

    [[nodiscard]] Eigen::Vector3d draw(const NoiseStream& stream, std::uint64_t fix) const;
};

// With `probability` a fix is an outlier epoch; in it each of six components is off with
// `channel_probability`, by a multiple of its sigma that is uniform between `least` and `largest`, with a
// random sign.
struct OutlierEpochs {
    double probability = 0.0;
    double channel_probability = 0.0;
    double least = 0.0;    // [sigma]
    double largest = 0.0;  // [sigma]

    // [sigma]
    [[nodiscard]] Eigen::Matrix<double, 6, 1> draw(const NoiseStream& stream, std::uint64_t fix) const;
};

}  // namespace truenorth::plant
