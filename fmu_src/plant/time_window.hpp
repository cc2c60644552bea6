// begin <= time < end [s].
#pragma once

namespace truenorth::plant {

struct TimeWindow {
    double begin = 0.0;
    double end = 0.0;

    [[nodiscard]] bool contains(double time) const { return begin <= time && time < end; }
};

}  // namespace truenorth::plant
