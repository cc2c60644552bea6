// An aircraft that flies segments one after another. It points along its velocity (no angle of attack, no
// sideslip) and its turns are coordinated: with the course rate X', the climb angle c and the speed V, the
// bank that keeps the specific force, right V cos(c) X' and up V c' + g cos(c), out of the direction of the
// wings is
//
//     tan(roll) = V cos(c) X' / (V c' + g cos(c)),    in level flight V X' / g.
//
// g is standard gravity and the Earth is at rest here: what the Earth's rotation and curvature add, some
// ten mm/s2 at 100 m/s, the wings do feel. Where segments meet the roll rate is continuous and its derivative
// is not: let them meet at ends of IMU samples, or the increments are some 0.01 arcsec off there.
#pragma once

#include <array>
#include <cstddef>

#include "plant/kinematics.hpp"
#include "plant/segmented_track.hpp"

namespace truenorth::plant {

class Flight {
  public:
    static constexpr std::size_t kSegments = SegmentedTrack::kSegments;
    using Segment = SegmentedTrack::Segment;
    using Track = SegmentedTrack::Start;  // what a flight engineer reads off his instruments

    // From time 0 on; before it and after the last segment the aircraft flies on unaccelerated.
    Flight(const Track& start, const std::array<Segment, kSegments>& segments) : track_(start, segments) {}

    [[nodiscard]] Kinematics at(double time) const;

  private:
    SegmentedTrack track_;
};

}  // namespace truenorth::plant
