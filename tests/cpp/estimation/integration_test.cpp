#include "estimation/integration.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

// Error at t = 1 of x' = -x^2, x(0) = 1, whose solution is 1 / (1 + t).
double error_of(int steps, Discretisation discretisation) {
    Eigen::Vector<double, 1> x(1.0);
    const auto rate = [](const Eigen::Vector<double, 1>& y) {
        return Eigen::Vector<double, 1>(-y(0) * y(0));
    };
    for (int k = 0; k < steps; ++k) {
        x = integrate(x, rate, 1.0 / steps, discretisation);
    }
    return std::abs(x(0) - 0.5);
}

TEST(Integrate, EulerIsOfFirstOrder) {
    const auto euler = Discretisation::euler;
    EXPECT_NEAR(std::log2(error_of(256, euler) / error_of(512, euler)), 1.0, 0.02);
}

TEST(Integrate, RungeKuttaIsOfFourthOrder) {
    const auto runge_kutta = Discretisation::runge_kutta;
    EXPECT_NEAR(std::log2(error_of(32, runge_kutta) / error_of(64, runge_kutta)), 4.0, 0.1);
}

TEST(Integrate, TakesASetOfPointsAsItTakesEachOfThem) {
    const auto rate = [](const auto& x) { return (x.array().sin() - x.array().square()).matrix().eval(); };
    const Points<3, 5> set = RandomCovariance(8).normal<3, 5>();
    for (const auto discretisation : {Discretisation::euler, Discretisation::runge_kutta}) {
        const Points<3, 5> moved = integrate(set, rate, 0.3, discretisation);
        for (int i = 0; i < 5; ++i) {
            const Vector<3> alone = integrate(Vector<3>(set.col(i)), rate, 0.3, discretisation);
            EXPECT_LT((moved.col(i) - alone).norm(), 1e-15);
        }
    }
}

TEST(Transition, IsTheJacobianOfTheStepOfALinearRate) {
    const Matrix<4> F = RandomCovariance(9).normal<4, 4>();
    const auto rate = [&](const Matrix<4>& x) { return Matrix<4>(F * x); };
    for (const auto discretisation : {Discretisation::euler, Discretisation::runge_kutta}) {
        const Matrix<4> expected = integrate(Matrix<4>(Matrix<4>::Identity()), rate, 0.2, discretisation);
        EXPECT_LT((transition(F, 0.2, discretisation) - expected).norm(), 1e-15);
    }
}

TEST(Transition, ApproachesTheMatrixExponentialWithTheOrderOfTheMethod) {
    // A rotation, whose exponential is known.
    const Matrix<2> F = (Matrix<2>() << 0.0, -1.0, 1.0, 0.0).finished();
    const auto error = [&](double dt, Discretisation discretisation) {
        const Matrix<2> exact =
            (Matrix<2>() << std::cos(dt), -std::sin(dt), std::sin(dt), std::cos(dt)).finished();
        return (transition(F, dt, discretisation) - exact).norm();
    };
    const auto local_order = [&](Discretisation d) { return std::log2(error(0.02, d) / error(0.01, d)); };
    EXPECT_NEAR(local_order(Discretisation::euler), 2.0, 0.02);
    EXPECT_NEAR(local_order(Discretisation::runge_kutta), 5.0, 0.02);
}

}  // namespace
}  // namespace truenorth
