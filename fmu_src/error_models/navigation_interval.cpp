#include "error_models/navigation_interval.hpp"

namespace truenorth {

NavigationInterval::NavigationInterval(double dt, const Eigen::Matrix3d& C_bn, const Eigen::Vector3d& force,
                                       const Eigen::Vector3d& velocity, const earth::Place& place)
    : dt(dt),
      C_bn(C_bn),
      force(force),
      velocity(velocity),
      omega_ie(place.rate()),
      omega_en(place.transport_rate(velocity)),
      per_meridian_radius(place.per_meridian_radius),
      per_prime_vertical_radius(place.per_prime_vertical_radius),
      tan_latitude(place.tan_latitude()),
      gravity(place.gravity()) {}

NavigationInterval::NavigationInterval(double dt, const Eigen::Matrix3d& C_bn, const Eigen::Vector3d& force,
                                       const Eigen::Vector3d& velocity, const earth::Position& position)
    : NavigationInterval(dt, C_bn, force, velocity, earth::Place(position)) {}

NavigationInterval::NavigationInterval(const IntervalAverage& average, const earth::Position& position,
                                       const Eigen::Vector3d& velocity_error)
    : NavigationInterval(average.duration(), average.C_bn(), average.force(),
                         average.velocity() - velocity_error, position) {}

Eigen::Matrix3d NavigationInterval::transport() const {
    Eigen::Matrix3d T;
    T << 0.0, -per_meridian_radius, 0.0,      //
        per_prime_vertical_radius, 0.0, 0.0,  //
        per_prime_vertical_radius * tan_latitude, 0.0, 0.0;
    return T;
}

Eigen::Matrix3d NavigationInterval::coriolis(const Eigen::Vector3d& dv) const {
    const Eigen::Matrix3d T = transport();
    return skew(velocity + dv) * T - skew(2.0 * omega_ie + omega_en + T * dv);
}

}  // namespace truenorth
