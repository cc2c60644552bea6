#include "components/gnss_input.hpp"

#include <cmath>

#include "components/time_tolerance.hpp"

namespace truenorth {

GnssInput::Verdict GnssInput::read(int sample, const GnssFix& fix, double now) {
    if (sample == seen_) {
        return Verdict::stale;
    }
    seen_ = sample;

    const auto& [latitude, longitude, height] = fix.position;
    if (!std::isfinite(fix.time) || !std::isfinite(latitude) || !std::isfinite(longitude) ||
        !std::isfinite(height) || !fix.velocity.allFinite()) {
        return Verdict::not_finite;
    }
    if (std::abs(latitude) > earth::kHighestLatitude || std::abs(longitude) > kLargestLongitude ||
        height < kLowest || height > kHighest || fix.velocity.norm() > kLargestSpeed) {
        return Verdict::impossible;
    }
    if (fix.time <= last_time_) {
        return Verdict::backwards;
    }
    if (fix.time > now + kTimeTolerance) {
        return Verdict::future;
    }
    last_time_ = fix.time;
    return Verdict::accepted;
}

}  // namespace truenorth
