#include "error_models/tight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "error_models/central_difference.hpp"
#include "error_models/random_values.hpp"
#include "error_models/two_mechanisations.hpp"
#include "estimation/model.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Model = Tight;
using State = Model::State;
using navigation_error::Error;
using LongVector3 = Eigen::Matrix<long double, 3, 1>;

constexpr int kSatellites = 10;  // of twelve channels

const Model kModel{.noise = {.angle_random_walk = 2e-6,
                             .velocity_random_walk = 3e-4,
                             .gyro_random_walk = 1e-9,
                             .gyro_markov_sigma = 5e-7,
                             .gyro_markov_time = 3600.0,
                             .accelerometer_random_walk = 1e-6,
                             .clock_bias_random_walk = 0.1,
                             .clock_drift_random_walk = 0.01,
                             .pseudorange_sigma = 3.0,
                             .range_rate_sigma = 0.2}};

State random_state(RandomValues& random) {
    State x;
    x << random.vector(1e-3), random.vector(0.1), random.vector(10.0), random.vector(1e-6),
        random.vector(1e-6), random.vector(1e-2), random(1000.0), random(10.0);
    return x;
}

struct Antennas {  // of a true and a computed navigation state
    NavigationState truth;
    NavigationState computed;
    Vector3d omega;
    Vector3d measured_omega;
    Vector3d lever;

    Antennas(RandomValues& random, const State& x)
        : truth(random.navigation_state()),
          computed(navigation_error::retract(truth, x.head<9>())),
          omega(random.vector(0.5)),
          measured_omega(omega + x.segment<3>(Model::kGyro) + x.segment<3>(Model::kGyroMarkov)),
          lever(random.vector(5.0)) {}
};

// What a receiver on the true antenna measures, with the clock of x, and the mechanisation beside it.
Model::Fix fix_of(RandomValues& random, const Antennas& a, const State& x) {
    Model::Fix fix{.channels = {},
                   .position = point_position(a.computed, a.lever),
                   .velocity = point_velocity(a.computed, a.measured_omega, a.lever),
                   .antenna = {a.computed.q_bn.toRotationMatrix(), a.lever, a.measured_omega}};
    const earth::Position position = point_position(a.truth, a.lever);
    const Matrix3d C_ne = earth::C_en(position).transpose();
    const Vector3d antenna = earth::ecef(position);
    const Vector3d velocity = C_ne * point_velocity(a.truth, a.omega, a.lever);
    for (int i = 0; i < kSatellites; ++i) {
        Model::Channel& channel = fix.channels[i];
        const Vector3d up = Vector3d(0.0, 0.0, 1.0) + random.vector(0.7);
        channel.valid = true;
        channel.satellite_position = antenna + 2.2e7 * (C_ne * up.normalized());
        channel.satellite_velocity = random.vector(3000.0);
        const Vector3d line = channel.satellite_position - antenna;
        channel.pseudorange = line.norm() + x(Model::kClockBias);
        channel.range_rate =
            line.normalized().dot(channel.satellite_velocity - velocity) + x(Model::kClockDrift);
    }
    return fix;
}

TEST(TightJacobian, IsTheErrorOfAMechanisationWithSensorErrors) {
    RandomValues random(1);
    for (int n = 0; n < 30; ++n) {
        const NavigationState truth = random.navigation_state();
        const Vector3d omega_b = random.vector(0.05);
        const Vector3d force_b = random.vector(2.0) + Vector3d(0.0, 0.0, 9.8);
        const auto interval = interval_of<Model>(
            {1.0, truth.q_bn.toRotationMatrix(), truth.q_bn * force_b, truth.velocity, truth.position});
        const State x = random_state(random);
        const auto derivative = [&](const State& start) {
            const TwoMechanisations pair{
                .truth = Mechanisation(truth),
                .computed = Mechanisation(navigation_error::retract(truth, start.head<9>())),
                .omega_b = omega_b,
                .force_b = force_b,
                .gyro_error = start.segment<3>(Model::kGyro) + start.segment<3>(Model::kGyroMarkov),
                .accelerometer_error = start.segment<3>(Model::kAccelerometer)};
            return pair.derivative(
                [](const TwoMechanisations& p) -> Error {
                    return navigation_error::local(p.truth.state, p.computed.state);
                },
                0.02);
        };
        const Error expected = 0.5 * (derivative(x) - derivative(-x));
        const State rate = kModel.jacobian(x, interval) * x;
        EXPECT_LT((rate.head<3>() - expected.head<3>()).norm(), 1e-11);
        EXPECT_LT((rate.segment<3>(3) - expected.segment<3>(3)).norm(), 5e-7);
        EXPECT_LT((rate.segment<3>(6) - expected.tail<3>()).norm(), 1e-6);
        EXPECT_EQ(rate.segment<3>(Model::kGyro), Vector3d::Zero());
        EXPECT_LT((rate.segment<3>(Model::kGyroMarkov) + x.segment<3>(Model::kGyroMarkov) / 3600.0).norm(),
                  1e-24);
        EXPECT_EQ(rate.segment<3>(Model::kAccelerometer), Vector3d::Zero());
        EXPECT_EQ(rate(Model::kClockBias), x(Model::kClockDrift));
        EXPECT_EQ(rate(Model::kClockDrift), 0.0);
    }
}

