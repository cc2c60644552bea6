// The Earth in Earth-centred coordinates: the textbook conversion, an oracle for everything local-level.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "inertial/earth.hpp"

namespace truenorth::ecef {

inline Eigen::Vector3d coordinates(const earth::Position& p) {
    constexpr double a = 6378137.0;
    constexpr double f = 1.0 / 298.257223563;
    constexpr double e2 = f * (2.0 - f);
    const double n = a / std::sqrt(1.0 - e2 * std::sin(p.latitude) * std::sin(p.latitude));
    return {(n + p.height) * std::cos(p.latitude) * std::cos(p.longitude),
            (n + p.height) * std::cos(p.latitude) * std::sin(p.longitude),
            (n * (1.0 - e2) + p.height) * std::sin(p.latitude)};
}

// Columns: east, north, up.
inline Eigen::Matrix3d axes(const earth::Position& p) {
    const double sp = std::sin(p.latitude);
    const double cp = std::cos(p.latitude);
    const double sl = std::sin(p.longitude);
    const double cl = std::cos(p.longitude);
    Eigen::Matrix3d m;
    m << -sl, -sp * cl, cp * cl,  //
        cl, -sp * sl, cp * sl,    //
        0.0, cp, sp;
    return m;
}

// The position a time t after `p`, moved at a constant rate of (latitude, longitude, height).
inline earth::Position moved(const earth::Position& p, const Eigen::Vector3d& rate, double t) {
    return {p.latitude + rate.x() * t, p.longitude + rate.y() * t, p.height + rate.z() * t};
}

}  // namespace truenorth::ecef
