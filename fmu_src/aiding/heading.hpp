// Heading of the body's forward axis: two antennas, a compass, somebody's word.
#pragma once

#include "aiding/observation.hpp"

namespace truenorth::aiding {

// Derivative of the heading with respect to the misalignment. With f the forward axis, east, north, up:
//
//     dpsi = phi_u - (f_e phi_e + f_n phi_n) f_u / (f_e^2 + f_n^2)
//
// Zero where it points straight up or down and there is no heading.
Eigen::RowVector3d heading_gradient(const Eigen::Quaterniond& q_bn);

// `measured`: clockwise from north [rad]; the difference is within half a turn. Not a number where the
// forward axis is steeper than 80 degrees: small tilts are large headings there.
Observation heading(const Moment& moment, double measured);

}  // namespace truenorth::aiding