// At the state of the computed mechanisation, for which sensors measure rate and force.
Model::Interval interval_at(const NavigationState& computed, const Vector3d& measured_force) {
    Model::Interval interval(IntervalAverage{}, {}, State::Zero());
    const Matrix3d C_bn = computed.q_bn.toRotationMatrix();
    static_cast<NavigationInterval&>(interval) = {1.0, C_bn, C_bn * measured_force, computed.velocity,
                                                  computed.position};
    interval.computed_position = computed.position;
    interval.computed_velocity = computed.velocity;
    return interval;
}

const Model kNonlinear = [] {
    Model model = kModel;
    model.propagation = Model::Propagation::nonlinear;
    return model;
}();

TEST(TightRate, IsTheErrorOfAMechanisationForErrorsOfAnySize) {
    RandomValues random(12);
    for (int n = 0; n < 30; ++n) {
        const NavigationState truth = random.navigation_state();
        const Vector3d omega_b = random.vector(0.05);
        const Vector3d force_b = random.vector(2.0) + Vector3d(0.0, 0.0, 9.8);
        State x = random_state(random);
        x.head<3>() = random.vector(1.0);           // [rad]
        x.segment<3>(3) = random.vector(40.0);      // [m/s]
        x.segment<3>(6) = random.vector(10.0);      // [m]
        x.segment<6>(Model::kGyro) *= 1e3;          // [rad/s]
        x.segment<3>(Model::kAccelerometer) *= 50;  // [m/s2]
        const TwoMechanisations pair{
            .truth = Mechanisation(truth),
            .computed = Mechanisation(navigation_error::retract(truth, x.head<9>())),
            .omega_b = omega_b,
            .force_b = force_b,
            .gyro_error = x.segment<3>(Model::kGyro) + x.segment<3>(Model::kGyroMarkov),
            .accelerometer_error = x.segment<3>(Model::kAccelerometer)};
        const Error expected = pair.derivative(
            [](const TwoMechanisations& p) -> Error {
                return navigation_error::local(p.truth.state, p.computed.state);
            },
            1e-3);
        const auto interval = interval_at(pair.computed.state, force_b + pair.accelerometer_error);
        const State rate = kNonlinear.rate(x, interval);
        // The quotient's third derivative; of the position 10 m x 40 m/s over the radius besides.
        EXPECT_LT((rate.head<3>() - expected.head<3>()).norm(), 1e-11);
        EXPECT_LT((rate.segment<3>(3) - expected.segment<3>(3)).norm(), 5e-8);
        EXPECT_LT((rate.segment<3>(6) - expected.tail<3>()).norm(), 3e-4);
        // To first order it is not: the linear model is off by far more.
        const State linear = kModel.jacobian(x, interval) * x;
        EXPECT_GT((linear.segment<3>(3) - expected.segment<3>(3)).norm(), 0.05);
    }
}

TEST(TightRate, OfSmallErrorsIsTheLinearOne) {
    RandomValues random(13);
    for (int n = 0; n < 30; ++n) {
        const NavigationState computed = random.navigation_state();
        const auto interval = interval_at(computed, random.vector(2.0) + Vector3d(0.0, 0.0, 9.8));
        const State x = random_state(random);
        const State derivative =
            (kNonlinear.rate(State(1e-2 * x), interval) - kNonlinear.rate(State(-1e-2 * x), interval)) / 2e-2;
        const State expected = kModel.jacobian(x, interval) * x;
        // F leaves out how radii and gravity change with the latitude: 0.052 m/s2 over the radius for 17 m.
        EXPECT_LT((derivative - expected).head<3>().norm(), 1e-12);
        EXPECT_LT((derivative - expected).segment<3>(3).norm(), 2e-7);
        EXPECT_LT((derivative - expected).segment<3>(6).norm(), 1e-12);
        EXPECT_LT((derivative - expected).tail<11>().norm(), 1e-15 + 1e-12 * expected.tail<11>().norm());
    }
}

