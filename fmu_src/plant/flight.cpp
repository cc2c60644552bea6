#include "plant/flight.hpp"

#include <cmath>

#include "inertial/earth.hpp"

namespace truenorth::plant {

Flight::Flight(const Track& start, const std::array<Segment, kSegments>& segments) {
    double begin = 0.0;
    Track track = start;
    for (const Segment& segment : segments) {
        const double duration = segment.duration;
        if (duration == 0.0) {
            continue;
        }
        const Track change{
            .speed = segment.acceleration * duration,
            .climb_angle = segment.climb_angle - track.climb_angle,
            .course = segment.turn_angle,
        };
        legs_[last_++] = {
            .begin = begin,
            .from = track,
            .speed = {.change = change.speed, .begin = begin, .duration = duration},
            .climb_angle = {.change = change.climb_angle, .begin = begin, .duration = duration},
            .course = {.change = change.course, .begin = begin, .duration = duration},
        };
        begin += duration;
        track = {
            .speed = track.speed + change.speed,
            .climb_angle = segment.climb_angle,
            .course = track.course + change.course,
        };
    }
    legs_[last_].begin = begin;
    legs_[last_].from = track;
}

const Flight::Leg& Flight::leg(double time) const {
    std::size_t now = last_;
    while (now > 0 && time < legs_[now].begin) {
        --now;
    }
    return legs_[now];
}

Kinematics Flight::at(double time) const {
    const auto& [begin, from, speed_change, climb, turn] = leg(time);
    const double speed = from.speed + speed_change.value(time);
    const double acceleration = speed_change.rate(time);
    const double pitch = from.climb_angle + climb.value(time);
    const double pitch_rate = climb.rate(time);
    const double course = from.course + turn.value(time);
    const double course_rate = turn.rate(time);

    const auto [sp, cp] = sincos(pitch);
    const auto [sin_course, cos_course] = sincos(course);
    const Eigen::Vector3d ahead(sin_course, cos_course, 0.0);  // of the track, on the ground
    const Eigen::Vector3d right(ahead.y(), -ahead.x(), 0.0);
    const Eigen::Vector3d along = cp * ahead + sp * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d above = -sp * ahead + cp * Eigen::Vector3d::UnitZ();

    // Specific force across the track, and its derivative.
    constexpr double g = earth::kStandardGravity;
    const double to_right = speed * cp * course_rate;
    const double upward = speed * pitch_rate + g * cp;
    const double to_right_rate = acceleration * cp * course_rate - speed * sp * pitch_rate * course_rate +
                                 speed * cp * turn.acceleration(time);
    const double upward_rate =
        acceleration * pitch_rate + speed * climb.acceleration(time) - g * sp * pitch_rate;

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
        .velocity = speed * along,
        .acceleration = acceleration * along + speed * (pitch_rate * above + cp * course_rate * right),
        .C_bn = C_bn,
        .omega_nb_b = omega_nb_b,
    };
}

}  // namespace truenorth::plant
