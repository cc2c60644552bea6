// The Earth: WGS-84 ellipsoid, normal gravity, earth rate and transport rate.
//
// Frame: n = ENU (east, north, up) at the geodetic position given. SI units and radians throughout.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "elementary/sincos.hpp"

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
// Number: that of one place, or an array of those of many.
template <class Number>
struct PlaceOf {
    PlaceOf(const SineCosine<Number>& latitude, const Number& height);
    PlaceOf(const Number& latitude, const Number& height) : PlaceOf(sincos(latitude), height) {}
    explicit PlaceOf(const Position& position) : PlaceOf(position.latitude, position.height) {}

    Number height;  // [m]
    Number sin_latitude;
    Number cos_latitude;
    Number per_cos_latitude;
    Number per_w;                      // 1 / sqrt(1 - e^2 sin^2 latitude)
    Number per_meridian_radius;        // 1 / (R_M + h) [1/m]
    Number per_prime_vertical_radius;  // 1 / (R_N + h) [1/m]

    [[nodiscard]] Number tan_latitude() const { return sin_latitude * per_cos_latitude; }
    [[nodiscard]] Number gravity() const;
    [[nodiscard]] Eigen::Vector3d rate() const { return {0.0, kRate * cos_latitude, kRate * sin_latitude}; }

    // Of a velocity, a vector or its three components.
    template <class Components>
    [[nodiscard]] Components transport_rate(const Components& velocity) const {
        const Number east = velocity[0] * per_prime_vertical_radius;
        return {-velocity[1] * per_meridian_radius, east, east * tan_latitude()};
    }
    template <class Components>
    [[nodiscard]] Components position_rate(const Components& velocity) const {
        return {velocity[1] * per_meridian_radius, velocity[0] * per_prime_vertical_radius * per_cos_latitude,
                velocity[2]};
    }
};

using Place = PlaceOf<double>;

// 1 / sqrt(1 - e^2 sin^2 latitude).
template <class Number>
Number per_w_of(const Number& sin_latitude) {
    using std::sqrt;
    return 1.0 / sqrt(1.0 - kEccentricity2 * sin_latitude * sin_latitude);
}

template <class Number>
PlaceOf<Number>::PlaceOf(const SineCosine<Number>& latitude, const Number& height)
    : height(height),
      sin_latitude(latitude.sine),
      cos_latitude(latitude.cosine),
      per_cos_latitude(1.0 / cos_latitude),
      per_w(per_w_of(sin_latitude)) {
    const Number prime_vertical = kSemiMajorAxis * per_w;
    const Number meridian = prime_vertical * (1.0 - kEccentricity2) * per_w * per_w;
    per_meridian_radius = 1.0 / (meridian + height);
    per_prime_vertical_radius = 1.0 / (prime_vertical + height);
}

template <class Number>
Number PlaceOf<Number>::gravity() const {
    constexpr double semi_minor_axis = kSemiMajorAxis * (1.0 - kFlattening);
    constexpr double k = semi_minor_axis * kPolarGravity / (kSemiMajorAxis * kEquatorialGravity) - 1.0;
    constexpr double m =
        kRate * kRate * kSemiMajorAxis * kSemiMajorAxis * semi_minor_axis / kGravitationalParameter;
    const Number s2 = sin_latitude * sin_latitude;
    const Number on_ellipsoid = kEquatorialGravity * (1.0 + k * s2) * per_w;
    const Number h = height / kSemiMajorAxis;
    return on_ellipsoid * (1.0 - 2.0 * (1.0 + kFlattening + m - 2.0 * kFlattening * s2) * h + 3.0 * h * h);
}

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
