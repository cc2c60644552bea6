#include "plant/constellation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "inertial/earth.hpp"
#include "plant/motions.hpp"

namespace truenorth::plant {
namespace {

constexpr double kRadius = 26560e3;

Eigen::Vector3d inertial_velocity(const Satellite& satellite) {
    return satellite.velocity + Eigen::Vector3d(0, 0, earth::kRate).cross(satellite.position);
}

// Direction of the angular momentum, turned back to the frame that does not rotate.
Eigen::Vector3d normal(const Satellite& satellite, double time) {
    return Eigen::AngleAxisd(earth::kRate * time, Eigen::Vector3d::UnitZ()) *
           satellite.position.cross(inertial_velocity(satellite)).normalized();
}

TEST(Constellation, OrbitsAreCirclesOfTheirRadiusAndSpeed) {
    for (const double time : {0.0, 1234.5, 1e6}) {
        for (const Satellite& satellite : constellation(time)) {
            EXPECT_NEAR(satellite.position.norm(), kRadius, 1e-6);
            EXPECT_NEAR(inertial_velocity(satellite).norm(), std::sqrt(3.986004418e14 / kRadius), 1e-9);
            EXPECT_NEAR(satellite.position.normalized().dot(inertial_velocity(satellite)), 0.0, 1e-9);
        }
    }
}

TEST(Constellation, VelocityIsTheDerivativeOfThePositionInTheEarthFixedFrame) {
    constexpr double step = 0.5;  // the error of the difference is step^2 / 6 times 1e-4 m/s3
    const auto before = constellation(5000.0 - step);
    const auto now = constellation(5000.0);
    const auto after = constellation(5000.0 + step);
    for (std::size_t i = 0; i < kSatellites; ++i) {
        const Eigen::Vector3d difference = (after[i].position - before[i].position) / (2.0 * step);
        EXPECT_LT((now[i].velocity - difference).norm(), 1e-5) << "satellite " << i + 1;
    }
}

// Half a sidereal day but for what the rounded radius leaves: the period of GPS.
TEST(Constellation, TheOrbitalPeriodIsHalfASiderealDay) {
    constexpr double half_sidereal_day = 0.5 * 86164.0905;
    const auto latitude_crossing = [](double from) {  // of satellite 1, upwards, by bisection
        double to = from + 100.0;
        while (to - from > 1e-6) {
            const double middle = 0.5 * (from + to);
            (constellation(middle)[0].position.z() < 0.0 ? from : to) = middle;
        }
        return from;
    };
    EXPECT_NEAR(latitude_crossing(-50.0), 0.0, 1e-5);
    EXPECT_NEAR(latitude_crossing(half_sidereal_day - 50.0), half_sidereal_day, 10.0);
    EXPECT_NEAR(latitude_crossing(half_sidereal_day - 50.0), 43077.0, 1.0);
}

TEST(Constellation, SixPlanesOfFourSatellitesAtEqualDistances) {
    const double time = 4321.0;
    const auto satellites = constellation(time);
    for (std::size_t i = 0; i < kSatellites; ++i) {
        const Eigen::Vector3d n = normal(satellites[i], time);
        EXPECT_NEAR(std::acos(n.z()), 55.0 * kDegree, 1e-12);
        const double node = std::atan2(n.x(), -n.y());
        const double plane = static_cast<double>(i / 4);
        EXPECT_NEAR(std::remainder(node - 60.0 * kDegree * plane, 2.0 * std::numbers::pi), 0.0, 1e-12);
        const std::size_t next = i % 4 == 3 ? i - 3 : i + 1;
        EXPECT_NEAR(satellites[i].position.dot(satellites[next].position), 0.0, 1e-6 * kRadius);
    }
}

// From a place on a sphere a satellite is above the elevation e within the central angle acos(R cos(e) / r) -
// e of its zenith; the mean over all places is that cap's share of the sphere.
TEST(Constellation, AsManySatellitesAreInViewAsTheGeometrySays) {
    constexpr double earth_radius = 6371e3;
    constexpr double mask = 10.0 * kDegree;
    const double cap = std::acos(earth_radius / kRadius * std::cos(mask)) - mask;
    const double expected = 24.0 * 0.5 * (1.0 - std::cos(cap));
    constexpr int places = 500;
    int in_view = 0;
    int fewest = 24;
    int most = 0;
    for (int k = 0; k < places; ++k) {  // a Fibonacci lattice, evenly over the sphere, and over a day
        const double z = (2.0 * k + 1.0) / places - 1.0;
        const double longitude = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
        const double r = std::sqrt(1.0 - z * z);
        const Eigen::Vector3d up(r * std::cos(longitude), r * std::sin(longitude), z);
        const auto satellites = constellation(k * 86164.0 / places);
        const auto count =
            static_cast<int>(std::ranges::count_if(satellites, [&](const Satellite& satellite) {
                return up.dot((satellite.position - earth_radius * up).normalized()) > std::sin(mask);
            }));
        in_view += count;
        fewest = std::min(fewest, count);
        most = std::max(most, count);
    }
    EXPECT_NEAR(static_cast<double>(in_view) / places, expected, 0.02 * expected);
    EXPECT_GE(fewest, 4);
    EXPECT_LE(most, 12);
}

}  // namespace
}  // namespace truenorth::plant
