#include "components/gnss_input.hpp"

#include <algorithm>
#include <cmath>

#include "components/time_tolerance.hpp"

namespace truenorth {

namespace {

constexpr int kConfirmations = 3;  // stamps in a row that show the same before it is believed
constexpr double kAlike = 0.1;     // [s]

bool finite(const GnssFix& fix) {
    const auto& [latitude, longitude, height] = fix.position;
    return std::isfinite(fix.time) && std::isfinite(latitude) && std::isfinite(longitude) &&
           std::isfinite(height) && fix.velocity.allFinite();
}

bool impossible(const GnssFix& fix) {
    const auto& [latitude, longitude, height] = fix.position;
    return std::abs(latitude) > earth::kHighestLatitude ||
           std::abs(longitude) > GnssInput::kLargestLongitude || height < GnssInput::kLowest ||
           height > GnssInput::kHighest || fix.velocity.norm() > GnssInput::kLargestSpeed;
}

}  // namespace

// To the bit the same place as before, at a speed: a receiver that hangs. One that stands on a stand may
// repeat itself.
bool GnssInput::repeats(const GnssFix& fix) const {
    return fix.position.latitude == last_position_.latitude &&
           fix.position.longitude == last_position_.longitude &&
           fix.position.height == last_position_.height && fix.velocity == last_velocity_ &&
           !fix.velocity.isZero(0.0);
}

// Whether so many stamps in a row have been off by the same that they are right by another clock.
bool GnssInput::strays_alike(double ahead) {
    strays_ = strays_ > 0 && std::abs(ahead - ahead_) < kAlike ? strays_ + 1 : 1;
    ahead_ = ahead;
    disagreements_ = std::min(disagreements_, std::numeric_limits<int>::max() - 1) + 1;
    return strays_ >= kConfirmations;
}

GnssInput::Verdict GnssInput::read(int sample, const GnssFix& fix, const Moment& moment) {
    if (sample == seen_) {
        return Verdict::stale;
    }
    seen_ = sample;
    if (!finite(fix)) {
        return Verdict::not_finite;
    }
    if (impossible(fix)) {
        return Verdict::impossible;
    }
    const bool frozen = any_ && repeats(fix);
    last_position_ = fix.position;
    last_velocity_ = fix.velocity;
    if (frozen) {
        return Verdict::frozen;
    }
    // If the IMU's clock has been set since the last fix, this one may have been set with it.
    const double ahead = fix.time - offset_ - moment.now;
    const double set = moment.offset - imu_offset_;
    const bool together = set != 0.0 && std::abs(ahead - set + latency_) < std::abs(ahead + latency_);
    const bool back = fix.time <= last_time_;
    const bool future = ahead > kTimeTolerance + std::max(moment.slack, kAhead);
    if (together) {
        offset_ += set;
    } else if (back || future) {
        if (!strays_alike(ahead)) {
            return back ? Verdict::backwards : Verdict::future;
        }
        offset_ += ahead + latency_;
    }
    strays_ = 0;
    any_ = true;
    imu_offset_ = moment.offset;
    last_time_ = fix.time;
    valid_at_ = fix.time - offset_;
    latency_ = moment.now - valid_at_;
    return Verdict::accepted;
}

}  // namespace truenorth
