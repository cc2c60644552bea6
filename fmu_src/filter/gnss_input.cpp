#include "filter/gnss_input.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace truenorth {

namespace {

GnssFix::Components components(const GnssFix& fix) {
    GnssFix::Components all;
    all << fix.position.longitude, fix.position.latitude, fix.position.height, fix.velocity;
    return all;
}

// Nothing that is measured is infinite, nor its sigma.
bool finite(const GnssFix& fix) {
    return std::isfinite(fix.time) && !components(fix).isInf().any() &&
           fix.measured().select(fix.sigma, 0.0).isFinite().all();
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

// A receiver on a stand may repeat itself. One that hangs does so at a speed, its own or, if it measures
// none, that of the vehicle; and of one that measures no place nothing is known.
bool may_stand(const GnssFix& fix, double speed) {
    constexpr double kStands = 1.0;  // as far as a filter knows [m/s]
    const GnssFix::Mask measured = fix.measured();
    const GnssFix::Mask moving = measured && components(fix) != 0.0;
    const bool moves = measured.tail<3>().any() ? moving.tail<3>().any() : speed > kStands;
    return !moves || !measured(0) || !measured(1);
}

}  // namespace

GnssFix::Mask GnssFix::measured() const {
    Components worst;
    worst << kWorstPlace, kWorstPlace, kWorstPlace, kWorstSpeed, kWorstSpeed, kWorstSpeed;
    return !components(*this).isNaN() && !(sigma > worst && sigma.isFinite());
}

GnssFix GnssFix::filled_from(const earth::Position& place, const Eigen::Vector3d& speed) const {
    const Mask is = measured();
    GnssFix filled = *this;
    filled.position = {.latitude = is(1) ? position.latitude : place.latitude,
                       .longitude = is(0) ? position.longitude : place.longitude,
                       .height = is(2) ? position.height : place.height};
    filled.velocity = is.tail<3>().select(velocity, speed);
    return filled;
}

// To the bit what was measured before.
bool GnssInput::repeats(const GnssFix& fix) const {
    const GnssFix last{.position = last_position_, .velocity = last_velocity_};
    const GnssFix::Components now = components(fix);
    const GnssFix::Components before = components(last);
    return std::equal(now.begin(), now.end(), before.begin(), same);
}

GnssInput::Verdict GnssInput::read(int sample, const GnssFix& fix, const Moment& moment, double speed,
                                   bool uncounted) {
    if (fix.has_channels) {  // whose values are not of the fix
        sample = arrival_.number(sample, fix.time, std::array{fix.time}, uncounted);
    } else {
        sample = arrival_.number(sample, fix.time, components(fix), uncounted);
    }
    if (sample == seen_) {
        return Verdict::stale;
    }
    seen_ = sample;
    if (!finite(fix)) {
        return Verdict::not_finite;
    }
    if (!fix.measured().any() && !fix.has_channels) {
        return Verdict::empty;
    }
    if (impossible(fix)) {
        return Verdict::impossible;
    }
    const bool frozen = any_ && repeats(fix) && !may_stand(fix, speed);
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
