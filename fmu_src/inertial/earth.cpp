#include "inertial/earth.hpp"

#include <cmath>

#include "inertial/attitude.hpp"

namespace truenorth::earth {

Radii radii(double latitude) {
    const double s = std::sin(latitude);
    const double w2 = 1.0 - kEccentricity2 * s * s;
    const double prime_vertical = kSemiMajorAxis / std::sqrt(w2);
    return {.meridian = prime_vertical * (1.0 - kEccentricity2) / w2, .prime_vertical = prime_vertical};
}

double gravity(double latitude, double height) {
    constexpr double semi_minor_axis = kSemiMajorAxis * (1.0 - kFlattening);
    constexpr double k = semi_minor_axis * kPolarGravity / (kSemiMajorAxis * kEquatorialGravity) - 1.0;
    constexpr double m =
        kRate * kRate * kSemiMajorAxis * kSemiMajorAxis * semi_minor_axis / kGravitationalParameter;
    const double s2 = std::sin(latitude) * std::sin(latitude);
    const double on_ellipsoid = kEquatorialGravity * (1.0 + k * s2) / std::sqrt(1.0 - kEccentricity2 * s2);
    const double h = height / kSemiMajorAxis;
    return on_ellipsoid * (1.0 - 2.0 * (1.0 + kFlattening + m - 2.0 * kFlattening * s2) * h + 3.0 * h * h);
}

Eigen::Vector3d rate(double latitude) {
    return {0.0, kRate * std::cos(latitude), kRate * std::sin(latitude)};
}

Eigen::Vector3d transport_rate(const Position& position, const Eigen::Vector3d& velocity) {
    const auto [meridian, prime_vertical] = radii(position.latitude);
    const double east = velocity.x() / (prime_vertical + position.height);
    return {-velocity.y() / (meridian + position.height), east, east * std::tan(position.latitude)};
}

Eigen::Vector3d position_rate(const Position& position, const Eigen::Vector3d& velocity) {
    const auto [meridian, prime_vertical] = radii(position.latitude);
    return {velocity.y() / (meridian + position.height),
            velocity.x() / ((prime_vertical + position.height) * std::cos(position.latitude)), velocity.z()};
}

Position displaced(const Position& position, const Eigen::Vector3d& displacement) {
    const Eigen::Vector3d change = position_rate(position, displacement);
    return {.latitude = position.latitude + change.x(),
            .longitude = wrap_angle(position.longitude + change.y()),
            .height = position.height + change.z()};
}

Eigen::Vector3d displacement(const Position& from, const Position& to) {
    const auto [meridian, prime_vertical] = radii(from.latitude);
    return {
        wrap_angle(to.longitude - from.longitude) * (prime_vertical + from.height) * std::cos(from.latitude),
        (to.latitude - from.latitude) * (meridian + from.height), to.height - from.height};
}

Eigen::Vector3d ecef(const Position& position) {
    const double prime_vertical = radii(position.latitude).prime_vertical;
    const double from_axis = (prime_vertical + position.height) * std::cos(position.latitude);
    return {from_axis * std::cos(position.longitude), from_axis * std::sin(position.longitude),
            ((1.0 - kEccentricity2) * prime_vertical + position.height) * std::sin(position.latitude)};
}

Eigen::Matrix3d C_en(const Position& position) {
    const double sin_latitude = std::sin(position.latitude);
    const double cos_latitude = std::cos(position.latitude);
    const double sin_longitude = std::sin(position.longitude);
    const double cos_longitude = std::cos(position.longitude);
    Eigen::Matrix3d C;
    C << -sin_longitude, cos_longitude, 0.0,                                         //
        -sin_latitude * cos_longitude, -sin_latitude * sin_longitude, cos_latitude,  //
        cos_latitude * cos_longitude, cos_latitude * sin_longitude, sin_latitude;
    return C;
}

Position geodetic(const Eigen::Vector3d& ecef) {
    constexpr double semi_minor_axis = kSemiMajorAxis * (1.0 - kFlattening);
    constexpr double second_eccentricity2 = kEccentricity2 / (1.0 - kEccentricity2);
    const double from_axis = std::hypot(ecef.x(), ecef.y());
    double latitude = std::atan2(ecef.z(), (1.0 - kEccentricity2) * from_axis);
    for (int i = 0; i < 3; ++i) {
        const double reduced = std::atan2((1.0 - kFlattening) * std::sin(latitude), std::cos(latitude));
        const double sine = std::sin(reduced);
        const double cosine = std::cos(reduced);
        latitude = std::atan2(ecef.z() + second_eccentricity2 * semi_minor_axis * sine * sine * sine,
                              from_axis - kEccentricity2 * kSemiMajorAxis * cosine * cosine * cosine);
    }
    const double sin_latitude = std::sin(latitude);
    return {.latitude = latitude,
            .longitude = std::atan2(ecef.y(), ecef.x()),
            .height = from_axis * std::cos(latitude) + ecef.z() * sin_latitude -
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
    const double half = 0.5 * kRate * time;
    return {std::cos(half), 0.0, 0.0, -std::sin(half)};
}

}  // namespace truenorth::earth
