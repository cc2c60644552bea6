// Height of the IMU above the ellipsoid: a barometer, a depth gauge, a ship that stays on the sea.
#pragma once

#include "aiding/observation.hpp"

namespace truenorth::aiding {

Observation height(const Moment& moment, double measured);  // [m]

}  // namespace truenorth::aiding
