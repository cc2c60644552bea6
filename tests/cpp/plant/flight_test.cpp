#include "plant/flight.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "inertial/earth.hpp"
#include "plant/motions.hpp"
#include "plant/trajectory.hpp"

namespace truenorth::plant {
namespace {

constexpr std::array<double, 8> kJoints{0.0, 40.0, 50.0, 110.0, 125.0, 155.0, 200.0, 230.0};

Eigen::Vector3d velocity(double speed, double climb_angle, double course) {
    return speed * Eigen::Vector3d(std::cos(climb_angle) * std::sin(course),
                                   std::cos(climb_angle) * std::cos(course), std::sin(climb_angle));
}

// Unused segments leave no trace; the last state is kept.
TEST(Flight, EachSegmentEndsAsDeclared) {
    const Flight flight = eventful_flight();
    EXPECT_EQ(flight.at(0.0).velocity, Eigen::Vector3d::Zero());
    EXPECT_LT((flight.at(40.0).velocity - velocity(80.0, 0.0, 90.0 * kDegree)).norm(), 1e-12);
    EXPECT_LT((flight.at(50.0).velocity - velocity(90.0, 12.0 * kDegree, 90.0 * kDegree)).norm(), 1e-12);
    EXPECT_LT((flight.at(110.0).velocity - velocity(90.0, 12.0 * kDegree, 210.0 * kDegree)).norm(), 1e-12);
    EXPECT_LT((flight.at(125.0).velocity - velocity(90.0, 0.0, 230.0 * kDegree)).norm(), 1e-12);
    EXPECT_LT((flight.at(200.0).velocity - velocity(90.0, 0.0, 50.0 * kDegree)).norm(), 1e-12);
    const Eigen::Vector3d last = velocity(45.0, -8.0 * kDegree, 20.0 * kDegree);
    EXPECT_LT((flight.at(230.0).velocity - last).norm(), 1e-12);
    EXPECT_LT((flight.at(900.0).velocity - last).norm(), 1e-12);
}

TEST(Flight, CruisesUnacceleratedBeforeBetweenAndAfterTheSegments) {
    for (const double t : {-10.0, 130.0, 150.0, 300.0}) {
        const Kinematics now = eventful_flight().at(t);
        EXPECT_EQ(now.acceleration.norm(), 0.0) << "t = " << t;
        EXPECT_EQ(now.omega_nb_b.norm(), 0.0) << "t = " << t;
        EXPECT_NEAR(euler_angles(now.C_bn).roll, 0.0, 1e-15) << "t = " << t;
    }
}

TEST(Flight, PointsAlongItsVelocity) {
    for (double t = 1.0; t < 240.0; t += 1.7) {
        const Kinematics now = eventful_flight().at(t);
        const Eigen::Vector3d forward = now.C_bn.col(1);
        EXPECT_LT((now.velocity - now.velocity.norm() * forward).norm(), 1e-12) << "t = " << t;
    }
}

// Over an Earth at rest the wings feel no force along them: standard gravity, no Coriolis force.
TEST(Flight, TurnsAreCoordinated) {
    double greatest_bank = 0.0;
    for (double t = 0.0; t < 240.0; t += 0.37) {
        const Kinematics now = eventful_flight().at(t);
        const Eigen::Vector3d f_b =
            now.C_bn.transpose() * (now.acceleration + Eigen::Vector3d(0, 0, earth::kStandardGravity));
        EXPECT_LT(std::abs(f_b.x()), 1e-12) << "t = " << t;
        EXPECT_GT(f_b.z(), 0.0) << "t = " << t;
        greatest_bank = std::max(greatest_bank, std::abs(euler_angles(now.C_bn).roll));
    }
    EXPECT_GT(greatest_bank, 45.0 * kDegree);
}

// On the true Earth what is left along the wings is the Coriolis force and the difference of gravity from the
// standard one.
TEST(Flight, OnTheTrueEarthTheWingsHardlyFeelTheTurn) {
    const earth::Position start{.latitude = 45.0 * kDegree, .longitude = 0.1, .height = 1000.0};
    const Trajectory trajectory(eventful_flight(), start);
    Trajectory::State state = trajectory.begin(0.0);
    for (int k = 1; k < 240; ++k) {
        trajectory.advance(state, k);
        const earth::Position position = state.position();
        const double coriolis = (2.0 * earth::rate(position.latitude) +
                                 earth::transport_rate(position, state.kinematics.velocity))
                                    .cross(state.kinematics.velocity)
                                    .norm();
        const double gravity =
            std::abs(earth::gravity(position.latitude, position.height) - earth::kStandardGravity);
        EXPECT_LT(std::abs(state.rates.f_b.x()), coriolis + gravity + 1e-9) << "t = " << k;
    }
}

// In the middle of a turn the course changes 1.875 times as fast as in the mean.
TEST(Flight, BanksToTheRightInARightTurn) {
    const Flight flight({.speed = 100.0, .climb_angle = 0.0, .course = 0.0},
                        {{{.duration = 60.0, .turn_angle = 90.0 * kDegree}}});
    const double course_rate = 1.875 * 90.0 * kDegree / 60.0;
    const Kinematics now = flight.at(30.0);
    EXPECT_NEAR(euler_angles(now.C_bn).roll, std::atan(100.0 * course_rate / 9.80665), 1e-14);
    EXPECT_NEAR(euler_angles(now.C_bn).heading, 45.0 * kDegree, 1e-14);
    EXPECT_NEAR(now.velocity.norm(), 100.0, 1e-12);
}

// Attitude, rates and acceleration do not jump where one segment meets the next.
TEST(Flight, JointsAreSmooth) {
    constexpr double step = 1e-7;
    const Flight flight = eventful_flight();
    for (const double joint : kJoints) {
        const Kinematics before = flight.at(joint - step);
        const Kinematics after = flight.at(joint + step);
        EXPECT_LT((after.C_bn - before.C_bn).norm(), 10.0 * step) << "t = " << joint;
        EXPECT_LT((after.velocity - before.velocity).norm(), 10.0 * step) << "t = " << joint;
        EXPECT_LT((after.omega_nb_b - before.omega_nb_b).norm(), 10.0 * step) << "t = " << joint;
        EXPECT_LT((after.acceleration - before.acceleration).norm(), 10.0 * step) << "t = " << joint;
    }
}

TEST(Flight, ClimbsAtItsAngle) {
    const Flight flight({.speed = 50.0, .climb_angle = 0.0, .course = 1.0},
                        {{{.duration = 10.0, .climb_angle = 5.0 * kDegree},
                          {.duration = 100.0, .climb_angle = 5.0 * kDegree},
                          {.duration = 10.0}}});
    const Trajectory trajectory(flight, {.latitude = 0.5, .longitude = 0.1, .height = 50.0});
    Trajectory::State state = trajectory.begin(0.0);
    const auto height_at = [&](double time) {
        trajectory.advance(state, time);
        return state.position().height;
    };
    const double begin = height_at(10.0);
    const double end = height_at(110.0);
    EXPECT_NEAR(end - begin, 100.0 * 50.0 * std::sin(5.0 * kDegree), 1e-9);
    // While the nose comes up the mean of the climb angle is half of it; sin(c) = c to 0.1 %.
    EXPECT_NEAR(begin - 50.0, 10.0 * 50.0 * 2.5 * kDegree, 1e-3 * 22.0);
    EXPECT_NEAR(height_at(300.0) - height_at(200.0), 0.0, 1.0);
}

}  // namespace
}  // namespace truenorth::plant
