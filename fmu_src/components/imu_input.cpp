#include "components/imu_input.hpp"

#include <algorithm>
#include <cmath>

namespace truenorth {

ImuInput::Verdict ImuInput::read(int sample, double time, const Eigen::Vector3d& delta_angle,
                                 const Eigen::Vector3d& delta_velocity) {
    if (sample == seen_) {
        return Verdict::stale;
    }
    seen_ = sample;

    const double dt = time - time_;
    // Before the first sample, and after the sensor's count has been reset, there is nothing to have missed.
    const int parts = any_ ? std::max(sample - accepted_, 1) : 1;
    const double part = dt / parts;
    const bool plausible = std::isfinite(time) && part > 1e-9 && delta_angle.allFinite() &&
                           delta_velocity.allFinite() && delta_angle.norm() <= kLargestRate * part &&
                           delta_velocity.norm() <= kLargestForce * part;
    if (!plausible) {
        ++rejected_;
        ++rejected_since_;
        return Verdict::rejected;
    }
    gap_ = std::max(parts - 1 - rejected_since_, 0);
    missed_ += gap_;
    increment_ = {dt, parts * delta_angle, parts * delta_velocity};
    time_ = time;
    any_ = true;
    accepted_ = sample;
    rejected_since_ = 0;
    return Verdict::accepted;
}

}  // namespace truenorth
