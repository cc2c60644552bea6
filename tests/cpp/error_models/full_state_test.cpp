#include "error_models/full_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "error_models/central_difference.hpp"
#include "error_models/random_values.hpp"
#include "estimation/augmented.hpp"
#include "estimation/linearised.hpp"
#include "estimation/unscented.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;
using Model = FullState;
using Deviation = Model::Deviation;
using navigation_error::local;
using navigation_error::retract;

Deviation random_deviation(RandomValues& random) {
    Deviation d;
    d << random.vector(1e-3), random.vector(0.5), random.vector(20.0);
    return d;
}

// A turn with changing rate and force.
ImuIncrement increment(int k) {
    const double t = 0.01 * k;
    return {.dt = 0.01,
            .delta_angle = {0.004 * std::sin(9.0 * t), 0.003 * std::cos(7.0 * t), -0.002},
            .delta_velocity = {0.01 * std::cos(8.0 * t), 0.02 * std::sin(5.0 * t), 0.098}};
}

TEST(FullStatePropagate, IsTheDifferenceOfTwoMechanisations) {
    RandomValues random(1);
    for (int n = 0; n < 10; ++n) {
        const NavigationState start = random.navigation_state();
        const Deviation deviation = random_deviation(random);
        Mechanisation truth(start);
        Mechanisation computed(retract(start, deviation));

        Mechanisation memory(start);
        NavigationState x = start;
        Points<Model::kStates, 2> deviations;
        deviations << Deviation::Zero(), deviation;
        for (int k = 0; k < 500; ++k) {
            truth.advance(increment(k));
            computed.advance(increment(k));
            Model{}.propagate(x, deviations, {.mechanisation = memory, .increment = increment(k)});
            memory.advance(increment(k));
        }
        EXPECT_EQ(x.q_bn.coeffs(), truth.state.q_bn.coeffs());
        EXPECT_EQ(x.velocity, truth.state.velocity);
        EXPECT_EQ(x.position.latitude, truth.state.position.latitude);
        EXPECT_LT(deviations.col(0).head<6>().norm(), 1e-12);  // rounding of 500 steps
        EXPECT_LT(deviations.col(0).tail<3>().norm(), 1e-8);   // the last bit of a latitude is 7e-10 m
        const Deviation difference = local(truth.state, computed.state) - deviations.col(1);
        // All points share the acceleration that carries the velocity to the middle of the step: it is wrong
        // by g phi dt / 2, which turns the frame by that over the radius and bends the path at twice the
        // Earth rate and the transport rate.
        const double velocity = 9.9 * 1.8e-3 * 0.005;
        const double transport = (1.0 + std::tan(1.2)) / 6.3e6;
        EXPECT_LT(difference.head<3>().norm(), 5.0 * velocity * transport);
        EXPECT_LT(difference.segment<3>(3).norm(), 5.0 * velocity * (1.5e-4 + 170.0 * transport));
        EXPECT_LT(difference.tail<3>().norm(), 1e-6);
    }
}

TEST(FullStateTransition, IsTheDerivativeOfThePropagation) {
    RandomValues random(2);
    for (int n = 0; n < 20; ++n) {
        const NavigationState start = random.navigation_state();
        Mechanisation memory(start);
        memory.advance(increment(n));
        const Model::Interval interval{.mechanisation = memory, .increment = increment(n + 1)};
        const auto moved = [&](const Deviation& d) -> Deviation {
            NavigationState x = memory.state;
            Points<Model::kStates, 1> deviation = d;
            Model{}.propagate(x, deviation, interval);
            return deviation;
        };
        // Steps in units of 1e-3 rad, 0.5 m/s, 20 m, so that rounding of the latitude does not matter.
        Deviation scale;
        scale << Vector3d::Constant(1e-3), Vector3d::Constant(0.5), Vector3d::Constant(20.0);
        const auto scaled = [&](const Deviation& d) -> Deviation {
            return moved(d.cwiseProduct(scale)).cwiseQuotient(scale);
        };
        const Matrix<9> expected = central_difference<9, 9>(scaled, Deviation(Deviation::Zero()), 1.0);
        const Matrix<9> Phi = scale.cwiseInverse().asDiagonal() * Model::transition(memory.state, interval) *
                              scale.asDiagonal();
        EXPECT_LT((Phi - expected).cwiseAbs().maxCoeff(), 1e-8);
        // What a step changes at all is more than that.
        EXPECT_GT((expected - Matrix<9>::Identity()).cwiseAbs().maxCoeff(), 1e-4);
    }
}

