// Velocity relative to the Earth in body axes: a Doppler log with bottom track, an odometer; a log through
// the water where it does not flow. With the scale factor error k and the boresight beta of its axes
//
//     u = (1 + k) (I - beta x) w,    w = C_n^b v + w_eb^b x l,    dw = C_n^b (dv + phi x v) + eps x l
#pragma once

#include "aiding/observation.hpp"

namespace truenorth::aiding {

// Of a sensor at `lever_arm` from the IMU, body [m]; right, forward, up [m/s].
Observation body_velocity(const Moment& moment, const Eigen::Vector3d& lever_arm,
                          const Eigen::Vector3d& measured);

}  // namespace truenorth::aiding