TEST(TightPropagate, IsLinearOrFollowsTheMechanisation) {
    // A heading that is wrong by 20 degrees, known to 20 degrees, through a second of 3 m/s2: against a
    // mechanisation for each deviation. The linear model misses what is of second order in the angle.
    RandomValues random(14);
    const NavigationState computed = random.navigation_state();
    const Vector3d omega_b(0.0, 0.0, 0.01);
    const Vector3d force_b(3.0, 0.0, 9.8);
    Mechanisation mechanisation(computed);
    IntervalAverage average;
    const double dt = 0.01;
    for (int k = 0; k < 100; ++k) {
        const NavigationState before = mechanisation.state;
        mechanisation.advance({.dt = dt, .delta_angle = dt * omega_b, .delta_velocity = dt * force_b});
        average.add(before, mechanisation, dt);
    }
    const Model::Interval interval(average, computed.position, State::Zero());
    State d = random_state(random);
    d(Model::kPhi + 2) = 0.35;
    Points<20, 2> deviations;
    deviations << State::Zero(), d;
    Mechanisation truth(navigation_error::retract(computed, -d.head<9>()));
    for (int k = 0; k < 100; ++k) {
        truth.advance(
            {.dt = dt,
             .delta_angle = dt * (omega_b - d.segment<3>(Model::kGyro) - d.segment<3>(Model::kGyroMarkov)),
             .delta_velocity = dt * (force_b - d.segment<3>(Model::kAccelerometer))});
    }
    const Error expected = navigation_error::local(truth.state, mechanisation.state);
    const auto moved = [&](const Model& model) {
        State x = State::Zero();
        Points<20, 2> result = deviations;
        model.propagate(x, result, interval);
        EXPECT_LT(x.norm(), 1e-15);
        return State(result.col(1));
    };
    const State nonlinear = moved(kNonlinear);
    const State linear = moved(kModel);
    EXPECT_LT((nonlinear.head<3>() - expected.head<3>()).norm(), 1e-8);
    EXPECT_LT((nonlinear.segment<3>(3) - expected.segment<3>(3)).norm(), 2e-6);
    EXPECT_LT((nonlinear.segment<3>(6) - expected.tail<3>()).norm(), 3e-3);  // averages over a second
    EXPECT_GT((linear.segment<3>(3) - expected.segment<3>(3)).norm(), 0.1);
    EXPECT_EQ(nonlinear(Model::kClockBias), d(Model::kClockBias) + d(Model::kClockDrift));
}

TEST(TightPropagate, AddsTheNoiseWhereItIsLinear) {
    RandomValues random(15);
    const auto interval = interval_of<Model>(random.interval());
    Points<20, 3> noise;
    noise << State::Zero(), random_state(random), random_state(random);
    Points<20, 3> deviations;
    deviations << State::Zero(), State::Zero(), random_state(random);
    Points<20, 3> without = deviations;
    State x = State::Zero();
    kModel.propagate(x, without, interval);
    kModel.propagate(x, deviations, noise, interval);
    EXPECT_EQ(deviations, (without + noise).eval());
}

TEST(TightProcessNoise, KeepsTheMarkovProcessStationary) {
    RandomValues random(2);
    for (const double dt : {0.1, 1.0, 100.0}) {
        auto interval = interval_of<Model>(random.interval());
        interval.dt = dt;
        const State start = State::Zero();
        const Matrix<3> Phi =
            kModel.transition(start, interval).block<3, 3>(Model::kGyroMarkov, Model::kGyroMarkov);
        const Matrix<3> Q =
            kModel.process_noise(start, interval).block<3, 3>(Model::kGyroMarkov, Model::kGyroMarkov);
        const Matrix<3> P = 25e-14 * Matrix<3>::Identity();
        EXPECT_LT((Phi * P * Phi.transpose() + Q - P).norm(), 1e-9 * P.norm()) << dt;
    }
}

