#include "error_models/navigation_error.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>
#include <numbers>

#include "error_models/central_difference.hpp"
#include "error_models/random_values.hpp"
#include "error_models/two_mechanisations.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;
using navigation_error::Error;
using navigation_error::local;
using navigation_error::retract;

Error random_error(RandomValues& random, double phi, double velocity, double position) {
    Error error;
    error << random.vector(phi), random.vector(velocity), random.vector(position);
    return error;
}

TEST(NavigationError, LocalIsTheInverseOfRetract) {
    RandomValues random(1);
    for (int n = 0; n < 50; ++n) {
        const NavigationState x = random.navigation_state();
        const Error error = random_error(random, 1.5, 10.0, 100.0);
        const Error difference = local(x, retract(x, error)) - error;
        EXPECT_LT(difference.head<3>().norm(), 1e-14);
        EXPECT_LT(difference.segment<3>(3).norm(), 1e-13);
        EXPECT_LT(difference.tail<3>().norm(), 1e-8);  // radians of 2e-16 over the Earth's radius
        EXPECT_LT(local(x, x).norm(), 1e-15);
    }
}

TEST(NavigationError, IsSmallAcrossNorthAndTheDateLine) {
    const NavigationState west{
        .q_bn =
            Eigen::Quaterniond(dcm({.roll = 0.0, .pitch = 0.0, .heading = 2.0 * std::numbers::pi - 1e-6})),
        .position = {.latitude = 0.0, .longitude = std::numbers::pi - 1e-9, .height = 0.0}};
    const NavigationState east{
        .q_bn = Eigen::Quaterniond(dcm({.roll = 0.0, .pitch = 0.0, .heading = 1e-6})),
        .position = {.latitude = 0.0, .longitude = -std::numbers::pi + 1e-9, .height = 0.0}};
    const Error error = local(west, east);
    EXPECT_NEAR(error(2), 2e-6, 1e-14);  // a computed heading that is too large: phi_u positive
    EXPECT_NEAR(error(6), 2e-9 * earth::kSemiMajorAxis, 1e-8);
}

TEST(NavigationError, IsRemovedByItsOppositeToSecondOrder) {
    RandomValues random(2);
    for (int n = 0; n < 50; ++n) {
        const NavigationState truth = random.navigation_state();
        const Error error = random_error(random, 1.0, 10.0, 100.0);
        const Error rest = local(truth, retract(retract(truth, error), -error));
        EXPECT_LT(rest.head<3>().norm(), 1e-14);
        EXPECT_LT(rest.segment<3>(3).norm(), 1e-13);
        // (100 m)^2 over the radius, times the tangent of the latitude.
        EXPECT_LT(rest.tail<3>().norm(), 3.0 * 1e4 / 6.3e6 * (1.0 + std::tan(1.2)));
    }
}

TEST(NavigationError, CorrectionJacobianIsTheDerivativeOfWhatRemains) {
    RandomValues random(3);
    for (int n = 0; n < 20; ++n) {
        const NavigationState truth = random.navigation_state();
        const Error estimate = random_error(random, 0.8, 1.0, 10.0);
        const NavigationState computed = retract(truth, estimate);
        // The true error is varied by varying the truth.
        const auto remaining = [&](const Error& error) {
            const NavigationState other{(quaternion(error.head<3>()) * computed.q_bn).normalized(),
                                        computed.velocity - error.segment<3>(3),
                                        earth::displaced(computed.position, -error.tail<3>())};
            return local(other, retract(computed, -estimate));
        };
        const Matrix<9> difference = central_difference<9, 9>(remaining, estimate, 1e-3) -
                                     navigation_error::correction_jacobian(estimate);
        const Matrix<3> angles = difference.topLeftCorner<3, 3>();
        EXPECT_LT(angles.norm(), 1e-6);  // the square of the step
        EXPECT_LT(difference.middleRows<3>(3).norm(), 1e-10);
        EXPECT_LT(difference.bottomRows<3>().norm(), 1e-4);  // 17 m over the radius, 7e-10 m over the step
    }
}

TEST(NavigationError, CorrectionJacobianNeitherGrowsNorShrinksWithoutBound) {
    RandomValues random(5);
    for (int n = 0; n < 200; ++n) {
        const Error error = random_error(random, 20.0, 1.0, 10.0);
        const Matrix<3> angles = navigation_error::correction_jacobian(error).topLeftCorner<3, 3>();
        const Vector3d gain = angles.jacobiSvd().singularValues();
        EXPECT_LT(gain.maxCoeff(), 1.0 + 1e-12);
        EXPECT_GT(gain.minCoeff(), 2.0 / std::numbers::pi - 1e-12);
    }
}

TEST(NavigationErrorJacobian, IsTheErrorOfAMechanisation) {
    RandomValues random(4);
    const double h = 0.02;
    for (int n = 0; n < 30; ++n) {
        const NavigationState truth = random.navigation_state();
        const Vector3d omega_b = random.vector(0.05);
        const Vector3d force_b = random.vector(2.0) + Vector3d(0.0, 0.0, 9.8);
        const NavigationInterval interval(1.0, truth.q_bn.toRotationMatrix(), truth.q_bn * force_b,
                                          truth.velocity, truth.position);
        const auto F = navigation_error::jacobian(interval);
        // d(error)/dt for an error at the start, without what is even in it.
        const auto derivative = [&](const Error& error) -> Error {
            const auto of = [&](const Error& start) {
                const TwoMechanisations pair{.truth = Mechanisation(truth),
                                             .computed = Mechanisation(retract(truth, start)),
                                             .omega_b = omega_b,
                                             .force_b = force_b};
                return pair.derivative(
                    [](const TwoMechanisations& p) -> Error {
                        return local(p.truth.state, p.computed.state);
                    },
                    h);
            };
            return 0.5 * (of(error) - of(-error));
        };
        Error scale;
        scale << Vector3d::Constant(1e-3), Vector3d::Constant(0.1), Vector3d::Constant(50.0);
        Error everything = Error::Zero();
        for (int j = 0; j <= 9; ++j) {
            const Error error = j < 9 ? Error(scale(j) * Error::Unit(j)) : everything;
            everything += error * random(1.0);
            const Error difference = F * error - derivative(error);
            // Rounding, 2e-16 rad over h; for positions the radii's change with latitude, 3 e^2 / 2 at most,
            // in the transport rate.
            const double radii = 1.5 * earth::kEccentricity2 * 170.0 * 50.0 / 4e13 * (1.0 + std::tan(1.2));
            EXPECT_LT(difference.head<3>().norm(), 1e-13 + (j < 6 ? 0.0 : radii)) << j;
            // The normal gravity's change with latitude (5e-3 g / R) and the free-air gradient's 1 %.
            const double gravity = 50.0 * 9.8 / 6.37e6 * (5.3e-3 + 0.02);
            // The quotient's own error, h^2 / 3 of the third derivative of a turning force.
            const double turning = h * h / 3.0 * 0.087 * 0.087 * 12.0 * 1.8e-3;
            EXPECT_LT(difference.segment<3>(3).norm(), turning + (j < 6 ? 0.0 : gravity)) << j;
            EXPECT_LT(difference.tail<3>().norm(), 1e-6) << j;  // 2e-16 rad times the radius, over h
        }
    }
}

}  // namespace
}  // namespace truenorth
