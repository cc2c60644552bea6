#include "plant/flight.hpp"

#include <cmath>

#include "inertial/earth.hpp"

namespace truenorth::plant {

Kinematics Flight::at(double time) const {
    const SegmentedTrack::Point point = track_.at(time);
    const auto& [speed, acceleration, _] = point.speed;
    const auto& [pitch, pitch_rate, pitch_acceleration] = point.climb_angle;
    const double course_rate = point.course.rate;
    const auto& [sp, cp] = point.climb;
    const auto& [sin_course, cos_course] = point.direction;

    // Specific force across the track, and its derivative.
    constexpr double g = earth::kStandardGravity;
    const double to_right = speed * cp * course_rate;
    const double upward = speed * pitch_rate + g * cp;
    const double to_right_rate = acceleration * cp * course_rate - speed * sp * pitch_rate * course_rate +
                                 speed * cp * point.course.acceleration;
    const double upward_rate = acceleration * pitch_rate + speed * pitch_acceleration - g * sp * pitch_rate;

    const double across2 = to_right * to_right + upward * upward;
    const double across = std::sqrt(across2);
    const EulerAngles attitude_rate{
        .roll = (to_right_rate * upward - to_right * upward_rate) / across2,
        .pitch = pitch_rate,
        .heading = course_rate,
    };
    const auto [C_bn, omega_nb_b] =
        turning({.sine = {to_right / across, sp, sin_course}, .cosine = {upward / across, cp, cos_course}},
                attitude_rate);
    return {
        .velocity = point.velocity(),
        .acceleration = point.acceleration(),
        .C_bn = C_bn,
        .omega_nb_b = omega_nb_b,
    };
}

}  // namespace truenorth::plant