TEST(FullStateTransition, PredictsTheCovarianceOfTheSigmaPoints) {
    RandomValues random(3);
    const NavigationState start = random.navigation_state();
    Deviation sigma;
    sigma << Vector3d::Constant(1e-3), Vector3d::Constant(0.1), Vector3d::Constant(5.0);
    const Model model{.noise = {.angle_random_walk = 1e-5,
                                .velocity_random_walk = 1e-3,
                                .position_sigma = Vector3d::Ones(),
                                .velocity_sigma = Vector3d::Ones()}};
    NavigationState extended = start;
    NavigationState unscented = start;
    Matrix<9> P = sigma.cwiseAbs2().asDiagonal();
    Matrix<9> P_points = P;
    Mechanisation memory(start);
    for (int k = 0; k < 1000; ++k) {
        const Model::Interval interval{.mechanisation = memory, .increment = increment(k)};
        ASSERT_EQ(Linearised().predict(model, extended, P, interval), Prediction::sound);
        ASSERT_EQ(Unscented({.alpha = 1.0, .beta = 0.0, .kappa = 0.0})
                      .predict(model, unscented, P_points, interval),
                  Prediction::sound);
        memory.advance(increment(k));
    }
    const Deviation deviation = P.diagonal().cwiseSqrt();
    // Second order in 1e-3 rad.
    EXPECT_LT((P_points - P).cwiseQuotient(deviation * deviation.transpose()).norm(), 1e-4);
    EXPECT_LT(local(extended, unscented).cwiseQuotient(deviation).norm(), 1e-2);
}

TEST(FullStateProcessNoise, GrowsWithTimeAndTheSquaredRandomWalks) {
    const Model model{.noise = {.angle_random_walk = 2e-6,
                                .velocity_random_walk = 3e-4,
                                .position_sigma = Vector3d::Ones(),
                                .velocity_sigma = Vector3d::Ones()}};
    Deviation expected;
    expected << Vector3d::Constant(4e-14), Vector3d::Constant(9e-10), Vector3d::Zero();
    const Matrix<9> Q = model.process_noise({}, {.mechanisation = {}, .increment = increment(1)});
    EXPECT_LT((Q - Matrix<9>(expected.asDiagonal())).norm(), 1e-22);
}

