// What a vehicle that stands tells without a sensor: its velocity is zero, and it turns with the Earth. With
// the gyro errors b that are known and eps that are not, gyros measure
//
//     w = C_n^b w_ie + b + eps,    d(C_n^b w_ie) = C_n^b (phi x w_ie)
#pragma once

#include "aiding/observation.hpp"

namespace truenorth::aiding {

// No velocity, in body axes.
Observation standing(const Moment& moment);

// No rotation relative to the Earth, where the gyros measure `rate` on average [rad/s].
Observation not_turning(const Moment& moment, const Eigen::Vector3d& rate);

}  // namespace truenorth::aiding
