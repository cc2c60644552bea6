// A GNSS receiver that puts out position and velocity: white noise whose level may change over time,
// outliers, outages. Components east, north, up.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "inertial/earth.hpp"
#include "plant/noise_stream.hpp"

namespace truenorth::plant {

struct Fix {
    double time = 0.0;  // of validity [s]
    earth::Position position;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // [m/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(time, position, velocity);
    }
};

// begin <= time < end [s].
struct TimeWindow {
    double begin = 0.0;
    double end = 0.0;

    [[nodiscard]] bool contains(double time) const { return begin <= time && time < end; }
};

// Factor on all sigmas: a step in one window, 1 + amplitude sin(2 pi (t - begin) / period) in another (Jing
// 2023, eq. 21).
struct NoiseScale {
    double step_factor = 1.0;
    TimeWindow step;
    double sine_amplitude = 0.0;
    double sine_period = 1.0;  // [s]
    TimeWindow sine;

    [[nodiscard]] double at(double time) const;
};

// With `probability`, every component is off by `size` in addition, each with a random sign.
struct Outliers {
    double probability = 0.0;
    double size = 0.0;

    [[nodiscard]] Eigen::Vector3d draw(const NoiseStream& stream, std::uint64_t fix) const;
};

class GnssReceiver {
  public:
    struct Errors {
        Eigen::Vector3d position_sigma = Eigen::Vector3d::Zero();  // [m]
        Eigen::Vector3d velocity_sigma = Eigen::Vector3d::Zero();  // [m/s]
        Outliers position_outliers;                                // [m]
        Outliers velocity_outliers;                                // [m/s]
        NoiseScale noise_scale;
        std::array<TimeWindow, 4> outages{};
    };

    GnssReceiver(Errors errors, std::uint32_t seed);

    // True when a fix valid at `time` would be lost.
    [[nodiscard]] bool lost(double time) const;

    // What the receiver makes of the antenna's true state, as fix number `fix` (1, 2, ...; lost ones count).
    [[nodiscard]] Fix measure(std::uint64_t fix, const Fix& truth) const;

  private:
    Errors errors_;
    NoiseStream position_;
    NoiseStream velocity_;
    NoiseStream position_outlier_;
    NoiseStream velocity_outlier_;
};

}  // namespace truenorth::plant
