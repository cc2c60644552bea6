// Three sinusoids, amplitude sin(2 pi frequency t + phase), and their derivatives.
#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>

#include "elementary/sincos.hpp"

namespace truenorth::plant {

struct Oscillation {
    Eigen::Vector3d amplitude;
    Eigen::Vector3d frequency;  // [Hz]
    Eigen::Vector3d phase;      // [rad]

    struct Instant {
        Eigen::Vector3d value;
        Eigen::Vector3d rate;  // [1/s]
    };
};

// Two of them; one pass for all sines and cosines is cheaper than two.
inline std::array<Oscillation::Instant, 2> at(double time, const Oscillation& first,
                                              const Oscillation& second) {
    using Six = Eigen::Array<double, 6, 1>;
    Six amplitude;
    Six frequency;
    Six phase;
    amplitude << first.amplitude, second.amplitude;
    frequency << first.frequency, second.frequency;
    phase << first.phase, second.phase;
    const Six omega = 2.0 * std::numbers::pi * frequency;
    const auto [sine, cosine] = sincos(Six(omega * time + phase));
    const Six value = amplitude * sine;
    const Six rate = amplitude * omega * cosine;
    return {{{.value = value.head<3>(), .rate = rate.head<3>()},
             {.value = value.tail<3>(), .rate = rate.tail<3>()}}};
}

}  // namespace truenorth::plant
