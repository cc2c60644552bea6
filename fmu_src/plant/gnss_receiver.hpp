// A GNSS receiver that puts out position and velocity: white noise whose level may change over time,
// outliers, outages. Components east, north, up.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "plant/fix.hpp"
#include "plant/noise_scale.hpp"
#include "plant/noise_stream.hpp"
#include "plant/outliers.hpp"
#include "plant/time_window.hpp"

namespace truenorth::plant {

class GnssReceiver {
  public:
    struct Errors {
        Eigen::Vector3d position_sigma = Eigen::Vector3d::Zero();  // [m]
        Eigen::Vector3d velocity_sigma = Eigen::Vector3d::Zero();  // [m/s]
        Outliers position_outliers;                                // [m]
        Outliers velocity_outliers;                                // [m/s]
        OutlierEpochs outlier_epochs;                              // of position and velocity together
        NoiseScale noise_scale;
        std::array<TimeWindow, 4> outages{};
    };

    GnssReceiver(Errors errors, std::uint32_t seed);

    // True when a fix valid at `time` would be lost.
    [[nodiscard]] bool lost(double time) const;

    // Sigmas of the noise of a fix valid at `time` [m], [m/s].
    [[nodiscard]] Eigen::Vector3d position_sigma(double time) const;
    [[nodiscard]] Eigen::Vector3d velocity_sigma(double time) const;

    // Position and velocity that the receiver makes of the antenna's true state, as fix number `fix` (1, 2,
    // ...; lost ones count).
    [[nodiscard]] Fix measure(std::uint64_t fix, const Fix& truth) const;

  private:
    Errors errors_;
    NoiseStream position_;
    NoiseStream velocity_;
    NoiseStream position_outlier_;
    NoiseStream velocity_outlier_;
    NoiseStream outlier_epoch_;
};

}  // namespace truenorth::plant
