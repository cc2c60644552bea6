#include "filter/filter_status.hpp"

#include <cmath>

#include "contract/time_tolerance.hpp"

namespace truenorth {

void FilterStatus::start(double clock) {
    *this = FilterStatus{};
    last_use_ = clock;
}

void FilterStatus::use_fix(double clock) {
    last_use_ = clock;
    used_ = true;
}

// What keeps a filter from being believed, the gravest first; aligning if nothing does.
FilterStatus::State FilterStatus::hindrance(double clock, const Evidence& evidence,
                                            const Rules& rules) const {
    if (faulted_) {
        return State::faulted;
    }
    if (!evidence.sensing || !used_) {
        return State::waiting;
    }
    if (evidence.silent) {
        return State::silent;
    }
    if (since_fix(clock) > rules.coasting_delay + kTimeTolerance) {
        return State::coasting;
    }
    if (evidence.coarse) {
        return State::coarse;
    }
    if (evidence.recovering) {
        return State::recovering;
    }
    if (evidence.suspect) {
        return State::suspect;
    }
    return evidence.consistent ? State::aligning : State::inconsistent;
}

FilterStatus::State FilterStatus::judge(double clock, const Evidence& evidence, const Rules& rules) {
    const State state = hindrance(clock, evidence, rules);
    const bool known = evidence.measured && evidence.heading_sigma < rules.heading_sigma;
    if (state != State::aligning || !known) {
        below_since_ = std::numeric_limits<double>::quiet_NaN();
        return state;
    }
    if (std::isnan(below_since_)) {
        below_since_ = clock;
    }
    // A master that adds up its steps must get what one that multiplies them gets.
    const bool held = clock - below_since_ >= rules.hold_time - kTimeTolerance;
    return held ? State::converged : State::aligning;
}

}  // namespace truenorth
