// A ship, moored (speed 0) or under way: its velocity is speed along the course plus the orbital velocity of
// the waves; it sways about all three axes (Zhou 2011, section 3).
#pragma once

#include <array>

#include "plant/kinematics.hpp"
#include "plant/oscillation.hpp"

namespace truenorth::plant {

// A change of course, smooth from begin to end.
struct Turn {
    double angle = 0.0;     // positive clockwise [rad]
    double begin = 0.0;     // [s]
    double duration = 1.0;  // [s]
};

struct Ship {
    double course = 0.0;  // before all turns, clockwise from north [rad]
    double speed = 0.0;   // [m/s]
    Oscillation sway;     // roll, pitch, yaw [rad]; yaw is counter-clockwise: heading = course - yaw
    Oscillation wave;     // velocity east, north, up [m/s]
    std::array<Turn, 8> turns{};

    [[nodiscard]] Kinematics at(double time) const;
};

}  // namespace truenorth::plant