TEST(TightProcessNoise, GrowsWithTimeAndTheSquaredRandomWalks) {
    RandomValues random(3);
    auto interval = interval_of<Model>(random.interval());
    interval.dt = 0.25;
    const Matrix<20> Q = kModel.process_noise(State::Zero(), interval);
    State expected = State::Zero();
    expected.segment<3>(Model::kPhi).setConstant(1e-12);
    expected.segment<3>(Model::kVelocity).setConstant(2.25e-8);
    expected.segment<3>(Model::kGyro).setConstant(2.5e-19);
    expected.segment<3>(Model::kGyroMarkov) = Q.diagonal().segment<3>(Model::kGyroMarkov);
    expected.segment<3>(Model::kAccelerometer).setConstant(2.5e-13);
    expected.tail<2>() = Q.diagonal().tail<2>();
    EXPECT_LT((Q.diagonal() - expected).cwiseQuotient(expected + State::Constant(1e-30)).norm(), 1e-12);
    Matrix<20> others = Q;
    others.diagonal().setZero();
    others.bottomRightCorner<2, 2>().setZero();
    EXPECT_EQ(others, Matrix<20>::Zero());
}

// Van Loan 1978: of x' = F x + w, w white of the density G, both blocks of exp([-F G; 0 F^T] T).
Matrix<2> van_loan(const Matrix<2>& F, const Matrix<2>& G, double T) {
    Matrix<4> A = Matrix<4>::Zero();
    A << -F * T, G * T, Matrix<2>::Zero(), F.transpose() * T;
    Matrix<4> exponential = Matrix<4>::Identity();
    Matrix<4> power = Matrix<4>::Identity();
    for (int k = 1; k < 60; ++k) {
        power = (power * A / k).eval();
        exponential += power;
    }
    return exponential.bottomRightCorner<2, 2>().transpose() * exponential.topRightCorner<2, 2>();
}

TEST(TightProcessNoise, OfTheClockIsThatOfVanLoan) {
    RandomValues random(10);
    Matrix<2> F = Matrix<2>::Zero();
    F(0, 1) = 1.0;
    const Matrix<2> G = Eigen::Vector2d(0.1 * 0.1, 0.01 * 0.01).asDiagonal();
    for (const double dt : {0.01, 1.0, 10.0}) {
        auto interval = interval_of<Model>(random.interval());
        interval.dt = dt;
        const Matrix<2> Q = kModel.process_noise(State::Zero(), interval).bottomRightCorner<2, 2>();
        EXPECT_LT((Q - van_loan(F, G, dt)).cwiseQuotient(van_loan(F, G, dt)).norm(), 1e-12) << dt;
    }
}

// The drift's noise has reached the bias already: the process noise is that of the end of the interval.
TEST(TightPropagate, NoiseOfTheClockIsNotDrivenThroughTheIntervalAgain) {
    RandomValues random(11);
    const auto interval = interval_of<Model>(random.interval());
    Points<20, 3> noise = Points<20, 3>::Zero();
    noise(Model::kClockBias, 1) = 2.0;
    noise(Model::kClockDrift, 1) = 0.5;
    noise(Model::kClockDrift, 2) = -0.5;
    for (const Model& model : {kModel, kNonlinear}) {
        Points<20, 3> deviations = Points<20, 3>::Zero();
        State x = State::Zero();
        model.propagate(x, deviations, noise, interval);
        EXPECT_LT((deviations.bottomRows<2>() - noise.bottomRows<2>()).norm(), 1e-12);
    }
}

TEST(TightProcessNoise, OfTheClockDoesNotDependOnTheInterval) {
    // A hundred seconds at once, or as a hundred predictions: the same covariance of bias and drift.
    RandomValues random(11);
    const auto after = [&](int steps) {
        auto interval = interval_of<Model>(random.interval());
        interval.dt = 100.0 / steps;
        Matrix<20> P = Matrix<20>::Zero();
        for (int k = 0; k < steps; ++k) {
            const Matrix<20> Phi = kModel.transition(State::Zero(), interval);
            P = Phi * P * Phi.transpose() + kModel.process_noise(State::Zero(), interval);
        }
        return Matrix<2>(P.bottomRightCorner<2, 2>());
    };
    EXPECT_LT(after(100).cwiseQuotient(after(1)).cwiseAbs().maxCoeff(), 1.0 + 1e-12);
    EXPECT_GT(after(100).cwiseQuotient(after(1)).cwiseAbs().minCoeff(), 1.0 - 1e-12);
}

