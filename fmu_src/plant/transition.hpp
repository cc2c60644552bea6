// A smooth change of some quantity u by the quintic x^3 (10 - 15 x + 6 x^2), x = (t - begin) / duration in
// [0, 1]: its first and second derivatives are zero at both ends.
#pragma once

#include <algorithm>
#include <cmath>

namespace truenorth::plant {

struct Transition {
    double change = 0.0;    // [u]
    double begin = 0.0;     // [s]
    double duration = 1.0;  // [s]

    // Part of the change that is made at `time` [u], and its derivatives [u/s, u/s2].
    [[nodiscard]] double value(double time) const {
        const double x = progress(time);
        return change * x * x * x * (10.0 + x * (-15.0 + x * 6.0));
    }
    [[nodiscard]] double rate(double time) const {
        const double x = progress(time);
        return change / duration * 30.0 * x * x * (1.0 - x) * (1.0 - x);
    }
    [[nodiscard]] double acceleration(double time) const {
        const double x = progress(time);
        return change / (duration * duration) * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x);
    }

    // The largest magnitude of the rate, in mid-transition [u/s].
    [[nodiscard]] double peak_rate() const { return std::abs(rate(begin + 0.5 * duration)); }

  private:
    [[nodiscard]] double progress(double time) const {
        return std::clamp((time - begin) / duration, 0.0, 1.0);
    }
};

}  // namespace truenorth::plant
