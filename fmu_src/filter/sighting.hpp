// A fix as the filter sees it: what the receiver says, and where the mechanisation had the antenna.
#pragma once

#include "filter/antenna_history.hpp"
#include "filter/gnss_input.hpp"

namespace truenorth {

struct Sighting {
    GnssFix fix;
    AntennaState then;          // the antenna at the time of the fix
    AntennaState now;           // the antenna at the time to which the IMU data reach
    IntervalAverage since;      // of the mechanisation, from then to now
    Eigen::Vector3d lever_arm;  // from the IMU to the antenna, body [m]
};

}  // namespace truenorth