TEST(TightMeasurement, OfTheTrueErrorsHasNoResidual) {
    RandomValues random(4);
    for (int n = 0; n < 30; ++n) {
        State x = random_state(random);
        x.segment<6>(Model::kGyro) *= 1e3;  // so that its lever velocity is seen
        const Antennas antennas(random, x);
        const Model::Fix fix = fix_of(random, antennas, x);
        const auto residual = Model::residual(x, fix);
        // Second order: (17 m)^2 / R and 9 m (1.7e-3)^2; the velocity's part of the same.
        EXPECT_LT(residual.head<12>().norm(), 1e-3);
        EXPECT_LT(residual.tail<12>().norm(), 1e-4);
        // Every block is needed for that.
        for (const int block :
             {Model::kPhi, Model::kVelocity, Model::kPosition, Model::kGyro, Model::kGyroMarkov}) {
            State without = x;
            without.segment<3>(block).setZero();
            EXPECT_GT(Model::residual(without, fix).norm(), 3e-4) << block;
        }
    }
}

TEST(TightMeasurement, PredictedIsTheDifferenceOfRangesWithoutLossOfDigits) {
    RandomValues random(5);
    for (const double scale : {1.0, 1e-3, 1e-6}) {
        const State x = random_state(random);
        const Antennas antennas(random, x);
        const Model::Fix fix = fix_of(random, antennas, x);
        Points<Model::kStates, 3> deviations;
        deviations << State::Zero(), scale * random_state(random), scale * random_state(random);
        const auto predicted = Model::predicted(x, deviations, fix);
        EXPECT_EQ(predicted.col(0).norm(), 0.0);

        // Errors of the antenna, in words of the paper's equations.
        const Matrix3d C_bn = antennas.computed.q_bn.toRotationMatrix();
        const Vector3d lever = C_bn * antennas.lever;
        const Vector3d lever_velocity = C_bn * antennas.measured_omega.cross(antennas.lever);
        const auto position_error = [&](const State& d) -> LongVector3 {
            const Vector3d phi = d.segment<3>(Model::kPhi);
            return (d.segment<3>(Model::kPosition) + lever.cross(phi)).cast<long double>();
        };
        const auto velocity_error = [&](const State& d) -> LongVector3 {
            const Vector3d phi = d.segment<3>(Model::kPhi);
            const Vector3d eps = d.segment<3>(Model::kGyro) + d.segment<3>(Model::kGyroMarkov);
            const Vector3d turn = earth::transport_rate(fix.position, d.segment<3>(Model::kPosition));
            return (d.segment<3>(Model::kVelocity) + lever_velocity.cross(phi) +
                    C_bn * eps.cross(antennas.lever) + turn.cross(fix.velocity))
                .cast<long double>();
        };
        for (int i = 0; i < kSatellites; ++i) {
            const Model::Channel& channel = fix.channels[i];
            const Matrix3d C_en = earth::C_en(fix.position);
            const LongVector3 line =
                (C_en * (channel.satellite_position - earth::ecef(fix.position))).cast<long double>() +
                position_error(x);
            const LongVector3 velocity =
                (C_en * channel.satellite_velocity - fix.velocity).cast<long double>() + velocity_error(x);
            for (int k = 1; k < 3; ++k) {
                const State d = deviations.col(k);
                const LongVector3 new_line = line + position_error(d);
                const LongVector3 new_velocity = velocity + velocity_error(d);
                const long double range = new_line.norm() - line.norm() + d(Model::kClockBias);
                const long double rate = new_line.normalized().dot(new_velocity) -
                                         line.normalized().dot(velocity) + d(Model::kClockDrift);
                // Long double leaves 1e-12 m of 2e7 m.
                EXPECT_NEAR(predicted(i, k), static_cast<double>(range), 1e-11 + 1e-13 * scale * 1000.0);
                EXPECT_NEAR(predicted(12 + i, k), static_cast<double>(rate), 1e-14 + 1e-12 * scale);
            }
        }
    }
}

TEST(TightMeasurement, MatrixIsTheDerivativeOfThePrediction) {
    RandomValues random(6);
    for (int n = 0; n < 20; ++n) {
        const State x = random_state(random);
        const Antennas antennas(random, x);
        const Model::Fix fix = fix_of(random, antennas, x);
        const auto predicted = [&](const State& d) -> Vector<24> {
            return Model::predicted(x, Points<20, 1>(d), fix);
        };
        const Matrix<24, 20> expected = central_difference<24, 20>(predicted, State(State::Zero()), 1e-2);
        const Matrix<24, 20> H = Model::measurement_matrix(x, fix);
        EXPECT_LT((H - expected).cwiseAbs().maxCoeff(), 1e-11);

        const auto residual = [&](const State& d) -> Vector<24> { return -Model::residual(d, fix); };
        const Matrix<24, 20> of_residual = central_difference<24, 20>(residual, x, 10.0);
        EXPECT_LT((H - of_residual).cwiseAbs().maxCoeff(), 1e-7);
    }
}

