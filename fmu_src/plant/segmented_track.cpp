#include "plant/segmented_track.hpp"

namespace truenorth::plant {

namespace {

SegmentedTrack::Quantity changing(double from, const Transition& change, double time) {
    return {.value = from + change.value(time),
            .rate = change.rate(time),
            .acceleration = change.acceleration(time)};
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
    const Quantity slope = changing(from.climb_angle, climb_angle, time);
    const Quantity heading = changing(from.course, course, time);
    return {.speed = changing(from.speed, speed, time),
            .climb_angle = slope,
            .course = heading,
            .climb = sincos(slope.value),
            .direction = sincos(heading.value)};
}

Eigen::Vector3d SegmentedTrack::Point::velocity() const {
    const Eigen::Vector3d ahead(direction.sine, direction.cosine, 0.0);  // on the ground
    return speed.value * (climb.cosine * ahead + climb.sine * Eigen::Vector3d::UnitZ());
}

Eigen::Vector3d SegmentedTrack::Point::acceleration() const {
    const Eigen::Vector3d ahead(direction.sine, direction.cosine, 0.0);
    const Eigen::Vector3d right(ahead.y(), -ahead.x(), 0.0);
    const Eigen::Vector3d along = climb.cosine * ahead + climb.sine * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d above = -climb.sine * ahead + climb.cosine * Eigen::Vector3d::UnitZ();
    return speed.rate * along + speed.value * (climb_angle.rate * above + climb.cosine * course.rate * right);
}

}  // namespace truenorth::plant
