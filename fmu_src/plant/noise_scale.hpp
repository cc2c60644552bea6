// Factor on all sigmas of a receiver: a step in one window, 1 + amplitude sin(2 pi (t - begin) / period) in
// another (Jing 2023, eq. 21).
#pragma once

#include <numbers>

#include "elementary/sincos.hpp"
#include "plant/time_window.hpp"

namespace truenorth::plant {

struct NoiseScale {
    double step_factor = 1.0;
    TimeWindow step;
    double sine_amplitude = 0.0;
    double sine_period = 1.0;  // [s]
    TimeWindow sine;

    [[nodiscard]] double at(double time) const {
        double scale = step.contains(time) ? step_factor : 1.0;
        if (sine.contains(time)) {
            const double angle = 2.0 * std::numbers::pi * (time - sine.begin) / sine_period;
            scale *= 1.0 + sine_amplitude * sincos(angle).sine;
        }
        return scale;
    }
};

}  // namespace truenorth::plant
