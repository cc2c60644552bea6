// Three sinusoids, amplitude sin(2 pi frequency t + phase), and their derivatives.
#pragma once

#include <Eigen/Core>
#include <numbers>

namespace truenorth::plant {

struct Oscillation {
    Eigen::Vector3d amplitude;
    Eigen::Vector3d frequency;  // [Hz]
    Eigen::Vector3d phase;      // [rad]

    struct Instant {
        Eigen::Vector3d value;
        Eigen::Vector3d rate;  // [1/s]
    };

    [[nodiscard]] Instant at(double time) const {
        const Eigen::Array3d omega = 2.0 * std::numbers::pi * frequency.array();
        const Eigen::Array3d angle = omega * time + phase.array();
        return {.value = amplitude.array() * angle.sin(), .rate = amplitude.array() * omega * angle.cos()};
    }
};

}  // namespace truenorth::plant
