#include "filter/standstill.hpp"

#include <cmath>
#include <numbers>

#include "contract/time_tolerance.hpp"

namespace truenorth {

void Standstill::add(const ImuIncrement& increment, const Signals& standing) {
    Rates travelled;
    travelled << increment.delta_angle, increment.delta_velocity;
    const Rates rates = travelled / increment.dt;
    count_up(window_.samples);
    window_.duration += increment.dt;
    window_.travelled += travelled;
    const Rates off = rates - window_.mean;
    window_.mean += off / window_.samples;
    window_.scatter += off * (rates - window_.mean);
    ended_ = window_.duration > standing.window - kTimeTolerance;
    if (!ended_) {
        return;
    }
    const double n = window_.samples;
    const Rates variance = standing.noise.square() * (n / window_.duration) + standing.deviation.square();
    const Rates mean = window_.travelled / window_.duration;
    const bool quiet =
        window_.samples >= kFewest && (window_.scatter <= kMargin * kMargin * (n - 1.0) * variance).all();
    sigma_ = (variance / n).sqrt();
    steady_ = quiet && was_quiet_ && ((mean - mean_).abs() <= kSteady * std::numbers::sqrt2 * sigma_).all();
    mean_ = mean;
    was_quiet_ = quiet;
    window_ = {};
}

}  // namespace truenorth
