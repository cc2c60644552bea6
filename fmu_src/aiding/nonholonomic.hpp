// Wheels roll forward: a vehicle on them has no velocity to the right and none up, where they stand. As a log
// that measures zero on these axes, which are those of body_velocity: what its boresight is off by, wheels
// are off by too.
#pragma once

#include <limits>

#include "aiding/body_velocity.hpp"

namespace truenorth::aiding {

// Of an axle that does not steer, at `lever_arm` from the IMU, body [m].
inline Observation nonholonomic(const Moment& moment, const Eigen::Vector3d& lever_arm) {
    Moment rolling = moment;
    rolling.sensors(kScale) = 0.0;
    Observation observation =
        body_velocity(rolling, lever_arm, {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0});
    observation.own.col(kScale).setZero();
    return observation;
}

}  // namespace truenorth::aiding
