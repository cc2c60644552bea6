// Reads a GNSS port: decides whether its fix is new, sound and in time, and when it was valid by the filter's
// clock.
//
// A receiver's clock can be set, alone or together with the IMU's (a leap second), or be another one from the
// beginning. A fix from the future, or from before the last one, is refused; when a few in a row agree on how
// far the clock is off, they are believed, and the fixes count as as old as they were before; the first ones
// as of now.
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
    enum class Verdict { stale, accepted, not_finite, impossible, frozen, backwards, future };

    static constexpr double kLargestLongitude = 6.3;  // a turn either way [rad]
    static constexpr double kLowest = -15e3;          // [m]
    static constexpr double kHighest = 100e3;         // [m]
    static constexpr double kLargestSpeed = 10e3;     // [m/s]
    // A fix is at most this much younger than the clock says; receiver and IMU are never read at once [s].
    static constexpr double kAhead = 0.1;

    // When the fix is read: by the filter's clock, of which `offset` is that of the IMU's stamps; `slack` is
    // how long the IMU takes to the next sample [s].
    struct Moment {
        double now = 0.0;
        double offset = 0.0;
        double slack = 0.0;
    };

    void start() { *this = GnssInput{}; }

    Verdict read(int sample, const GnssFix& fix, const Moment& moment);

    // When the last accepted fix was valid, by the filter's clock [s].
    [[nodiscard]] double valid_at() const { return valid_at_; }
    [[nodiscard]] int disagreements() const { return disagreements_; }  // of its clock with the filter's

    template <class Archive>
    void serialize(Archive& archive) {
        archive(seen_, any_, last_time_, last_position_, last_velocity_, valid_at_, offset_, imu_offset_,
                latency_, ahead_, strays_, disagreements_);
    }

  private:
    [[nodiscard]] bool repeats(const GnssFix& fix) const;
    bool strays_alike(double ahead);

    int seen_ = 0;
    bool any_ = false;                                          // a fix has been accepted
    double last_time_ = std::numeric_limits<double>::lowest();  // of the last accepted fix, its stamp [s]
    earth::Position last_position_;                             // of the last finite one
    Eigen::Vector3d last_velocity_ = Eigen::Vector3d::Zero();
    double valid_at_ = 0.0;
    double offset_ = 0.0;      // of the receiver's clock from the filter's [s]
    double imu_offset_ = 0.0;  // of the IMU's clock at the last fix [s]
    double latency_ = 0.0;     // of the last accepted fix [s]
    double ahead_ = 0.0;       // how far ahead of the filter's clock the last refused stamp was [s]
    int strays_ = 0;           // refused stamps in a row that agree on it
    int disagreements_ = 0;
};

}  // namespace truenorth
