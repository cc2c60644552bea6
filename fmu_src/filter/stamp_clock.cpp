#include "filter/stamp_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contract/count_up.hpp"
#include "contract/time_tolerance.hpp"

namespace truenorth {

namespace {

constexpr int kStraysAlike = 3;  // stamps in a row that show the same before it is believed
constexpr double kAlike = 0.1;   // [s]
// A measurement that comes by so much later than those before is by another clock: nothing waits so long [s].
constexpr double kLate = 10.0;
// A link is slow, or has a queue to clear, for less [s].
constexpr double kSlow = 60.0;

}  // namespace

// Whether so many stamps in a row have been off by the same that they are right by another clock.
bool StampClock::strays_alike(double ahead) {
    strays_ = strays_ > 0 && std::abs(ahead - ahead_) < kAlike ? strays_ + 1 : 1;
    ahead_ = ahead;
    count_up(disagreements_);
    return strays_ >= kStraysAlike;
}

StampClock::Verdict StampClock::read(double stamp, const Moment& moment) {
    // If the IMU's clock has been set since the last stamp, this one may have been set with it.
    const double ahead = stamp - offset_ - moment.now;
    const double set = moment.offset - imu_offset_;
    const bool together = set != 0.0 && std::abs(ahead - set + latency_) < std::abs(ahead + latency_);
    const bool back = stamp <= last_stamp_;
    const bool future = ahead > kTimeTolerance + std::max(moment.slack, kAhead);
    const bool late = ahead + latency_ < -kLate;
    const bool forgotten = stamp - offset_ < moment.oldest && ahead + quickest_ < -kAlike;
    if (together) {
        offset_ += set;
    } else if (back || future || late) {
        if (!strays_alike(ahead)) {
            if (back) {
                return Verdict::backwards;
            }
            return future ? Verdict::future : Verdict::late;
        }
        offset_ += ahead + latency_;
    } else if (forgotten) {
        forgotten_ = std::min(forgotten_, moment.now);
        if (moment.now - forgotten_ < kSlow) {
            return Verdict::late;
        }
        count_up(disagreements_);
        offset_ += ahead + quickest_;
    }
    forgotten_ = std::numeric_limits<double>::infinity();
    strays_ = 0;
    imu_offset_ = moment.offset;
    last_stamp_ = stamp;
    valid_at_ = stamp - offset_;
    latency_ = moment.now - valid_at_;
    if (valid_at_ >= moment.oldest) {
        quickest_ = std::min(quickest_, latency_);
    }
    return Verdict::accepted;
}

}  // namespace truenorth
