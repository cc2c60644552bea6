// The motion between points that are known, against closed-form motions and its own derivatives.
#include "plant/passage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "inertial/attitude.hpp"
#include "plant/ship.hpp"

namespace truenorth::plant {
namespace {

const Eigen::Vector3d kUnknown = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

Ship ship_in_waves() {
    Ship ship;
    ship.course = 0.7;
    ship.speed = 10.0;
    ship.sway = {.amplitude = {0.14, 0.10, 0.09},
                 .frequency = Eigen::Vector3d(8.0, 10.0, 6.0).cwiseInverse(),
                 .phase = {0.3, 1.1, 2.0}};
    ship.wave = {.amplitude = {0.5, 0.4, 0.6},
                 .frequency = Eigen::Vector3d(7.0, 9.0, 8.0).cwiseInverse(),
                 .phase = {0.0, 1.0, 0.5}};
    return ship;
}

KnownPoint point(const Ship& ship, double time, bool with_rates) {
    const Kinematics now = ship.at(time);
    return {.time = time,
            .position = {},
            .velocity = now.velocity,
            .q_bn = Eigen::Quaterniond(now.C_bn),
            .acceleration = with_rates ? now.acceleration : kUnknown,
            .body_rate = with_rates ? now.omega_nb_b : kUnknown};
}

double angle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    return rotation_vector(Eigen::Quaterniond(a.transpose() * b)).norm();
}

// The largest errors of attitude [rad] and velocity [m/s] between points `period` apart, over 24 s.
struct Errors {
    double attitude = 0.0;
    double velocity = 0.0;
};
Errors errors(double period, bool with_rates) {
    const Ship ship = ship_in_waves();
    Errors worst;
    for (int k = 1; k < 24.0 / period; ++k) {
        const auto at = [&](int number) { return point(ship, number * period, with_rates); };
        const Passage passage(at(k - 1), at(k), at(k + 1));
        for (int part = 0; part <= 10; ++part) {
            const double time = (k + 0.1 * part) * period;
            const Kinematics now = passage.at(time);
            const Kinematics truth = ship.at(time);
            worst.attitude = std::max(worst.attitude, angle(truth.C_bn, now.C_bn));
            worst.velocity = std::max(worst.velocity, (now.velocity - truth.velocity).norm());
        }
    }
    return worst;
}

TEST(Passage, HasTheValuesAndTheDerivativesOfBothEnds) {
    const Ship ship = ship_in_waves();
    const Passage passage(std::nullopt, point(ship, 3.0, true), point(ship, 4.5, true));
    for (const double time : {3.0, 4.5}) {
        const Kinematics now = passage.at(time);
        const Kinematics truth = ship.at(time);
        EXPECT_LT(angle(truth.C_bn, now.C_bn), 1e-14);
        EXPECT_LT((now.velocity - truth.velocity).norm(), 1e-13);
        EXPECT_LT((now.omega_nb_b - truth.omega_nb_b).norm(), 1e-14);
        EXPECT_LT((now.acceleration - truth.acceleration).norm(), 1e-14);
    }
}

// The increments are integrals of these derivatives: they must be those of what is put out as the truth.
TEST(Passage, ItsDerivativesAreThoseOfItsValues) {
    const Ship ship = ship_in_waves();
    for (const bool with_rates : {true, false}) {
        const Passage passage(point(ship, 1.0, with_rates), point(ship, 3.0, with_rates),
                              point(ship, 4.5, with_rates));
        constexpr double step = 1e-4;
        for (double time = 3.1; time < 4.5; time += 0.2) {
            const Kinematics before = passage.at(time - step);
            const Kinematics after = passage.at(time + step);
            const Kinematics now = passage.at(time);
            const Eigen::Vector3d turned =
                rotation_vector(Eigen::Quaterniond(before.C_bn.transpose() * after.C_bn));
            EXPECT_LT((turned / (2.0 * step) - now.omega_nb_b).norm(), 1e-8);
            EXPECT_LT(((after.velocity - before.velocity) / (2.0 * step) - now.acceleration).norm(), 1e-8);
        }
    }
}

// Error of a cubic with exact derivatives: h^4 f'''' / 384; of a parabola: h^3 f''' / 15.6.
TEST(Passage, IsOfFourthOrderWithRatesAndOfThirdWithout) {
    const auto order = [](bool with_rates) {
        const Errors coarse = errors(0.2, with_rates);
        const Errors fine = errors(0.1, with_rates);
        return std::pair(std::log2(coarse.attitude / fine.attitude),
                         std::log2(coarse.velocity / fine.velocity));
    };
    const auto [attitude_with, velocity_with] = order(true);
    EXPECT_NEAR(attitude_with, 4.0, 0.1);
    EXPECT_NEAR(velocity_with, 4.0, 0.1);
    const auto [attitude_without, velocity_without] = order(false);
    EXPECT_NEAR(attitude_without, 3.0, 0.1);
    EXPECT_NEAR(velocity_without, 3.0, 0.1);
}

TEST(Passage, ATurnAtAConstantRateIsExactWithoutRates) {
    const Eigen::Vector3d rate(0.3, -0.2, 0.5);
    const auto at = [&](double time) {
        KnownPoint known;
        known.time = time;
        known.velocity = Eigen::Vector3d(1.0, 2.0, 3.0) * time;
        known.q_bn = quaternion(rate * time);
        known.acceleration = known.body_rate = kUnknown;
        return known;
    };
    for (const std::optional<KnownPoint>& before : {std::optional<KnownPoint>(), std::optional(at(0.5))}) {
        const Kinematics now = Passage(before, at(1.0), at(3.0)).at(1.7);
        EXPECT_LT((now.omega_nb_b - rate).norm(), 1e-14);
        EXPECT_LT(angle(quaternion(rate * 1.7).toRotationMatrix(), now.C_bn), 1e-14);
        EXPECT_LT((now.acceleration - Eigen::Vector3d(1.0, 2.0, 3.0)).norm(), 1e-14);
    }
}

TEST(Passage, OneRateThatIsKnownIsUsed) {
    const Ship ship = ship_in_waves();
    KnownPoint end = point(ship, 4.5, false);
    end.body_rate = ship.at(4.5).omega_nb_b;
    const Passage passage(point(ship, 1.0, false), point(ship, 3.0, false), end);
    EXPECT_LT((passage.at(4.5).omega_nb_b - end.body_rate).norm(), 1e-14);
    EXPECT_GT((passage.at(3.0).omega_nb_b - ship.at(3.0).omega_nb_b).norm(), 1e-4);
}

TEST(Passage, OfOnePointGoesOnAsItIs) {
    const Ship ship = ship_in_waves();
    const Kinematics truth = ship.at(2.0);
    const Kinematics now = Passage(point(ship, 2.0, true)).at(2.0);
    EXPECT_LT((now.omega_nb_b - truth.omega_nb_b).norm(), 1e-15);
    EXPECT_EQ(now.velocity, truth.velocity);
    const Kinematics without = Passage(point(ship, 2.0, false)).at(2.5);
    EXPECT_EQ(without.omega_nb_b, Eigen::Vector3d::Zero());
    EXPECT_EQ(without.acceleration, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace truenorth::plant
