#include "error_models/loose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <complex>
#include <numbers>

#include "error_models/central_difference.hpp"
#include "error_models/random_values.hpp"
#include "error_models/two_mechanisations.hpp"
#include "estimation/estimator.hpp"
#include "estimation/standard.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Model = Loose;
using State = Model::State;
using navigation_error::Error;

const Model::Noise kNoise{.angle_random_walk = 2e-6,
                          .velocity_random_walk = 3e-4,
                          .gyro_random_walk = 1e-9,
                          .accelerometer_random_walk = 1e-6,
                          .position_sigma = {5.0, 6.0, 7.0},
                          .velocity_sigma = {0.1, 0.2, 0.3}};

State random_state(RandomValues& random) {
    State x;
    x << random.vector(1e-3), random.vector(0.1), random.vector(10.0), random.vector(1e-6),
        random.vector(1e-2);
    return x;
}

TEST(LooseJacobian, IsTheErrorOfAMechanisationWithSensorErrors) {
    RandomValues random(1);
    const double h = 0.02;
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
                .gyro_error = start.segment<3>(Model::kGyro),
                .accelerometer_error = start.segment<3>(Model::kAccelerometer)};
            return pair.derivative(
                [](const TwoMechanisations& p) -> Error {
                    return navigation_error::local(p.truth.state, p.computed.state);
                },
                h);
        };
        const Error expected = 0.5 * (derivative(x) - derivative(-x));
        const State rate = Model::jacobian(x, interval) * x;
        // As in the test of the navigation errors, for 10 m; h^2 of the turning biases besides.
        EXPECT_LT((rate.head<3>() - expected.head<3>()).norm(), 1e-11);
        EXPECT_LT((rate.segment<3>(3) - expected.segment<3>(3)).norm(), 5e-7);
        EXPECT_LT((rate.segment<3>(6) - expected.tail<3>()).norm(), 1e-6);
        EXPECT_EQ((rate.tail<6>()), Vector<6>::Zero());
    }
}

TEST(LooseTransition, OscillatesWithTheSchulerPeriod) {
    // On the equator at rest, where neither Foucault nor latitude split the period: 2 pi sqrt(R / g).
    const earth::Position position{.latitude = 0.0, .longitude = 0.0, .height = 0.0};
    auto interval =
        interval_of<Model>({60.0, Matrix3d::Identity(), Vector3d(0.0, 0.0, earth::gravity(0.0, 0.0)),
                            Vector3d::Zero(), position});
    const Matrix<9> Phi = Model{}.transition(State::Zero(), interval).topLeftCorner<9, 9>();
    int found = 0;
    for (const std::complex<double>& eigenvalue : Phi.eigenvalues()) {
        const double period = 2.0 * std::numbers::pi * interval.dt / std::abs(std::arg(eigenvalue)) / 60.0;
        if (std::abs(period - 84.4) < 0.3) {
            ++found;
            EXPECT_NEAR(std::abs(eigenvalue), 1.0, 1e-6);
        }
    }
    EXPECT_EQ(found, 4);  // east and north, each a conjugate pair
}

TEST(LoosePropagate, IsTheTransitionMatrix) {
    RandomValues random(2);
    const Model model;
    const auto interval = interval_of<Model>(random.interval());
    const State start = random_state(random);
    Points<Model::kStates, 3> deviations;
    deviations << State::Zero(), random_state(random), random_state(random);
    const auto rate = [&](const State& x) -> State { return Model::jacobian(x, interval) * x; };
    const auto moved = [&](const State& x) { return integrate(x, rate, interval.dt, model.discretisation); };
    State x = start;
    Points<Model::kStates, 3> result = deviations;
    model.propagate(x, result, interval);
    EXPECT_LT((x - moved(start)).norm(), 1e-13);
    for (int i = 0; i < 3; ++i) {
        EXPECT_LT((result.col(i) - moved(deviations.col(i))).norm(), 1e-13);
    }
}

TEST(LooseProcessNoise, GrowsWithTimeAndTheSquaredRandomWalks) {
    RandomValues random(3);
    auto interval = interval_of<Model>(random.interval());
    interval.dt = 0.25;
    State expected;
    expected << Vector3d::Constant(1e-12), Vector3d::Constant(2.25e-8), Vector3d::Zero(),
        Vector3d::Constant(0.25e-18), Vector3d::Constant(0.25e-12);
    const State Q = Model{.noise = kNoise}.process_noise(State::Zero(), interval).diagonal();
    EXPECT_LT((Q - expected).cwiseQuotient(expected + State::Constant(1e-30)).norm(), 1e-12);
}

// The antenna by a mechanisation that is wrong by x, minus the true one.
Model::Fix fix_of(const NavigationState& truth, const State& x, const Vector3d& omega,
                  const Vector3d& lever) {
    const NavigationState computed = navigation_error::retract(truth, x.head<9>());
    const Vector3d measured_omega = omega + x.segment<3>(Model::kGyro);
    return {.position_difference =
                earth::displacement(point_position(truth, lever), point_position(computed, lever)),
            .velocity_difference =
                point_velocity(computed, measured_omega, lever) - point_velocity(truth, omega, lever),
            .antenna = {computed.q_bn.toRotationMatrix(), lever, measured_omega}};
}

