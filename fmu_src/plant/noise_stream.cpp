#include "plant/noise_stream.hpp"

#include <cmath>
#include <numbers>

#include "elementary/logarithm.hpp"
#include "elementary/sincos.hpp"

namespace truenorth::plant {

Eigen::Vector4d NoiseStream::uniform(std::uint64_t index) const {
    const PhiloxCounter bits =
        philox({static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32U), 0, 0}, key_);
    constexpr double unit = 0x1p-32;
    return {(bits[0] + 0.5) * unit, (bits[1] + 0.5) * unit, (bits[2] + 0.5) * unit, (bits[3] + 0.5) * unit};
}

Eigen::Vector3d NoiseStream::normal(std::uint64_t index) const {
    const Eigen::Vector4d u = uniform(index);
    const double radius_0 = std::sqrt(-2.0 * logarithm(u[0]));
    const double radius_1 = std::sqrt(-2.0 * logarithm(u[2]));
    const auto [sine, cosine] = sincos(2.0 * std::numbers::pi * Eigen::Array2d(u[1], u[3]));
    return {radius_0 * cosine[0], radius_0 * sine[0], radius_1 * cosine[1]};
}

}  // namespace truenorth::plant
