#include "inertial/earth.hpp"

#include <cmath>

#include "elementary/arctangent.hpp"
#include "elementary/sincos.hpp"
#include "inertial/attitude.hpp"

namespace truenorth::earth {

namespace {

Radii radii_of(double per_w) {
    const double prime_vertical = kSemiMajorAxis * per_w;
    return {.meridian = prime_vertical * (1.0 - kEccentricity2) * per_w * per_w,
            .prime_vertical = prime_vertical};
}

}  // namespace

Radii radii(double latitude) { return radii_of(per_w_of(sincos(latitude).sine)); }

double gravity(double latitude, double height) { return Place(latitude, height).gravity(); }

Eigen::Vector3d rate(double latitude) { return Place(latitude, 0.0).rate(); }

Eigen::Vector3d transport_rate(const Position& position, const Eigen::Vector3d& velocity) {
    return Place(position).transport_rate(velocity);
}

Eigen::Vector3d position_rate(const Position& position, const Eigen::Vector3d& velocity) {
    return Place(position).position_rate(velocity);
}

Position displaced(const Position& position, const Eigen::Vector3d& displacement) {
    const Eigen::Vector3d change = position_rate(position, displacement);
    return {.latitude = position.latitude + change.x(),
            .longitude = wrap_angle(position.longitude + change.y()),
            .height = position.height + change.z()};
}

Eigen::Vector3d displacement(const Position& from, const Position& to) {
    const Place place(from);
    return {wrap_angle(to.longitude - from.longitude) / place.per_prime_vertical_radius * place.cos_latitude,
            (to.latitude - from.latitude) / place.per_meridian_radius, to.height - from.height};
}

Eigen::Vector3d ecef(const Position& position) {
    const auto [sine, cosine] = sincos(Eigen::Array2d(position.latitude, position.longitude));
    const double prime_vertical = radii_of(per_w_of(sine[0])).prime_vertical;
    const double from_axis = (prime_vertical + position.height) * cosine[0];
    return {from_axis * cosine[1], from_axis * sine[1],
            ((1.0 - kEccentricity2) * prime_vertical + position.height) * sine[0]};
}

Eigen::Matrix3d C_en(const Position& position) {
    const auto [sin_latitude, cos_latitude] = sincos(position.latitude);
    const auto [sin_longitude, cos_longitude] = sincos(position.longitude);
    Eigen::Matrix3d C;
    C << -sin_longitude, cos_longitude, 0.0,                                         //
        -sin_latitude * cos_longitude, -sin_latitude * sin_longitude, cos_latitude,  //
        cos_latitude * cos_longitude, cos_latitude * sin_longitude, sin_latitude;
    return C;
}

Position geodetic(const Eigen::Vector3d& ecef) {
    constexpr double semi_minor_axis = kSemiMajorAxis * (1.0 - kFlattening);
    constexpr double second_eccentricity2 = kEccentricity2 / (1.0 - kEccentricity2);
    const double from_axis = ecef.head<2>().norm();
    double latitude = arctangent(ecef.z(), (1.0 - kEccentricity2) * from_axis);
    for (int i = 0; i < 3; ++i) {
        const auto [sin_latitude, cos_latitude] = sincos(latitude);
        const auto [sine, cosine] = sincos(arctangent((1.0 - kFlattening) * sin_latitude, cos_latitude));
        latitude = arctangent(ecef.z() + second_eccentricity2 * semi_minor_axis * sine * sine * sine,
                              from_axis - kEccentricity2 * kSemiMajorAxis * cosine * cosine * cosine);
    }
    const auto [sin_latitude, cos_latitude] = sincos(latitude);
    return {.latitude = latitude,
            .longitude = arctangent(ecef.y(), ecef.x()),
            .height = from_axis * cos_latitude + ecef.z() * sin_latitude -
                      kSemiMajorAxis * std::sqrt(1.0 - kEccentricity2 * sin_latitude * sin_latitude)};
}

Eigen::Vector3d earth_fixed_rate() { return {0.0, 0.0, kRate}; }

Eigen::Vector3d gravitation(const Eigen::Vector3d& ecef) {
    const Position place = geodetic(ecef);
    const Eigen::Vector3d up = C_en(place).row(2);
    const Eigen::Vector3d centripetal = -kRate * kRate * Eigen::Vector3d(ecef.x(), ecef.y(), 0.0);
    return centripetal - gravity(place.latitude, place.height) * up;
}

Eigen::Quaterniond turn(double time) {
    const auto [sine, cosine] = sincos(0.5 * kRate * time);
    return {cosine, 0.0, 0.0, -sine};
}

}  // namespace truenorth::earth
