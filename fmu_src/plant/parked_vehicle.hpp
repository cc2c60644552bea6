// A vehicle that stands still: it settles on its springs, exponentially from a small tilt, and vibrates a
// little.
#pragma once

#include "plant/kinematics.hpp"
#include "plant/oscillation.hpp"

namespace truenorth::plant {

struct ParkedVehicle {
    double heading = 0.0;           // clockwise from north [rad]
    double settle_roll = 0.0;       // at time 0 [rad]
    double settle_pitch = 0.0;      // at time 0 [rad]
    double settle_time = 1.0;       // time constant [s]
    Oscillation angular_vibration;  // roll, pitch, yaw (counter-clockwise) [rad]
    Oscillation vibration;          // velocity east, north, up [m/s]

    [[nodiscard]] Kinematics at(double time) const;
};

}  // namespace truenorth::plant
