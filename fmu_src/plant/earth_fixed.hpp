// The Earth-centred, Earth-fixed frame e of WGS-84: x towards longitude 0 on the equator, z towards the north
// pole.
#pragma once

#include <Eigen/Core>

#include "inertial/earth.hpp"

namespace truenorth::plant {

// Coordinates of a geodetic position in e [m].
Eigen::Vector3d earth_fixed(const earth::Position& position);

// Turns east, north, up at a position into e: v_e = C_ne v_n.
Eigen::Matrix3d C_ne(const earth::Position& position);

}  // namespace truenorth::plant
