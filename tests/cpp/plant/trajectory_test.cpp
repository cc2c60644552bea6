#include "plant/trajectory.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "inertial/ecef.hpp"
#include "inertial/mechanisation.hpp"
#include "plant/motions.hpp"

namespace truenorth::plant {
namespace {

constexpr earth::Position kStart{.latitude = 32.0 * kDegree, .longitude = 118.0 * kDegree, .height = 20.0};

Ship turning_ship() {
    Ship ship = swaying_ship();
    ship.turns[0] = {.angle = 90.0 * kDegree, .begin = 2.0, .duration = 60.0};
    return ship;
}

template <class Function>
Eigen::Matrix<double, 6, 1> simpson(const Function& f, double from, double to) {
    return (to - from) / 6.0 * (f(from) + 4.0 * f(0.5 * (from + to)) + f(to));
}

// Adaptive Simpson quadrature with Richardson extrapolation.
template <class Function>
Eigen::Matrix<double, 6, 1> integral(const Function& f, double from, double to, double tolerance) {
    const double middle = 0.5 * (from + to);
    const Eigen::Matrix<double, 6, 1> halves = simpson(f, from, middle) + simpson(f, middle, to);
    const Eigen::Matrix<double, 6, 1> change = (halves - simpson(f, from, to)) / 15.0;
    if (change.cwiseAbs().maxCoeff() < tolerance || to - from < 1e-5) {
        return halves + change;
    }
    return integral(f, from, middle, 0.5 * tolerance) + integral(f, middle, to, 0.5 * tolerance);
}

// Angle error [rad] and velocity error [m/s] of the increments of one IMU sample from `begin` on.
std::array<double, 2> increment_error(const Motion& motion, double begin, double period) {
    const Trajectory trajectory(motion, kStart);
    const Trajectory::State start = trajectory.begin(begin);
    const auto rates = [&](double time) {
        Trajectory::State state = start;
        if (time > begin) {
            trajectory.advance(state, time);
        }
        return (Eigen::Matrix<double, 6, 1>() << state.rates.omega_ib_b, state.rates.f_b).finished();
    };
    const Eigen::Matrix<double, 6, 1> reference = integral(rates, begin, begin + period, 1e-16);
    Trajectory::State state = start;
    const auto [delta_angle, delta_velocity] = trajectory.advance(state, begin + period);
    return {(delta_angle - reference.head<3>()).norm(), (delta_velocity - reference.tail<3>()).norm()};
}

// The mechanisation check allows 1e-3 arcsec = 5e-9 rad and 1e-5 m/s after 60000 samples: if all errors had
// one sign, 8e-14 rad and 1.6e-10 m/s a sample. One hundredth of that is demanded; 61.995 s straddles the end
// of a turn.
TEST(Trajectory, IncrementsOfTheShipAreIntegrals) {
    for (const double begin : {0.0, 1.7, 31.0, 61.995}) {
        const auto [angle, velocity] = increment_error(turning_ship(), begin, 0.01);
        EXPECT_LT(angle, 8e-16) << "t = " << begin;
        EXPECT_LT(velocity, 1.6e-12) << "t = " << begin;
    }
}

// A vibration of 13 Hz is 47 degrees of phase in a 100 Hz sample; errors change sign with it and do not add
// up. Demanded: one millionth of the largest increment of the vibration itself.
TEST(Trajectory, IncrementsOfTheParkedVehicleAreIntegrals) {
    constexpr double phase = 2.0 * std::numbers::pi * 13.0 * 0.01;
    for (const double begin : {0.0, 0.02, 0.05, 7.77}) {
        const auto [angle, velocity] = increment_error(parked_vehicle(), begin, 0.01);
        EXPECT_LT(angle, 1e-6 * 4e-5 * phase) << "t = " << begin;
        EXPECT_LT(velocity, 1e-6 * 6e-4 * phase) << "t = " << begin;
    }
}

TEST(Trajectory, IncrementsOfTheFlightAreIntegrals) {
    for (const double begin : {13.0, 44.0, 80.0, 109.99, 110.0, 180.0}) {
        const auto [angle, velocity] = increment_error(eventful_flight(), begin, 0.01);
        EXPECT_LT(angle, 8e-16) << "t = " << begin;
        EXPECT_LT(velocity, 1.6e-12) << "t = " << begin;
    }
}

// The roll rate has a kink where two segments meet, here at 110 s in the middle of a sample: 0.02 arcsec.
TEST(Trajectory, AJointOfSegmentsWithinASampleCostsLittle) {
    const auto [angle, velocity] = increment_error(eventful_flight(), 109.995, 0.01);
    EXPECT_LT(angle, 0.02 / 3600.0 * kDegree);
    EXPECT_LT(velocity, 1e-7);
}

// Position, and integrals over ten minutes, do not depend on the IMU's rate.
TEST(Trajectory, TheRateOfTheImuDoesNotMatter) {
    const Trajectory trajectory(turning_ship(), kStart);
    const auto run = [&](int rate) {
        Trajectory::State state = trajectory.begin(0.0);
        Eigen::Vector3d angle = Eigen::Vector3d::Zero();
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
        for (int k = 1; k <= 600 * rate; ++k) {
            const auto [delta_angle, delta_velocity] =
                trajectory.advance(state, static_cast<double>(k) / rate);
            angle += delta_angle;
            velocity += delta_velocity;
        }
        return std::tuple(angle, velocity, state.position());
    };
    const auto [angle, velocity, position] = run(100);
    const auto [fine_angle, fine_velocity, fine_position] = run(400);
    EXPECT_LT((angle - fine_angle).norm(), 1e-12);
    EXPECT_LT((velocity - fine_velocity).norm(), 1e-9);
    EXPECT_LT(earth::displacement(fine_position, position).norm(), 1e-7);
}

// ---------------------------------------------------------------- against the Earth-fixed frame e

constexpr double kStep = 0.05;

// The trajectory at `time` and at one and two steps of kStep before and after it.
std::array<Trajectory::State, 5> around(const Trajectory& trajectory, double time) {
    std::array<Trajectory::State, 5> states;
    states[0] = trajectory.begin(time - 2.0 * kStep);
    for (std::size_t i = 1; i < 5; ++i) {
        states[i] = states[i - 1];
        trajectory.advance(states[i], time + kStep * (static_cast<double>(i) - 2.0));
    }
    return states;
}

template <class Matrix>
Matrix first_derivative(const std::array<Matrix, 5>& x) {
    return (8.0 * (x[3] - x[1]) - (x[4] - x[0])) / (12.0 * kStep);
}

template <class Matrix>
Matrix second_derivative(const std::array<Matrix, 5>& x) {
    return (16.0 * (x[3] - 2.0 * x[2] + x[1]) - (x[4] - 2.0 * x[2] + x[0])) / (12.0 * kStep * kStep);
}

// In e: r'' = C_be f^b + g - 2 Omega x r', C_be' = C_be [w_eb x]: no transport rate, no radii of curvature.
TEST(Trajectory, RatesAgreeWithDerivativesInTheEarthFixedFrame) {
    const Trajectory trajectory(turning_ship(), kStart);
    const Eigen::Vector3d Omega(0.0, 0.0, earth::kRate);
    const auto states = around(trajectory, 30.0);
    std::array<Eigen::Vector3d, 5> r;
    std::array<Eigen::Matrix3d, 5> C_be;
    for (std::size_t i = 0; i < 5; ++i) {
        const earth::Position position = states[i].position();
        r[i] = ecef::coordinates(position);
        C_be[i] = ecef::axes(position) * states[i].kinematics.C_bn;
    }
    const Eigen::Vector3d velocity = first_derivative(r);
    const earth::Position position = states[2].position();
    const Eigen::Vector3d gravity =
        ecef::axes(position) * Eigen::Vector3d(0, 0, -earth::gravity(position.latitude, position.height));
    const Eigen::Vector3d f_b =
        C_be[2].transpose() * (second_derivative(r) - gravity + 2.0 * Omega.cross(velocity));
    const Eigen::Matrix3d omega_eb_b = C_be[2].transpose() * first_derivative(C_be);
    const Eigen::Vector3d omega_ib_b =
        Eigen::Vector3d(omega_eb_b(2, 1), omega_eb_b(0, 2), omega_eb_b(1, 0)) + C_be[2].transpose() * Omega;

    EXPECT_LT((ecef::axes(position).transpose() * velocity - states[2].kinematics.velocity).norm(), 1e-6);
    EXPECT_LT((f_b - states[2].rates.f_b).norm(), 2e-6);  // rounding of r: 1e-9 m / kStep^2
    EXPECT_LT((omega_ib_b - states[2].rates.omega_ib_b).norm(), 1e-6);
}

TEST(Trajectory, VelocityOfALeverArmIsTheDerivativeOfItsPosition) {
    const Trajectory trajectory(turning_ship(), kStart);
    const Eigen::Vector3d lever_arm(2.0, -10.0, 25.0);
    const auto states = around(trajectory, 30.0);
    std::array<Eigen::Vector3d, 5> r;
    for (std::size_t i = 0; i < 5; ++i) {
        r[i] = ecef::coordinates(displaced(states[i].position(), states[i].kinematics, lever_arm));
    }
    const earth::Position imu = states[2].position();
    const Eigen::Vector3d velocity = ecef::axes(imu) * velocity_at(imu, states[2].kinematics, lever_arm);
    EXPECT_LT((first_derivative(r) - velocity).norm(), 1e-5);
}

TEST(Trajectory, CrossesTheDateLine) {
    Ship ship = swaying_ship();
    ship.course = 0.5 * std::numbers::pi;
    const Trajectory trajectory(ship, {.latitude = 0.0, .longitude = std::numbers::pi - 1e-7, .height = 0.0});
    Trajectory::State state = trajectory.begin(0.0);
    trajectory.advance(state, 0.1);
    trajectory.advance(state, 0.2);
    EXPECT_NEAR(state.position().longitude, -std::numbers::pi, 1e-6);
}

// The loop closes: the increments, mechanised from a perfect start, give the trajectory back.
void expect_that_the_mechanisation_follows(const Motion& motion, int samples) {
    const Trajectory trajectory(motion, kStart);
    Trajectory::State state = trajectory.begin(0.0);
    Mechanisation mechanisation({
        .q_bn = Eigen::Quaterniond(state.kinematics.C_bn),
        .velocity = state.kinematics.velocity,
        .position = state.position(),
    });
    double attitude_error = 0.0;
    double velocity_error = 0.0;
    for (int k = 1; k <= samples; ++k) {
        const double begin = state.time;
        const auto [delta_angle, delta_velocity] = trajectory.advance(state, k / 100.0);
        mechanisation.advance(
            {.dt = state.time - begin, .delta_angle = delta_angle, .delta_velocity = delta_velocity});
        const Eigen::Matrix3d error =
            mechanisation.state.q_bn.toRotationMatrix() * state.kinematics.C_bn.transpose();
        attitude_error = std::max(attitude_error, rotation_vector(Eigen::Quaterniond(error)).norm());
        velocity_error =
            std::max(velocity_error, (mechanisation.state.velocity - state.kinematics.velocity).norm());
    }
    EXPECT_LT(attitude_error, 1e-3 / 3600.0 * kDegree);
    EXPECT_LT(velocity_error, 1e-5);
}

TEST(Trajectory, TheMechanisationFollowsTheShip) {
    expect_that_the_mechanisation_follows(turning_ship(), 60000);
}

TEST(Trajectory, TheMechanisationFollowsAnEventfulFlight) {
    expect_that_the_mechanisation_follows(eventful_flight(), 60000);
}

// Chen 2019: 100 m/s for 1000 s, here with two turns.
TEST(Trajectory, TheMechanisationFollowsALevelFlightWithTurns) {
    expect_that_the_mechanisation_follows(Flight({.speed = 100.0, .climb_angle = 0.0, .course = 0.0},
                                                 {{{.duration = 300.0},
                                                   {.duration = 60.0, .turn_angle = 90.0 * kDegree},
                                                   {.duration = 240.0},
                                                   {.duration = 60.0, .turn_angle = -90.0 * kDegree}}}),
                                          100000);
}

}  // namespace
}  // namespace truenorth::plant
