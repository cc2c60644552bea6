// Aids besides the receiver: a log or an odometer, a heading, a height. Each measures at its rate, with white
// noise and an error that is drawn once a run.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "plant/noise_stream.hpp"
#include "plant/time_window.hpp"

namespace truenorth::plant {

// When a sensor measures; the same for all.
struct AidSchedule {
    std::uint64_t periods = 0;  // IMU samples from one measurement to the next; 0: it measures nothing
    TimeWindow outage;

    // The number (1, 2, ...; lost ones count) of the measurement that is valid at this IMU sample, if it is
    // one.
    [[nodiscard]] std::optional<std::uint64_t> number(std::uint64_t sample, double time) const {
        const bool due = periods > 0 && sample % periods == 0;
        return due && !outage.contains(time) ? std::optional(sample / periods) : std::nullopt;
    }
};

// Velocity of a point of the body, right, forward, up.
class BodyVelocitySensor {
  public:
    struct Errors {
        Eigen::Vector3d sigma;            // of the white noise [m/s]
        double scale_sigma;               // of the scale factor [-]
        Eigen::Vector3d boresight_sigma;  // of its axes against the body's [rad]
    };

    BodyVelocitySensor(const Errors& errors, std::uint32_t seed);

    [[nodiscard]] Eigen::Vector3d measure(std::uint64_t number, const Eigen::Vector3d& truth) const;

  private:
    Eigen::Vector3d sigma_;
    double scale_;
    Eigen::Matrix3d axes_;  // body to sensor
    NoiseStream noise_;
};

// A heading [rad] or a height [m].
class ScalarSensor {
  public:
    struct Errors {
        double sigma;       // of the white noise
        double bias_sigma;  // of the bias
    };
    struct Sources {
        NoiseSource noise;
        NoiseSource bias;
    };

    ScalarSensor(const Errors& errors, const Sources& sources, std::uint32_t seed);

    [[nodiscard]] double measure(std::uint64_t number, double truth) const;

  private:
    double sigma_;
    double bias_;
    NoiseStream noise_;
};

}  // namespace truenorth::plant
