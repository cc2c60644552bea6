// When a measurement was valid by the filter's clock, from its stamp.
//
// A sensor's clock can be set, alone or together with the IMU's (a leap second), or be another one from the
// beginning. A stamp from the future, or not after the last one, or far later than those before, is refused;
// when a few in a row agree on how far the clock is off, they are believed, and measurements count as as old
// as they were before; the first ones as of now. Where stamps lie before all that the filter remembers, and
// did not use to, a slow link may be to blame, or a queue that is cleared: only after a minute is it the
// clock, as of two clocks that have run apart.
#pragma once

#include <cstdint>
#include <limits>

namespace truenorth {

class StampClock {
  public:
    enum class Verdict : std::uint8_t { accepted, backwards, future, late };

    // A measurement is at most this much younger than the clock says; a sensor and the IMU are never read at
    // once [s].
    static constexpr double kAhead = 0.1;

    // When it is read: by the filter's clock, of which `offset` is that of the IMU's stamps; `slack` is how
    // long the IMU takes to the next sample, `oldest` when the memory of the filter begins [s].
    struct Moment {
        double now = 0.0;
        double offset = 0.0;
        double slack = 0.0;
        double oldest = std::numeric_limits<double>::lowest();
    };

    Verdict read(double stamp, const Moment& moment);

    // When the last accepted measurement was valid, by the filter's clock [s].
    [[nodiscard]] double valid_at() const { return valid_at_; }
    [[nodiscard]] int disagreements() const { return disagreements_; }  // with the filter's

    template <class Archive>
    void serialize(Archive& archive) {
        archive(last_stamp_, valid_at_, offset_, imu_offset_, latency_, quickest_, forgotten_, ahead_,
                strays_, disagreements_);
    }

  private:
    bool strays_alike(double ahead);

    double last_stamp_ = std::numeric_limits<double>::lowest();  // that was accepted [s]
    double valid_at_ = 0.0;
    double offset_ = 0.0;      // from the filter's clock [s]
    double imu_offset_ = 0.0;  // of the IMU's clock at the last accepted stamp [s]
    double latency_ = 0.0;     // of the last accepted measurement [s]
    double quickest_ = std::numeric_limits<double>::infinity();  // latency of those that could be used [s]
    // Since when stamps have been from before all that is remembered, by the filter's clock; infinite: they
    // are not [s].
    double forgotten_ = std::numeric_limits<double>::infinity();
    double ahead_ = 0.0;  // how far ahead of the filter's clock the last refused stamp was [s]
    int strays_ = 0;      // refused stamps in a row that agree on it
    int disagreements_ = 0;
};

}  // namespace truenorth
