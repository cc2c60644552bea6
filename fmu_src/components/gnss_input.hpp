// Reads a GNSS port: decides whether its fix is new, stale or impossible.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "inertial/earth.hpp"

namespace truenorth {

struct GnssFix {
    double time = 0.0;
    earth::Position position;                            // of the antenna
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the antenna, ENU [m/s]
};

class GnssInput {
  public:
    enum class Verdict { stale, accepted, not_finite, impossible, backwards, future };

    static constexpr double kLargestLongitude = 6.3;  // a turn either way [rad]
    static constexpr double kLowest = -15e3;          // [m]
    static constexpr double kHighest = 100e3;         // [m]
    static constexpr double kLargestSpeed = 10e3;     // [m/s]

    void start() { *this = GnssInput{}; }

    // `now` is the time to which the IMU data reach; a fix may be older, not younger.
    Verdict read(int sample, const GnssFix& fix, double now);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(seen_, last_time_);
    }

  private:
    int seen_ = 0;
    double last_time_ = std::numeric_limits<double>::lowest();
};

}  // namespace truenorth
