// What drives an error model over a filter interval, and the parts of the error equations that every model
// in the ENU frame shares.
//
// T is the matrix of the transport rate on the ellipsoid: w_en = T v, hence dw_en = T dv, and T p is the
// rotation of the ENU axes under a displacement p.
#pragma once

#include "estimation/gaussian.hpp"
#include "inertial/interval_average.hpp"

namespace truenorth {

struct NavigationInterval {
    // From mean attitude, specific force (computed ENU) and velocity over dt.
    NavigationInterval(double dt, const Eigen::Matrix3d& C_bn, const Eigen::Vector3d& force,
                       const Eigen::Vector3d& velocity, const earth::Position& position);

    // From the averages of the mechanisation; `velocity_error` is its error as far as it is known.
    NavigationInterval(const IntervalAverage& average, const earth::Position& position,
                       const Eigen::Vector3d& velocity_error);

    double dt;                 // [s]
    Eigen::Matrix3d C_bn;      // C_b^{n'}
    Eigen::Vector3d force;     // f' = C_b^{n'} f^b [m/s2]
    Eigen::Vector3d velocity;  // that the filter trusts, ENU [m/s]
    Eigen::Vector3d omega_ie;  // [rad/s]
    Eigen::Vector3d omega_en;
    double per_meridian_radius;        // 1 / (R_M + h) [1/m]
    double per_prime_vertical_radius;  // 1 / (R_N + h) [1/m]
    double tan_latitude;
    double gravity;  // [m/s2]

    // T [1/m].
    [[nodiscard]] Eigen::Matrix3d transport() const;

    // -(2 w_ie + w_en) x dv - dw_en x v = (v x T - (2 w_ie + w_en) x) dv: the matrix in brackets [1/s].
    [[nodiscard]] Eigen::Matrix3d coriolis() const;
};

}  // namespace truenorth
