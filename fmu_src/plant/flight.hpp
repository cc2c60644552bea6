// An aircraft that flies segments one after another. In each, speed, climb angle and course change smoothly
// from what they were; the aircraft points along its velocity (no angle of attack, no sideslip) and its turns
// are coordinated: with the course rate X', the climb angle c and the speed V, the bank that keeps the
// specific force, right V cos(c) X' and up V c' + g cos(c), out of the wings' direction is
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
#include "plant/transition.hpp"

namespace truenorth::plant {

class Flight {
  public:
    static constexpr std::size_t kSegments = 16;

    struct Segment {
        double duration = 0.0;      // [s]; 0: not used
        double acceleration = 0.0;  // mean, along the track [m/s2]
        double climb_angle = 0.0;   // of the track above the horizon, at the end [rad]
        double turn_angle = 0.0;    // change of course, positive clockwise [rad]
    };

    // What a flight engineer reads off his instruments.
    struct Track {
        double speed = 0.0;        // [m/s]
        double climb_angle = 0.0;  // [rad]
        double course = 0.0;       // clockwise from north [rad]
    };

    // From time 0 on; before it and after the last segment the aircraft flies on unaccelerated.
    Flight(const Track& start, const std::array<Segment, kSegments>& segments);

    [[nodiscard]] Kinematics at(double time) const;

  private:
    // From its begin on; without changes: cruise.
    struct Leg {
        double begin = 0.0;  // [s]
        Track from;
        Transition speed, climb_angle, course;
    };

    [[nodiscard]] const Leg& leg(double time) const;

    std::array<Leg, kSegments + 1> legs_{};  // the last one is the cruise after all segments
    std::size_t last_ = 0;
};

}  // namespace truenorth::plant
