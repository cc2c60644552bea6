#include "components/gnss_input.hpp"

#include <algorithm>
#include <cmath>

namespace truenorth {

namespace {

GnssFix::Components components(const GnssFix& fix) {
    GnssFix::Components all;
    all << fix.position.longitude, fix.position.latitude, fix.position.height, fix.velocity;
    return all;
}

// Something is measured, and nothing of it infinite, nor without bounds as its sigma says.
bool finite(const GnssFix& fix) {
    const GnssFix::Mask measured = fix.measured();
    return std::isfinite(fix.time) && (measured.any() || fix.has_channels) &&
           !components(fix).isInf().any() && measured.select(fix.sigma, 0.0).isFinite().all();
}

// What is no number is no more than any limit.
bool impossible(const GnssFix& fix) {
    const auto& [latitude, longitude, height] = fix.position;
    const GnssFix::Mask measured = fix.measured();
    return std::abs(latitude) > earth::kHighestLatitude ||
           std::abs(longitude) > GnssInput::kLargestLongitude || height < GnssInput::kLowest ||
           height > GnssInput::kHighest || measured.select(fix.sigma, 0.0).minCoeff() < 0.0 ||
           measured.select(components(fix), 0.0).tail<3>().matrix().norm() > GnssInput::kLargestSpeed;
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace

GnssFix::Mask GnssFix::measured() const { return !components(*this).isNaN(); }

GnssFix GnssFix::filled_from(const earth::Position& place, const Eigen::Vector3d& speed) const {
    const auto or_else = [](double value, double other) { return std::isnan(value) ? other : value; };
    GnssFix filled = *this;
    filled.position = {.latitude = or_else(position.latitude, place.latitude),
                       .longitude = or_else(position.longitude, place.longitude),
                       .height = or_else(position.height, place.height)};
    filled.velocity = velocity.array().isNaN().select(speed, velocity);
    return filled;
}

// To the bit the same place as before, at a speed: a receiver that hangs. One that stands on a stand may
// repeat itself.
bool GnssInput::repeats(const GnssFix& fix) const {
    const GnssFix last{.position = last_position_, .velocity = last_velocity_};
    const GnssFix::Components now = components(fix);
    const GnssFix::Components before = components(last);
    const bool moves = (fix.velocity.array().abs() > 0.0).any();
    const bool placed = !std::isnan(fix.position.latitude) && !std::isnan(fix.position.longitude);
    return moves && placed && std::equal(now.begin(), now.end(), before.begin(), same);
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
    switch (clock_.read(fix.time, moment)) {
        case StampClock::Verdict::backwards:
            return Verdict::backwards;
        case StampClock::Verdict::future:
            return Verdict::future;
        case StampClock::Verdict::late:
            return Verdict::late;
        case StampClock::Verdict::accepted:
            break;
    }
    any_ = true;
    return Verdict::accepted;
}

}  // namespace truenorth
