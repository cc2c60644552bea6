// A track of segments one after another, on the ground or in the air. In each, speed, climb angle and course
// change smoothly from what they were. Whoever is on it points along its velocity, to within the roll.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "elementary/sincos.hpp"
#include "plant/transition.hpp"

namespace truenorth::plant {

class SegmentedTrack {
  public:
    static constexpr std::size_t kSegments = 16;

    struct Segment {
        double duration = 0.0;      // [s]; 0: not used
        double acceleration = 0.0;  // mean, along the track [m/s2]
        double climb_angle = 0.0;   // of the track above the horizon, at the end [rad]
        double turn_angle = 0.0;    // change of course, positive clockwise [rad]
    };

    struct Start {
        double speed = 0.0;        // [m/s]
        double climb_angle = 0.0;  // [rad]
        double course = 0.0;       // clockwise from north [rad]
    };

    // A quantity with its derivatives.
    struct Quantity {
        double value = 0.0;
        double rate = 0.0;          // [1/s]
        double acceleration = 0.0;  // [1/s2]
    };

    struct Point {
        Quantity speed, climb_angle, course;
        SineCosine<double> climb{};      // of the climb angle
        SineCosine<double> direction{};  // of the course

        [[nodiscard]] Eigen::Vector3d velocity() const;      // east, north, up [m/s]
        [[nodiscard]] Eigen::Vector3d acceleration() const;  // its derivative [m/s2]
    };

    // From time 0 on; before it and after the last segment nothing changes.
    SegmentedTrack(const Start& start, const std::array<Segment, kSegments>& segments);

    [[nodiscard]] Point at(double time) const;

  private:
    // From its begin on; without changes: cruise.
    struct Leg {
        double begin = 0.0;  // [s]
        Start from;
        Transition speed, climb_angle, course;
    };

    [[nodiscard]] const Leg& leg(double time) const;

    std::array<Leg, kSegments + 1> legs_{};  // the last one is the cruise after all segments
    std::size_t last_ = 0;
};

}  // namespace truenorth::plant
