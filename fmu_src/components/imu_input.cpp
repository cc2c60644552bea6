#include "components/imu_input.hpp"

#include <algorithm>
#include <cmath>

#include "components/time_tolerance.hpp"

namespace truenorth {

ImuInput::Verdict ImuInput::read(int sample, double time, const Eigen::Vector3d& delta_angle,
                                 const Eigen::Vector3d& delta_velocity) {
    if (sample == seen_) {
        return Verdict::stale;
    }
    seen_ = sample;

    const bool resumes = time > leap_time_ && time - leap_time_ <= kLongestInterval;  // false for NaN
    const double before = resumes ? leap_time_ : time_;
    const double dt = time - before;
    // Before the first sample, and after the sensor's count has been reset, there is nothing to have missed.
    const int parts = any_ ? std::max(sample - (resumes ? leap_sample_ : accepted_), 1) : 1;
    const double part = dt / parts;
    const bool leaps = std::isfinite(time) && dt > kLongestInterval;
    leap_time_ = leaps ? time : std::numeric_limits<double>::quiet_NaN();
    leap_sample_ = leaps ? sample : 0;
    const bool plausible = !leaps && std::isfinite(time) && part > kTimeTolerance &&
                           delta_angle.allFinite() && delta_velocity.allFinite() &&
                           delta_angle.norm() <= kLargestRate * part &&
                           delta_velocity.norm() <= kLargestForce * part;
    if (!plausible) {
        ++rejected_;
        ++rejected_since_;
        return Verdict::rejected;
    }
    gap_ = resumes ? 0 : std::max(parts - 1 - rejected_since_, 0);
    missed_ += gap_;
    const double filled_in = resumes || increment_.dt == 0.0 ? 0.0 : (parts - 1) * part;
    if (filled_in > 0.0) {
        doubtful_angle_ = filled_in * (delta_angle / part - increment_.delta_angle / increment_.dt).norm();
        doubtful_velocity_ =
            filled_in * (delta_velocity / part - increment_.delta_velocity / increment_.dt).norm();
    } else {
        doubtful_angle_ = 0.0;
        doubtful_velocity_ = 0.0;
    }
    increment_ = {.dt = dt, .delta_angle = parts * delta_angle, .delta_velocity = parts * delta_velocity};
    time_ = time;
    any_ = true;
    accepted_ = sample;
    rejected_since_ = 0;
    return resumes ? Verdict::resumed : Verdict::accepted;
}

}  // namespace truenorth
