// A vehicle on wheels that drives segments one after another, and stands where its speed is zero. It points
// along its velocity, for its wheels do not slip, and keeps its roll in turns: it does not bank.
#pragma once

#include <array>

#include "plant/kinematics.hpp"
#include "plant/segmented_track.hpp"

namespace truenorth::plant {

class RoadVehicle {
  public:
    // From time 0 on; before it and after the last segment it drives on, or stands, as it is.
    RoadVehicle(const SegmentedTrack::Start& start,
                const std::array<SegmentedTrack::Segment, SegmentedTrack::kSegments>& segments)
        : track_(start, segments) {}

    [[nodiscard]] Kinematics at(double time) const;

  private:
    SegmentedTrack track_;
};

}  // namespace truenorth::plant
