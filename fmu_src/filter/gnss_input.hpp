// Reads a GNSS port: decides whether its fix is new, sound and in time (stamp_clock.hpp).
#pragma once

#include <Eigen/Core>

#include "filter/arrival.hpp"
#include "filter/stamp_clock.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

// Position and velocity of the antenna; what is not a number, or has a sigma that says that nothing is known
// of it, as receivers without a fix put out, has not been measured.
struct GnssFix {
    // East, north, up: of the position, then of the velocity.
    using Components = Eigen::Array<double, 6, 1>;
    using Mask = Eigen::Array<bool, 6, 1>;

    static constexpr double kWorstPlace = 10e3;   // [m]
    static constexpr double kWorstSpeed = 100.0;  // [m/s]

    double time = 0.0;
    earth::Position position;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // ENU [m/s]
    Components sigma = Components::Zero();               // of this fix [m], [m/s]; 0: not told
    bool has_channels = false;                           // and measurements to satellites besides

    [[nodiscard]] Mask measured() const;
    [[nodiscard]] bool complete() const { return measured().all(); }

    // With what has not been measured taken from elsewhere.
    [[nodiscard]] GnssFix filled_from(const earth::Position& place, const Eigen::Vector3d& speed) const;
};

class GnssInput {
  public:
    enum class Verdict { stale, accepted, not_finite, empty, impossible, frozen, backwards, future, late };

    static constexpr double kLargestLongitude = 6.3;  // a turn either way [rad]
    static constexpr double kLowest = -15e3;          // [m]
    static constexpr double kHighest = 100e3;         // [m]
    static constexpr double kLargestSpeed = 10e3;     // [m/s]
    using Moment = StampClock::Moment;

    void start() { *this = GnssInput{}; }

    // Whether the count says that no fix came since the last reading.
    [[nodiscard]] bool is_read(int sample, bool uncounted) {
        return !uncounted && arrival_.number(sample) == seen_;
    }

    // `speed` is that of the vehicle as far as the filter knows [m/s]; `uncounted` as of `Arrival`.
    Verdict read(int sample, const GnssFix& fix, const Moment& moment, double speed = 0.0,
                 bool uncounted = false);

    [[nodiscard]] Arrival& arrival() { return arrival_; }  // how fixes come

    // When the last accepted fix was valid, by the filter's clock [s].
    [[nodiscard]] double valid_at() const { return clock_.valid_at(); }
    [[nodiscard]] int disagreements() const {
        return clock_.disagreements();
    }  // of its clock with the filter's

    template <class Archive>
    void serialize(Archive& archive) {
        archive(seen_, any_, last_position_, last_velocity_, clock_, arrival_);
    }

  private:
    [[nodiscard]] bool repeats(const GnssFix& fix) const;

    int seen_ = 0;
    bool any_ = false;  // a fix has been accepted

    earth::Position last_position_;  // of the last sound one
    Eigen::Vector3d last_velocity_ = Eigen::Vector3d::Zero();
    StampClock clock_;
    Arrival arrival_;
};

}  // namespace truenorth
