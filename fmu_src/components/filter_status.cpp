#include "components/filter_status.hpp"

#include <cmath>

namespace truenorth {

void FilterStatus::start(double time) {
    *this = FilterStatus{};
    last_use_ = time;
}

void FilterStatus::use_fix(double time) {
    last_use_ = time;
    used_ = true;
}

FilterStatus::State FilterStatus::judge(double now, const Evidence& evidence, const Rules& rules) {
    const bool waits = !evidence.sensing || !used_;
    const bool coasts = since_fix(now) > rules.coasting_delay;
    const bool believable = !faulted_ && !waits && !coasts && !evidence.coarse && evidence.consistent;
    if (!believable || evidence.heading_sigma >= rules.heading_sigma) {
        below_since_ = std::numeric_limits<double>::quiet_NaN();
    } else if (std::isnan(below_since_)) {
        below_since_ = now;
    }
    if (faulted_) {
        return State::faulted;
    }
    if (waits) {
        return State::waiting;
    }
    if (coasts) {
        return State::coasting;
    }
    if (evidence.coarse) {
        return State::coarse;
    }
    if (!evidence.consistent) {
        return State::inconsistent;
    }
    return now - below_since_ >= rules.hold_time ? State::converged : State::aligning;
}

}  // namespace truenorth
