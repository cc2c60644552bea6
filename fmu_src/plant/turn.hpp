// A change of course by the quintic x^3 (10 - 15 x + 6 x^2), x = (t - begin) / duration in [0, 1]: course
// rate and course acceleration are zero at both ends.
#pragma once

#include <algorithm>

namespace truenorth::plant {

struct Turn {
    double angle = 0.0;     // positive clockwise [rad]
    double begin = 0.0;     // [s]
    double duration = 1.0;  // [s]

    // Part of the angle that is turned at `time` [rad], and its derivative [rad/s].
    [[nodiscard]] double turned(double time) const {
        const double x = progress(time);
        return angle * x * x * x * (10.0 + x * (-15.0 + x * 6.0));
    }
    [[nodiscard]] double rate(double time) const {
        const double x = progress(time);
        return angle / duration * 30.0 * x * x * (1.0 - x) * (1.0 - x);
    }

  private:
    [[nodiscard]] double progress(double time) const {
        return std::clamp((time - begin) / duration, 0.0, 1.0);
    }
};

}  // namespace truenorth::plant