TEST(TightMeasurement, RowsOfThePositionAreUnitVectorsToTheSatellites) {
    RandomValues random(7);
    const State x = random_state(random);
    const Antennas antennas(random, x);
    const Model::Fix fix = fix_of(random, antennas, x);
    const Matrix<24, 20> H = Model::measurement_matrix(x, fix);
    const earth::Position position = point_position(antennas.truth, antennas.lever);
    for (int i = 0; i < kSatellites; ++i) {
        const Vector3d u =
            (earth::C_en(position) * (fix.channels[i].satellite_position - earth::ecef(position)))
                .normalized();
        EXPECT_NEAR((H.block<1, 3>(i, Model::kPosition).norm()), 1.0, 1e-14);
        EXPECT_LT((H.block<1, 3>(i, Model::kPosition).transpose() - u).norm(), 1e-5);  // the axes' turn
        EXPECT_LT((H.block<1, 3>(12 + i, Model::kVelocity).transpose() - u).norm(), 1e-5);
        EXPECT_EQ(H(i, Model::kClockBias), 1.0);
        EXPECT_EQ(H(12 + i, Model::kClockDrift), 1.0);
    }
}

TEST(TightMeasurement, LeavesAbsentChannelsOut) {
    RandomValues random(8);
    const State x = random_state(random);
    const Antennas antennas(random, x);
    Model::Fix fix = fix_of(random, antennas, x);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    fix.channels[3] = {.valid = false,
                       .pseudorange = nan,
                       .range_rate = nan,
                       .satellite_position = Vector3d::Constant(nan),
                       .satellite_velocity = Vector3d::Constant(nan)};
    const Model::Mask present = Model::present(fix);
    const Matrix<24, 20> H = Model::measurement_matrix(x, fix);
    const Points<24, 1> predicted = Model::predicted(x, Points<20, 1>(random_state(random)), fix);
    const auto residual = Model::residual(State::Zero(), fix);
    for (int i = 0; i < 12; ++i) {
        const bool valid = i < kSatellites && i != 3;
        for (const int row : {i, 12 + i}) {
            EXPECT_EQ(present(row), valid) << row;
            EXPECT_EQ(residual(row) != 0.0, valid) << row;
            EXPECT_EQ(predicted(row) != 0.0, valid) << row;
            EXPECT_EQ(H.row(row).norm() > 0.0, valid) << row;
        }
    }
    EXPECT_TRUE(H.allFinite() && predicted.allFinite() && residual.allFinite());
}

TEST(TightMeasurement, NoiseIsTheSquaredSigmaOfEachChannel) {
    Vector<24> expected;
    expected << Vector<12>::Constant(9.0), Vector<12>::Constant(0.04);
    const Matrix<24> R = kModel.measurement_noise(State::Zero(), {});
    EXPECT_LT((R - Matrix<24>(expected.asDiagonal())).norm(), 1e-14);
}

TEST(TightCorrected, UndoesAKnownErrorAndKeepsWhatCannotBeFedBack) {
    RandomValues random(9);
    const State x = random_state(random);
    const NavigationState truth = random.navigation_state();
    const Error rest =
        navigation_error::local(truth, Model::corrected(navigation_error::retract(truth, x.head<9>()), x));
    EXPECT_LT(rest.head<3>().norm(), 1e-14);
    EXPECT_LT(rest.segment<3>(3).norm(), 1e-13);
    EXPECT_LT(rest.tail<3>().norm(), 300.0 / 6.3e6 * (1.0 + std::tan(1.2)));  // second order

    State expected = State::Zero();
    expected.segment<3>(Model::kGyroMarkov) = x.segment<3>(Model::kGyroMarkov);
    expected.tail<2>() = x.tail<2>();
    EXPECT_EQ(Model::remaining(x), expected);

    Matrix<20> G = Model::reset_jacobian(x);
    EXPECT_EQ((G.topLeftCorner<9, 9>()), navigation_error::correction_jacobian(x.head<9>()));
    G.topLeftCorner<9, 9>().setIdentity();
    EXPECT_EQ(G, Matrix<20>::Identity());
}

}  // namespace
}  // namespace truenorth
