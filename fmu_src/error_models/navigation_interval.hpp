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
                       const Eigen::Vector3d& velocity, const earth::Place& place);

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

    // By which the turning axes change a velocity error dv, for every column of it:
    // -(2 w_ie + w_en) x dv - dw_en x (v + dv), as the mechanisation multiplies w_en by the v + dv it has.
    template <int Count>
    [[nodiscard]] Points<3, Count> coriolis_rate(const Points<3, Count>& dv) const;

    // The Jacobian of that at dv [1/s]; at zero v x T - (2 w_ie + w_en) x.
    [[nodiscard]] Eigen::Matrix3d coriolis(const Eigen::Vector3d& dv = Eigen::Vector3d::Zero()) const;
};

template <int Count>
Points<3, Count> NavigationInterval::coriolis_rate(const Points<3, Count>& dv) const {
    const Points<3, Count> dw_en = transport().lazyProduct(dv);
    Points<3, Count> rate = coriolis().lazyProduct(dv);
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const int k = (i + 2) % 3;
        rate.row(i) -= dw_en.row(j).cwiseProduct(dv.row(k)) - dw_en.row(k).cwiseProduct(dv.row(j));
    }
    return rate;
}

}  // namespace truenorth
