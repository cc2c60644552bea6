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

    // T [1/m], and dw_en = T dv for every point of a set.
    [[nodiscard]] Eigen::Matrix3d transport() const;
    template <class Row>
    [[nodiscard]] Components<Row> transport_rate(const Components<Row>& dv) const {
        const Row north = dv[0] * per_prime_vertical_radius;
        return {-dv[1] * per_meridian_radius, north, north * tan_latitude};
    }

    // By which the turning axes change a velocity error dv, for every point of a set:
    // -(2 w_ie + w_en) x dv - dw_en x (v + dv), as the mechanisation multiplies w_en by the v + dv it has.
    template <class Row>
    [[nodiscard]] Components<Row> coriolis_rate(const Components<Row>& dv,
                                                const Components<Row>& dw_en) const;

    // The Jacobian of that at dv [1/s]; at zero v x T - (2 w_ie + w_en) x.
    [[nodiscard]] Eigen::Matrix3d coriolis(const Eigen::Vector3d& dv = Eigen::Vector3d::Zero()) const;

  private:
    NavigationInterval(double dt, const Eigen::Matrix3d& C_bn, const Eigen::Vector3d& force,
                       const Eigen::Vector3d& velocity, const earth::Place& place);
};

template <class Row>
Components<Row> NavigationInterval::coriolis_rate(const Components<Row>& dv,
                                                  const Components<Row>& dw_en) const {
    const Eigen::Vector3d w = 2.0 * omega_ie + omega_en;
    const auto along = [&](int j, int k) -> Row {
        return (w[k] + dw_en[k]) * dv[j] - (w[j] + dw_en[j]) * dv[k] +
               (dw_en[k] * velocity[j] - dw_en[j] * velocity[k]);
    };
    return {along(1, 2), along(2, 0), along(0, 1)};
}

}  // namespace truenorth
