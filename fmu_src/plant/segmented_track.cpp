#include "plant/segmented_track.hpp"

#include <cmath>

namespace truenorth::plant {

namespace {

SegmentedTrack::Quantity changing(double from, const Transition& change, double time) {
    return {.value = from + change.value(time),
            .rate = change.rate(time),
            .acceleration = change.acceleration(time)};
}

// On the ground.
Eigen::Vector3d ahead(double course) { return {std::sin(course), std::cos(course), 0.0}; }

Eigen::Vector3d along(double climb_angle, double course) {
    return std::cos(climb_angle) * ahead(course) + std::sin(climb_angle) * Eigen::Vector3d::UnitZ();
}

}  // namespace

SegmentedTrack::SegmentedTrack(const Start& start, const std::array<Segment, kSegments>& segments) {
    double begin = 0.0;
    Start track = start;
    for (const Segment& segment : segments) {
        const double duration = segment.duration;
        if (duration == 0.0) {
            continue;
        }
        const Start change{
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

const SegmentedTrack::Leg& SegmentedTrack::leg(double time) const {
    std::size_t now = last_;
    while (now > 0 && time < legs_[now].begin) {
        --now;
    }
    return legs_[now];
}

SegmentedTrack::Point SegmentedTrack::at(double time) const {
    const auto& [begin, from, speed, climb_angle, course] = leg(time);
    return {.speed = changing(from.speed, speed, time),
            .climb_angle = changing(from.climb_angle, climb_angle, time),
            .course = changing(from.course, course, time)};
}

Eigen::Vector3d SegmentedTrack::Point::velocity() const {
    return speed.value * along(climb_angle.value, course.value);
}

Eigen::Vector3d SegmentedTrack::Point::acceleration() const {
    const double cp = std::cos(climb_angle.value);
    const double sp = std::sin(climb_angle.value);
    const Eigen::Vector3d forward = ahead(course.value);
    const Eigen::Vector3d right(forward.y(), -forward.x(), 0.0);
    const Eigen::Vector3d above = -sp * forward + cp * Eigen::Vector3d::UnitZ();
    return speed.rate * along(climb_angle.value, course.value) +
           speed.value * (climb_angle.rate * above + cp * course.rate * right);
}

}  // namespace truenorth::plant
