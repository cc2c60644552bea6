#include "plant/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "plant/motions.hpp"

namespace truenorth::plant {
namespace {

Ship turning_ship() {
    Ship ship = swaying_ship();
    ship.turns[0] = {.angle = 90.0 * kDegree, .begin = 10.0, .duration = 60.0};
    ship.turns[1] = {.angle = -40.0 * kDegree, .begin = 50.0, .duration = 30.0};
    return ship;
}

// Five-point derivative; its error is step^4 / 30 times the fifth derivative.
template <class Function>
auto derivative(const Function& f, double t, double step) {
    return ((8.0 * (f(t + step) - f(t - step)) - (f(t + 2.0 * step) - f(t - 2.0 * step))) / (12.0 * step))
        .eval();
}

void expect_exact_derivatives(const Motion& motion, double t, double step) {
    const Kinematics now = at(motion, t);
    const Eigen::Vector3d acceleration =
        derivative([&](double time) { return at(motion, time).velocity; }, t, step);
    const Eigen::Matrix3d C_rate = derivative([&](double time) { return at(motion, time).C_bn; }, t, step);
    EXPECT_LT((now.acceleration - acceleration).norm(), 1e-8) << "t = " << t;
    EXPECT_LT((now.C_bn * skew(now.omega_nb_b) - C_rate).norm(), 1e-8) << "t = " << t;
}

TEST(Motion, DerivativesOfTheShipAreExact) {
    for (const double t : {0.0, 3.7, 22.0, 40.0, 55.0, 65.0, 79.0, 200.0}) {
        expect_exact_derivatives(turning_ship(), t, 5e-3);
    }
}

TEST(Motion, DerivativesOfTheParkedVehicleAreExact) {
    for (const double t : {0.0, 0.0123, 1.7, 30.0}) {
        expect_exact_derivatives(parked_vehicle(), t, 1e-4);
    }
}

TEST(Motion, DerivativesOfTheFlightAreExact) {
    for (const double t :
         {-1.0, 13.0, 39.0, 44.0, 50.5, 80.0, 95.0, 117.0, 140.0, 163.0, 199.0, 215.0, 240.0}) {
        expect_exact_derivatives(eventful_flight(), t, 5e-3);
    }
}

TEST(Motion, DerivativesOfTheRoadVehicleAreExact) {
    for (const double t : {-1.0, 5.0, 12.0, 14.5, 20.0, 26.0, 31.0, 40.0, 57.0, 60.0, 80.0}) {
        expect_exact_derivatives(drive_with_stops(), t, 5e-3);
    }
}

TEST(Motion, TheShipSwaysAsDeclared) {
    const Ship ship = swaying_ship();
    const double t = 3.0;
    const double yaw = 5.0 * kDegree * std::sin(2.0 * std::numbers::pi * t / 6.0 + 2.0);
    const EulerAngles attitude = euler_angles(ship.at(t).C_bn);
    EXPECT_NEAR(attitude.roll, 8.0 * kDegree * std::sin(2.0 * std::numbers::pi * t / 8.0 + 0.3), 1e-14);
    EXPECT_NEAR(attitude.pitch, 6.0 * kDegree * std::sin(2.0 * std::numbers::pi * t / 10.0 + 1.1), 1e-14);
    EXPECT_NEAR(wrap_angle(attitude.heading - (0.3 - yaw)), 0.0, 1e-14);
}

TEST(Motion, TheShipRidesTheWaves) {
    Ship ship = swaying_ship();
    ship.speed = 0.0;
    const Eigen::Vector3d velocity = ship.at(3.0).velocity;
    EXPECT_NEAR(velocity.x(), 0.5 * std::sin(2.0 * std::numbers::pi * 3.0 / 7.0), 1e-14);
    EXPECT_NEAR(velocity.y(), 0.5 * std::sin(2.0 * std::numbers::pi * 3.0 / 9.0 + 1.0), 1e-14);
    EXPECT_NEAR(velocity.z(), 0.5 * std::sin(2.0 * std::numbers::pi * 3.0 / 8.0 + 0.5), 1e-14);
}

TEST(Motion, ATurnIsClockwiseAndTheVelocityFollowsIt) {
    Ship ship = turning_ship();
    ship.course = 0.0;
    ship.sway.amplitude.setZero();
    ship.wave.amplitude.setZero();
    ship.turns[1] = {};
    EXPECT_LT((ship.at(10.0).velocity - Eigen::Vector3d(0, 10, 0)).norm(), 1e-14);
    EXPECT_LT((ship.at(70.0).velocity - Eigen::Vector3d(10, 0, 0)).norm(), 1e-13);
    EXPECT_NEAR(euler_angles(ship.at(40.0).C_bn).heading, 45.0 * kDegree, 1e-14);  // half-way at half time
    EXPECT_NEAR(euler_angles(ship.at(500.0).C_bn).heading, 90.0 * kDegree, 1e-14);
    EXPECT_NEAR(ship.at(500.0).omega_nb_b.norm(), 0.0, 1e-16);
}

TEST(Motion, TheParkedVehicleSettlesExponentially) {
    ParkedVehicle vehicle = parked_vehicle();
    vehicle.angular_vibration.amplitude.setZero();
    const EulerAngles attitude = euler_angles(vehicle.at(5.0).C_bn);
    EXPECT_NEAR(attitude.roll, 4e-4 * std::exp(-1.0), 1e-14);
    EXPECT_NEAR(attitude.pitch, -3e-4 * std::exp(-1.0), 1e-14);
    EXPECT_NEAR(attitude.heading, 1.0, 1e-14);
}

}  // namespace
}  // namespace truenorth::plant
