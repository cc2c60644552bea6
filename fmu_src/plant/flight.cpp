#include "plant/flight.hpp"

#include <cmath>

#include "inertial/earth.hpp"

namespace truenorth::plant {

Kinematics Flight::at(double time) const {
    const SegmentedTrack::Point point = track_.at(time);
    const auto& [speed, acceleration, _] = point.speed;
    const auto& [pitch, pitch_rate, pitch_acceleration] = point.climb_angle;
    const auto& [course, course_rate, course_acceleration] = point.course;
    const double cp = std::cos(pitch);
    const double sp = std::sin(pitch);

    // Specific force across the track, and its derivative.
    constexpr double g = earth::kStandardGravity;
    const double to_right = speed * cp * course_rate;
    const double upward = speed * pitch_rate + g * cp;
    const double to_right_rate = acceleration * cp * course_rate - speed * sp * pitch_rate * course_rate +
                                 speed * cp * course_acceleration;
    const double upward_rate = acceleration * pitch_rate + speed * pitch_acceleration - g * sp * pitch_rate;

    const EulerAngles attitude{
        .roll = std::atan2(to_right, upward),
        .pitch = pitch,
        .heading = course,
    };
    const EulerAngles attitude_rate{
        .roll = (to_right_rate * upward - to_right * upward_rate) / (to_right * to_right + upward * upward),
        .pitch = pitch_rate,
        .heading = course_rate,
    };
    const Eigen::Matrix3d C_bn = dcm(attitude);
    return {
        .velocity = point.velocity(),
        .acceleration = point.acceleration(),
        .C_bn = C_bn,
        .omega_nb_b = body_rate(attitude, attitude_rate, C_bn),
    };
}

}  // namespace truenorth::plant