TEST(FullStateAugmented, MechanisesThePointsOfTheNoise) {
    // Jing 2023, eqs. 8 to 14, with weights and points in full: 18 states and noises of the sensors in the
    // body's own axes, every one of 37 points through a mechanisation of its own.
    RandomValues random(6);
    const NavigationState start = random.navigation_state();
    Deviation sigma;
    sigma << Vector3d::Constant(1e-3), Vector3d::Constant(0.1), Vector3d::Constant(5.0);
    const Model model{.noise = {.angle_random_walk = 1e-3,
                                .velocity_random_walk = 1e-1,
                                .position_sigma = Vector3d::Ones(),
                                .velocity_sigma = Vector3d::Ones()}};
    const double dt = increment(1).dt;
    Vector<18> deviation = Vector<18>::Zero();
    deviation.head<9>() = sigma;
    deviation.segment<3>(9).setConstant(1e-3 * std::sqrt(dt));   // of delta_angle
    deviation.segment<3>(12).setConstant(1e-1 * std::sqrt(dt));  // of delta_velocity
    const double alpha = 1.0;
    const double beta = 2.0;
    const double distance = alpha * std::sqrt(18.0);  // lambda = 0: the centre has no weight in the mean
    Mechanisation memory(start);
    memory.advance(increment(0));

    const auto moved = [&](const Vector<18>& point) {
        Mechanisation mechanisation = memory;
        mechanisation.state = retract(memory.state, point.head<9>());
        ImuIncrement measured = increment(1);
        measured.delta_angle += point.segment<3>(9);
        measured.delta_velocity += point.segment<3>(12);
        mechanisation.advance(measured);
        return mechanisation.state;
    };
    const NavigationState centre = moved(Vector<18>::Zero());
    Deviation mean = Deviation::Zero();
    std::vector<Deviation> points;
    for (int i = 0; i < 18; ++i) {
        for (const double sign : {1.0, -1.0}) {
            const Vector<18> point = sign * distance * deviation(i) * Vector<18>::Unit(i);
            points.push_back(local(centre, moved(point)));
            mean += points.back() / 36.0;
        }
    }
    Matrix<9> expected = (1.0 - alpha * alpha + beta) * mean * mean.transpose();
    for (const Deviation& point : points) {
        expected += (point - mean) * (point - mean).transpose() / 36.0;
    }

    const Model::Interval interval{.mechanisation = memory, .increment = increment(1)};
    const UnscentedParameters parameters{.alpha = alpha, .beta = beta, .kappa = 0.0};
    NavigationState x = memory.state;
    Matrix<9> P = sigma.cwiseAbs2().asDiagonal();
    ASSERT_EQ(Augmented(parameters).predict(model, x, P, interval), Prediction::sound);
    // The model has its noise along east, north and up: the fourth order in 4e-4 rad tells that apart.
    const Deviation scale = expected.diagonal().cwiseSqrt();
    EXPECT_LT((P - expected).cwiseQuotient(scale * scale.transpose()).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT(local(x, retract(centre, mean)).cwiseQuotient(scale).norm(), 1e-7);

    // A noise of the accelerometers has moved the position by half of dt, which the simplified filter, adding
    // it afterwards, does not know.
    NavigationState x_simple = memory.state;
    Matrix<9> P_simple = sigma.cwiseAbs2().asDiagonal();
    Unscented(parameters).predict(model, x_simple, P_simple, interval);
    const double variance = 1e-2 * dt;
    EXPECT_NEAR(P(Model::kPosition, Model::kVelocity) - P_simple(Model::kPosition, Model::kVelocity),
                variance * dt / 2.0, 1e-2 * variance * dt);
}

TEST(FullStateMeasurement, MatrixIsTheDerivativeOfThePrediction) {
    RandomValues random(4);
    for (int n = 0; n < 20; ++n) {
        const NavigationState x = random.navigation_state();
        const Model::Fix fix{.position = earth::displaced(x.position, random.vector(10.0)),
                             .velocity = random.vector(50.0),
                             .lever_arm = random.vector(5.0),
                             .omega_eb_b = random.vector(0.5)};
        const auto prediction = [&](const Deviation& d) -> Vector<6> {
            return -Model::residual(retract(x, d), fix);
        };
        const Matrix<6, 9> expected =
            central_difference<6, 9>(prediction, Deviation(Deviation::Zero()), 1e-3);
        // 20 m over the radius times the tangent of the latitude; 7e-10 m over the step.
        EXPECT_LT((Model::measurement_matrix(x, fix) - expected).cwiseAbs().maxCoeff(), 2e-5);
    }
}

TEST(FullStateMeasurement, NoiseIsTheSquaredSigmas) {
    Model model;
    model.noise.position_sigma = {2.0, 3.0, 5.0};
    model.noise.velocity_sigma = {0.1, 0.2, 0.4};
    Vector<6> variance;
    variance << 4.0, 9.0, 25.0, 0.01, 0.04, 0.16;
    EXPECT_LT((model.measurement_noise({}, {}) - Matrix<6>(variance.asDiagonal())).norm(), 1e-15);
}

TEST(FullStateMeasurement, OfTheTruthHasNoResidual) {
    RandomValues random(5);
    const NavigationState x = random.navigation_state();
    const Vector3d lever = random.vector(5.0);
    const Vector3d omega = random.vector(0.5);
    const Model::Fix fix{.position = point_position(x, lever),
                         .velocity = point_velocity(x, omega, lever),
                         .lever_arm = lever,
                         .omega_eb_b = omega};
    EXPECT_LT(Model::residual(x, fix).norm(), 1e-8);
    // Measurement minus prediction, east, north, up.
    Model::Fix wrong = fix;
    wrong.position = earth::displaced(fix.position, {1.0, 2.0, 3.0});
    wrong.velocity += Vector3d(4.0, 5.0, 6.0);
    Vector<6> expected;
    expected << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
    EXPECT_LT((Model::residual(x, wrong) - expected).norm(), 1e-8);
}

}  // namespace
}  // namespace truenorth