TEST(LooseMeasurement, OfTheTrueErrorsHasNoResidual) {
    RandomValues random(4);
    for (int n = 0; n < 50; ++n) {
        State x = random_state(random);
        x.segment<3>(Model::kGyro) *= 1e3;  // so that its lever velocity is seen
        const Model::Fix fix = fix_of(random.navigation_state(), x, random.vector(0.5), random.vector(5.0));
        // Second order: 9 m (1.7e-3)^2 / 2, 17 m 9 m / R, and the same of the lever's velocity.
        EXPECT_LT(Model::residual(x, fix).head<3>().norm(), 1e-4);
        EXPECT_LT(Model::residual(x, fix).tail<3>().norm(), 2e-5);
    }
}

TEST(LooseMeasurement, MatrixIsTheDerivativeOfTheAntennasErrors) {
    RandomValues random(5);
    for (int n = 0; n < 20; ++n) {
        const NavigationState truth = random.navigation_state();
        const Vector3d omega = random.vector(0.5);
        const Vector3d lever = random.vector(5.0);
        const auto difference = [&](const State& x) {
            const Model::Fix fix = fix_of(truth, x, omega, lever);
            Vector<6> z;
            z << fix.position_difference, fix.velocity_difference;
            return z;
        };
        const State zero = State::Zero();
        const Matrix<6, 15> expected = central_difference<6, 15>(difference, zero, 1e-3);
        const Matrix<6, 15> H = Model::measurement_matrix(zero, fix_of(truth, zero, omega, lever));
        EXPECT_LT((H - expected).cwiseAbs().maxCoeff(), 2e-5);  // 1e-6 of the angles, 8.7 m / R tan L
        EXPECT_GT((H.leftCols<3>().norm()), 1.0);
    }
}

TEST(LooseMeasurement, NoiseIsTheSquaredSigmaOfEachComponent) {
    Vector<6> expected;
    expected << 25.0, 36.0, 49.0, 0.01, 0.04, 0.09;
    RandomValues random(9);
    const State x = random_state(random);
    const Model::Fix fix = fix_of(random.navigation_state(), x, random.vector(0.5), random.vector(5.0));
    const Matrix<6> R = Model{.noise = kNoise}.measurement_noise(x, fix);
    EXPECT_LT((R - Matrix<6>(expected.asDiagonal())).norm(), 1e-14);
}

TEST(LooseCorrected, UndoesAKnownErrorAndForgetsIt) {
    RandomValues random(6);
    const NavigationState truth = random.navigation_state();
    const State x = random_state(random);
    const NavigationState corrected = Model::corrected(navigation_error::retract(truth, x.head<9>()), x);
    const Error rest = navigation_error::local(truth, corrected);
    EXPECT_LT(rest.head<3>().norm(), 1e-14);
    EXPECT_LT(rest.segment<3>(3).norm(), 1e-13);
    EXPECT_LT(rest.tail<3>().norm(), 300.0 / 6.3e6 * (1.0 + std::tan(1.2)));  // second order
}

TEST(LooseReset, JacobianIsThatOfTheNavigationErrorsAndLeavesTheBiases) {
    RandomValues random(7);
    const State x = random_state(random);
    Matrix<15> G = Model::reset_jacobian(x);
    EXPECT_EQ((G.topLeftCorner<9, 9>()), navigation_error::correction_jacobian(x.head<9>()));
    G.topLeftCorner<9, 9>().setIdentity();
    EXPECT_EQ(G, Matrix<15>::Identity());
}

// N7: on a linear model the unscented and the extended filter are one.
TEST(LooseFilter, UnscentedAndExtendedAreTheSame) {
    RandomValues random(8);
    State sigma;
    sigma << Vector3d::Constant(1e-3), Vector3d::Constant(0.5), Vector3d::Constant(10.0),
        Vector3d::Constant(1e-6), Vector3d::Constant(1e-2);
    Estimator<Model> extended;
    extended.model.noise = kNoise;
    extended.predictor = Linearised();
    extended.state.setZero();
    extended.covariance = sigma.cwiseAbs2().asDiagonal();
    Estimator<Model> unscented = extended;
    unscented.predictor = Unscented({.alpha = 1.0, .beta = 0.0, .kappa = 0.0});

    const NavigationState truth = random.navigation_state();
    for (int k = 0; k < 100; ++k) {
        const auto interval = interval_of<Model>(random.interval());
        const State error = random_state(random);
        const Model::Fix fix = fix_of(truth, error, random.vector(0.5), random.vector(2.0));
        for (Estimator<Model>* filter : {&extended, &unscented}) {
            filter->predict(interval);
            filter->apply(Standard().correct(filter->covariance, filter->innovate(fix)));
        }
    }
    const State deviation = extended.covariance.diagonal().cwiseSqrt();
    EXPECT_LT((unscented.state - extended.state).cwiseQuotient(deviation).norm(), 1e-7);
    const Matrix<15> difference = unscented.covariance - extended.covariance;
    const Matrix<15> relative = difference.cwiseQuotient(deviation * deviation.transpose());
    EXPECT_LT(relative.norm(), 1e-7);
}

}  // namespace
}  // namespace truenorth
