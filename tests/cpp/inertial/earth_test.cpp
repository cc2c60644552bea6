#include "inertial/earth.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "inertial/ecef.hpp"

namespace truenorth::earth {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<Position> places() {
    return {
        {.latitude = 0.0, .longitude = 0.0, .height = 0.0},
        {.latitude = 32.0 * kDegree, .longitude = 118.0 * kDegree, .height = 20.0},
        {.latitude = -45.0 * kDegree, .longitude = -70.0 * kDegree, .height = 5000.0},
        {.latitude = 80.0 * kDegree, .longitude = 179.0 * kDegree, .height = 11000.0},
        {.latitude = -66.0 * kDegree, .longitude = -179.5 * kDegree, .height = -300.0},
    };
}

const Eigen::Vector3d kVelocity(120.0, -80.0, 15.0);

TEST(Gravity, HasThePublishedValuesOnTheEllipsoid) {
    EXPECT_NEAR(gravity(0.0, 0.0), 9.780325, 5e-7);
    EXPECT_NEAR(gravity(45.0 * kDegree, 0.0), 9.806198, 5e-7);
    EXPECT_NEAR(gravity(90.0 * kDegree, 0.0), 9.832185, 5e-7);
    EXPECT_NEAR(gravity(-90.0 * kDegree, 0.0), 9.832185, 5e-7);
}

TEST(Gravity, FallsWithHeightByTheFreeAirGradient) {
    // GRS 80 and WGS-84: (0.30877 - 0.00043 sin^2 L) mGal/m - 0.72e-7 h mGal/m^2 (Torge, Geodesy,
    // section 4.2).
    for (const double latitude : {0.0, 45.0 * kDegree, 90.0 * kDegree}) {
        const double s2 = std::sin(latitude) * std::sin(latitude);
        for (const double h : {-500.0, 1000.0, 10000.0}) {
            const double fall = (3.0877e-6 - 4.3e-9 * s2) * h - 0.72e-12 * h * h;
            // Five published digits of the gradient, two of the second-order term.
            EXPECT_NEAR(gravity(latitude, 0.0) - gravity(latitude, h), fall,
                        2e-10 * std::abs(h) + 0.01e-12 * h * h);
        }
    }
}

TEST(Radii, HaveThePublishedValues) {
    EXPECT_NEAR(radii(0.0).meridian, 6335439.327, 1e-3);
    EXPECT_NEAR(radii(0.0).prime_vertical, 6378137.0, 1e-3);
    EXPECT_NEAR(radii(90.0 * kDegree).meridian, 6399593.626, 1e-3);
    EXPECT_NEAR(radii(90.0 * kDegree).prime_vertical, 6399593.626, 1e-3);
}

TEST(Radii, AreTheDerivativesOfEarthCentredCoordinates) {
    const double h = 1e-4;
    for (const Position& p : places()) {
        const Eigen::Vector3d north =
            (ecef::coordinates({.latitude = p.latitude + h, .longitude = p.longitude, .height = 0.0}) -
             ecef::coordinates({.latitude = p.latitude - h, .longitude = p.longitude, .height = 0.0})) /
            (2.0 * h);
        EXPECT_NEAR(radii(p.latitude).meridian, north.norm(), 0.02);  // h^2 R / 6
        const Eigen::Vector3d surface =
            ecef::coordinates({.latitude = p.latitude, .longitude = p.longitude, .height = 0.0});
        EXPECT_NEAR(radii(p.latitude).prime_vertical * std::cos(p.latitude), surface.head<2>().norm(), 1e-6);
    }
}

TEST(EarthRate, IsTheEarthAxisResolvedInEastNorthUp) {
    for (const Position& p : places()) {
        const Eigen::Vector3d expected = ecef::axes(p).transpose() * Eigen::Vector3d(0.0, 0.0, 7.292115e-5);
        EXPECT_LT((rate(p.latitude) - expected).norm(), 1e-19);
    }
}

TEST(PositionRate, MovesTheEarthCentredPointAtTheVelocity) {
    const double t = 0.01;
    for (const Position& p : places()) {
        const Eigen::Vector3d rate = position_rate(p, kVelocity);
        const Eigen::Vector3d moved =
            (ecef::coordinates(ecef::moved(p, rate, t)) - ecef::coordinates(ecef::moved(p, rate, -t))) /
            (2.0 * t);
        EXPECT_LT((moved - ecef::axes(p) * kVelocity).norm(), 1e-6);  // rounding of 6e6 m over 0.02 s
    }
}

TEST(TransportRate, TurnsTheLocalAxes) {
    const double t = 0.1;
    for (const Position& p : places()) {
        const Eigen::Vector3d rate = position_rate(p, kVelocity);
        const Eigen::Matrix3d turn =
            (ecef::axes(ecef::moved(p, rate, t)) - ecef::axes(ecef::moved(p, rate, -t))) / (2.0 * t);
        const Eigen::Matrix3d skew = ecef::axes(p).transpose() * turn;  // [w_en^n x]
        const Eigen::Vector3d expected(skew(2, 1), skew(0, 2), skew(1, 0));
        EXPECT_LT((transport_rate(p, kVelocity) - expected).norm(), 1e-14);  // of 1e-5 to 1e-4
    }
}

TEST(TransportRate, OfAVehicleAtRestIsZero) {
    EXPECT_EQ(transport_rate({0.5, 1.0, 100.0}, Eigen::Vector3d::Zero()), Eigen::Vector3d::Zero());
}

TEST(Displaced, MovesTheEarthCentredPointByTheDisplacement) {
    const Eigen::Vector3d step(3.0, -4.0, 2.0);
    for (const Position& p : places()) {
        const Eigen::Vector3d moved = ecef::coordinates(displaced(p, step)) - ecef::coordinates(p);
        // Second order: 5 m squared over the radius, times tan 80 deg.
        EXPECT_LT((moved - ecef::axes(p) * step).norm(), 25.0 / 6.3e6 * 6.0);
    }
}

TEST(Displacement, UndoesDisplaced) {
    const Eigen::Vector3d step(30.0, -40.0, 2.0);
    for (const Position& p : places()) {
        EXPECT_LT((displacement(p, displaced(p, step)) - step).norm(), 2e-8);
    }
}

TEST(Displacement, IsShortAcrossTheDateLine) {
    const double near_line = std::numbers::pi - 1e-6;
    const Eigen::Vector3d east = displacement({.latitude = 0.3, .longitude = near_line, .height = 0.0},
                                              {.latitude = 0.3, .longitude = -near_line, .height = 0.0});
    const double arc = 2e-6 * radii(0.3).prime_vertical * std::cos(0.3);
    EXPECT_NEAR(east.x(), arc, 1e-6);
    EXPECT_NEAR(displacement({0.3, -near_line, 0.0}, {0.3, near_line, 0.0}).x(), -arc, 1e-6);
}

TEST(Displaced, WrapsTheLongitudeAtTheDateLine) {
    for (const double side : {1.0, -1.0}) {
        const Position from{.latitude = 0.3, .longitude = side * (std::numbers::pi - 1e-6), .height = 0.0};
        const Eigen::Vector3d step(side * 20.0, 5.0, 1.0);
        const Position to = displaced(from, step);
        EXPECT_LT(side * to.longitude, 0.0);
        EXPECT_LT(std::abs(to.longitude), std::numbers::pi);
        EXPECT_LT((displacement(from, to) - step).norm(), 2e-8);
    }
}

// The example of pymap3d's own tests: 42 N, 82 W, 200 m, and a point seen from there 70 degrees high, 33
// degrees from north, 1000 m away.
TEST(Ecef, IsThatOfPymap3d) {
    constexpr double degree = std::numbers::pi / 180.0;
    const Position observer{.latitude = 42.0 * degree, .longitude = -82.0 * degree, .height = 200.0};
    const Eigen::Vector3d expected(660675.2518247, -4700948.68316, 4245737.66222);
    EXPECT_LT((ecef(observer) - expected).norm(), 1e-5);

    const Eigen::Vector3d seen(660930.192761, -4701424.222957, 4246579.604633);
    const Eigen::Vector3d enu(186.277521, 286.842228, 939.692621);
    EXPECT_LT((C_en(observer) * (seen - expected) - enu).norm(), 1e-5);

    // South and west, below the ellipsoid: geodetic2ecef and enu2uvw of pymap3d 3.2.
    const Position patagonia{.latitude = -52.7 * degree, .longitude = -71.2 * degree, .height = -30.0};
    const Eigen::Vector3d there(1248222.4686492707, -3666629.411366361, -5050358.315221021);
    EXPECT_LT((ecef(patagonia) - there).norm(), 1e-8);
    const Position china{.latitude = 38.03 * degree, .longitude = 114.26 * degree, .height = 1234.5};
    const Eigen::Vector3d turned(-1.3763591848666914, 0.6201680163235264, 3.4235985491529872);
    EXPECT_LT((C_en(china).transpose() * Eigen::Vector3d(1.0, 2.0, 3.0) - turned).norm(), 1e-14);
}

TEST(Geodetic, IsTheInverseOfEarthCentredCoordinates) {
    std::vector<Position> all = places();
    all.push_back({.latitude = 90.0 * kDegree, .longitude = 0.0, .height = 100.0});
    all.push_back({.latitude = 0.5, .longitude = 1.0, .height = 2e7});
    for (const Position& p : all) {
        const Position back = geodetic(ecef::coordinates(p));
        EXPECT_NEAR(back.latitude, p.latitude, 1e-15 * 4.0);
        EXPECT_NEAR(back.longitude, p.longitude, 1e-15 * 4.0);
        EXPECT_NEAR(back.height, p.height, 1e-8);
    }
}

// Gradient of the potential of the WGS-84 ellipsoid by its harmonics J2 to J6 (TR8350.2), by differences.
Eigen::Vector3d harmonic_gravitation(const Eigen::Vector3d& r) {
    const auto potential = [](const Eigen::Vector3d& x) {
        const double s = x.z() / x.norm();
        const double s2 = s * s;
        const double q2 = std::pow(kSemiMajorAxis / x.norm(), 2);
        const double P2 = (3.0 * s2 - 1.0) / 2.0;
        const double P4 = (35.0 * s2 * s2 - 30.0 * s2 + 3.0) / 8.0;
        const double P6 = (231.0 * s2 * s2 * s2 - 315.0 * s2 * s2 + 105.0 * s2 - 5.0) / 16.0;
        return kGravitationalParameter / x.norm() *
               (1.0 - 1.082629821e-3 * q2 * P2 + 2.37091222e-6 * q2 * q2 * P4 -
                6.08347e-9 * q2 * q2 * q2 * P6);
    };
    const double h = 100.0;
    Eigen::Vector3d gradient;
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
        gradient(i) = (potential(r + step) - potential(r - step)) / (2.0 * h);
    }
    return gradient;
}

TEST(Gravitation, IsTheGradientOfThePotential) {
    for (const Position& p : places()) {
        const Eigen::Vector3d r = ecef::coordinates(p);
        // Rounding of the potential over 200 m; normal gravity takes its direction from the ellipsoid below,
        // which at 11 km is off by 1e-5 rad; its expansion in height.
        EXPECT_LT((gravitation(r) - harmonic_gravitation(r)).norm(),
                  1e-6 + 1e-4 * std::abs(p.height) / 11000.0)
            << p.height;
    }
}

TEST(Turn, IsWhatEarthFixedAxesSee) {
    // A quarter of a turn brings the x axis to where y was: what pointed along y points along x.
    const double quarter = 0.5 * std::numbers::pi / kRate;
    EXPECT_LT((turn(quarter) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
    EXPECT_EQ(earth_fixed_rate(), kRate * Eigen::Vector3d::UnitZ());
    EXPECT_LT((turn(100.0) * turn(-100.0) * kVelocity - kVelocity).norm(), 1e-13);
}

}  // namespace
}  // namespace truenorth::earth
