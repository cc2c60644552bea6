// The Earth: WGS-84 ellipsoid, normal gravity, earth rate and transport rate.
//
// Frame: n = ENU (east, north, up) at the geodetic position given. SI units and radians throughout.
#pragma once

#include <Eigen/Geometry>

#include "inertial/sincos.hpp"

namespace truenorth::earth {

// WGS-84 (NIMA TR8350.2, 3rd ed., tables 3.1, 3.3, 3.4).
inline constexpr double kSemiMajorAxis = 6378137.0;         // [m]
inline constexpr double kFlattening = 1.0 / 298.257223563;  // [-]
inline constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);
inline constexpr double kRate = 7.292115e-5;                       // [rad/s]
inline constexpr double kEquatorialGravity = 9.7803253359;         // [m/s2]
inline constexpr double kPolarGravity = 9.8321849378;              // [m/s2]
inline constexpr double kGravitationalParameter = 3.986004418e14;  // [m3/s2]
inline constexpr double kStandardGravity = 9.80665;                // the unit "g" [m/s2]

// The local-level frame is singular at the poles: latitudes beyond this are excluded [rad].
inline constexpr double kHighestLatitude = 1.57;

// Geodetic position; latitude and longitude [rad], height above the ellipsoid [m].
struct Position {
    double latitude = 0.0;
    double longitude = 0.0;
    double height = 0.0;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(latitude, longitude, height);
    }
};

// Radii of curvature [m]: meridian (north-south) and prime vertical (east-west).
struct Radii {
    double meridian;
    double prime_vertical;
};
Radii radii(double latitude);

// What the formulas below share of a latitude [rad] and a height [m], computed once; they are its members.
struct Place {
    Place(const SineCosine<double>& latitude, double height);
    Place(double latitude, double height) : Place(sincos(latitude), height) {}
    explicit Place(const Position& position) : Place(position.latitude, position.height) {}

    double height;  // [m]
    double sin_latitude;
    double cos_latitude;
    double per_cos_latitude;
    double per_w;                      // 1 / sqrt(1 - e^2 sin^2 latitude)
    double per_meridian_radius;        // 1 / (R_M + h) [1/m]
    double per_prime_vertical_radius;  // 1 / (R_N + h) [1/m]

    [[nodiscard]] double tan_latitude() const { return sin_latitude * per_cos_latitude; }
    [[nodiscard]] double gravity() const;
    [[nodiscard]] Eigen::Vector3d rate() const { return {0.0, kRate * cos_latitude, kRate * sin_latitude}; }
    [[nodiscard]] Eigen::Vector3d transport_rate(const Eigen::Vector3d& velocity) const {
        const double east = velocity.x() * per_prime_vertical_radius;
        return {-velocity.y() * per_meridian_radius, east, east * tan_latitude()};
    }
    [[nodiscard]] Eigen::Vector3d position_rate(const Eigen::Vector3d& velocity) const {
        return {velocity.y() * per_meridian_radius,
                velocity.x() * per_prime_vertical_radius * per_cos_latitude, velocity.z()};
    }
};

// Magnitude of normal gravity [m/s2]: Somigliana on the ellipsoid, second-order expansion in height
// (TR8350.2, eq. 4-3). The gravity vector in n is (0, 0, -gravity).
double gravity(double latitude, double height);

// Earth rate in n, w_ie^n [rad/s].
Eigen::Vector3d rate(double latitude);

// Transport rate in n, w_en^n [rad/s], of a vehicle with velocity v^n [m/s]. Singular at the poles.
Eigen::Vector3d transport_rate(const Position& position, const Eigen::Vector3d& velocity);

// d(latitude, longitude, height)/dt for velocity v^n [m/s]; [rad/s, rad/s, m/s]. Singular at the poles.
Eigen::Vector3d position_rate(const Position& position, const Eigen::Vector3d& velocity);

// Position displaced by a small vector in n [m] (first order: metres, not kilometres).
Position displaced(const Position& position, const Eigen::Vector3d& displacement);

// Small vector in n [m] that leads from `from` to `to` (first order; longitudes wrap).
Eigen::Vector3d displacement(const Position& from, const Position& to);

// Earth-fixed Cartesian coordinates (ECEF) of a position [m], and the matrix that turns Earth-fixed
// components into ENU ones there.
Eigen::Vector3d ecef(const Position& position);
Eigen::Matrix3d C_en(const Position& position);

// Position of Earth-fixed Cartesian coordinates [m], from the Earth's crust to satellites: Bowring's formula
// (Survey Review 23(181), 1976), iterated; to rounding.
Position geodetic(const Eigen::Vector3d& ecef);

// Earth-fixed: Earth rate [rad/s], and gravitation at a place [m/s2], gravity without the centrifugal
// acceleration.
Eigen::Vector3d earth_fixed_rate();
Eigen::Vector3d gravitation(const Eigen::Vector3d& ecef);

// What Earth-fixed axes see of an inertial vector after they have turned for `time` seconds.
Eigen::Quaterniond turn(double time);

}  // namespace truenorth::earth
