// The mechanisation against closed-form motion: ideal increments of a swaying ship, 600 s at 100 Hz.
#include <gtest/gtest.h>

#include <numbers>

#include "inertial/mechanisation.hpp"
#include "plant/trajectory.hpp"

namespace truenorth {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kArcsecond = kDegree / 3600.0;

// Zhou 2011, section 3.
plant::Ship swaying_ship() {
    plant::Ship ship;
    ship.speed = 10.0;
    ship.sway.amplitude = kDegree * Eigen::Vector3d(8.0, 6.0, 5.0);
    ship.sway.frequency = Eigen::Vector3d(8.0, 10.0, 6.0).cwiseInverse();
    ship.sway.phase = {0.3, 1.1, 2.0};
    return ship;
}

struct Worst {
    double attitude = 0.0;  // [rad]
    double velocity = 0.0;  // [m/s]
};

Worst worst_error(const plant::Ship& ship, int rate) {
    const earth::Position start{.latitude = 32.0 * kDegree, .longitude = 118.0 * kDegree, .height = 0.0};
    const plant::Trajectory trajectory(ship, start);
    auto truth = trajectory.begin(0.0);
    Mechanisation mechanisation({.q_bn = Eigen::Quaterniond(truth.kinematics.C_bn),
                                 .velocity = truth.kinematics.velocity,
                                 .position = start});
    Worst worst;
    for (int k = 1; k <= 600 * rate; ++k) {
        const auto increments = trajectory.advance(truth, static_cast<double>(k) / rate);
        mechanisation.advance({.dt = 1.0 / rate,
                               .delta_angle = increments.delta_angle,
                               .delta_velocity = increments.delta_velocity});
        const Eigen::Quaterniond error =
            Eigen::Quaterniond(truth.kinematics.C_bn).conjugate() * mechanisation.state.q_bn;
        worst.attitude = std::max(worst.attitude, rotation_vector(error).norm());
        worst.velocity =
            std::max(worst.velocity, (mechanisation.state.velocity - truth.kinematics.velocity).norm());
    }
    return worst;
}

TEST(MechanisationCheck, OfASwayingShipStaysBelowAThousandthOfAnArcsecond) {
    const Worst worst = worst_error(swaying_ship(), 100);
    EXPECT_LT(worst.attitude, 1e-3 * kArcsecond);
    EXPECT_LT(worst.velocity, 1e-5);
}

TEST(MechanisationCheck, HoldsInWavesAndTurns) {
    plant::Ship ship = swaying_ship();
    ship.wave.amplitude.setConstant(0.5);
    ship.wave.frequency = Eigen::Vector3d(7.0, 9.0, 8.0).cwiseInverse();
    ship.wave.phase = {0.0, 1.0, 0.5};
    ship.turns[0] = {.angle = 90.0 * kDegree, .begin = 150.0, .duration = 60.0};
    const Worst worst = worst_error(ship, 100);
    EXPECT_LT(worst.attitude, 1e-3 * kArcsecond);
    EXPECT_LT(worst.velocity, 1e-5);
}

}  // namespace
}  // namespace truenorth
