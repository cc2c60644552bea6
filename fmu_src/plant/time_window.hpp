// begin <= time < end [s].
#pragma once

#include <limits>

namespace truenorth::plant {

struct TimeWindow {
    double begin = 0.0;
    double end = 0.0;

    // For ever with a duration of 0. A sample that is meant to be on an edge may have been rounded: both
    // edges are early by a thousandth of the sampling period.
    static TimeWindow lasting(double begin, double duration, double period) {
        const double margin = 1e-3 * period;
        return {
            .begin = begin - margin,
            .end = duration > 0.0 ? begin + duration - margin : std::numeric_limits<double>::infinity(),
        };
    }

    [[nodiscard]] bool contains(double time) const { return begin <= time && time < end; }
};

}  // namespace truenorth::plant
