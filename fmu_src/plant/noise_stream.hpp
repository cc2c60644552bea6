// Random numbers of one noise source: draw number `index` is a pure function of seed, source and index.
// Switching a source off leaves all others as they were, sample for sample; there is no state to carry.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "plant/philox.hpp"

namespace truenorth::plant {

// The numbers are part of the signals: never renumber, or the same seed gives other signals.
enum class NoiseSource : std::uint8_t {
    gyro_bias = 1,
    gyro_white = 2,
    gyro_markov = 3,
    gyro_wave = 4,
    accelerometer_bias = 5,
    accelerometer_white = 6,
    accelerometer_markov = 7,
    accelerometer_wave = 8,
    gnss_position = 9,
    gnss_velocity = 10,
    gnss_position_outlier = 11,
    gnss_velocity_outlier = 12,
    gnss_outlier_epoch = 13,
    gnss_clock = 14,
    gnss_channel = 15,
    gnss_pseudorange_outlier = 16,
    gnss_range_rate_outlier = 17,
    gyro_bias_walk = 18,
    accelerometer_bias_walk = 19,
    body_velocity = 20,
    body_velocity_scale = 21,
    heading_aid = 22,
    heading_aid_bias = 23,
    height_aid = 24,
    height_aid_bias = 25,
    body_velocity_boresight = 26,
};

class NoiseStream {
  public:
    // `member`: number of the satellite, for sources that each satellite has for itself.
    NoiseStream(std::uint32_t seed, NoiseSource source, std::uint32_t member = 0)
        : key_{seed, static_cast<std::uint32_t>(source) | member << 8U} {}

    // Four independent numbers, uniform in (0, 1), a multiple of 2^-33.
    [[nodiscard]] Eigen::Vector4d uniform(std::uint64_t index) const;

    // Three independent numbers N(0, 1), by Box and Muller; none is larger than 6.8.
    [[nodiscard]] Eigen::Vector3d normal(std::uint64_t index) const;

  private:
    PhiloxKey key_;
};

}  // namespace truenorth::plant
