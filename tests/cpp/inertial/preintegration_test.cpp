#include "inertial/preintegration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "inertial/attitude.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;
using Bias = Eigen::Matrix<double, 6, 1>;

// Swaying about all axes, as increments of 10 ms.
ImuIncrement increment(int k) {
    const double t = 0.01 * k;
    return {.dt = 0.01,
            .delta_angle = {0.004 * std::sin(3.0 * t), 0.003 * std::cos(2.0 * t), -0.002},
            .delta_velocity = {0.01 * std::cos(4.0 * t), 0.02 * std::sin(5.0 * t), 0.098}};
}

// Increments first .. last - 1, as sensors with these biases measure them.
Preintegration preintegrated(int first, int last, const Bias& bias = Bias::Zero()) {
    Preintegration sum;
    const auto measured = [&](int k) {
        ImuIncrement i = increment(k);
        i.delta_angle -= i.dt * bias.head<3>();
        i.delta_velocity -= i.dt * bias.tail<3>();
        return i;
    };
    for (int k = first; k < last; ++k) {
        sum = sum * Preintegration::of(measured(k - 1), measured(k));
    }
    return sum;
}

ExtendedPose::Tangent difference(const ExtendedPose& a, const ExtendedPose& b) {
    ExtendedPose::Tangent d;
    d << rotation_vector(a.attitude.conjugate() * b.attitude), b.velocity - a.velocity,
        b.position - a.position;
    return d;
}

void expect_same(const Preintegration& a, const Preintegration& b, double tolerance) {
    EXPECT_NEAR(a.duration, b.duration, tolerance);
    EXPECT_LT(difference(a.change, b.change).norm(), tolerance);
    EXPECT_LT((a.bias_jacobian - b.bias_jacobian).norm(), tolerance);
}

TEST(Preintegration, OfConstantRateAndForceIsTheClosedForm) {
    const Vector3d omega(0.2, -0.5, 0.7);
    const Vector3d force(1.0, -2.0, 9.8);
    const double T = 2.0;
    const ImuIncrement i{.dt = 0.01, .delta_angle = 0.01 * omega, .delta_velocity = 0.01 * force};
    Preintegration sum;
    for (int k = 0; k < 200; ++k) {
        sum = sum * Preintegration::of(i, i);
    }
    // dv = integral of exp(w t) f = T J(w T) f. dp is its integral, by Simpson's rule.
    const auto dv = [&](double t) -> Vector3d { return t * left_jacobian(omega * t) * force; };
    Vector3d dp = Vector3d::Zero();
    for (int k = 0; k < 100; ++k) {
        const double t = 0.01 * T * k;
        dp += 0.01 * T / 6.0 * (dv(t) + 4.0 * dv(t + 0.005 * T) + dv(t + 0.01 * T));
    }
    EXPECT_NEAR(sum.duration, T, 1e-12);
    EXPECT_LT(rotation_vector(sum.change.attitude.conjugate() * quaternion(T * omega)).norm(), 1e-13);
    EXPECT_LT((sum.change.velocity - dv(T)).norm(), 1e-6);                                // (w dt)^3 / 24 f T
    EXPECT_LT((sum.change.position - dp).norm(), 2.0 * 10.0 * 0.01 * 0.01 / 12.0 * 0.9);  // w f dt^2 T / 12
}

TEST(Preintegration, DoesNotMindWhereAnIntervalIsCut) {
    const Preintegration a = preintegrated(1, 30);
    const Preintegration b = preintegrated(30, 70);
    const Preintegration c = preintegrated(70, 100);
    expect_same((a * b) * c, a * (b * c), 1e-13);
    expect_same(a * b * c, preintegrated(1, 100), 1e-13);
}

TEST(Preintegration, BiasJacobianIsTheDerivativeWithRespectToTheBiases) {
    const Preintegration sum = preintegrated(1, 100);
    const double h = 1e-4;
    for (int i = 0; i < 6; ++i) {
        const Bias step = h * Bias::Unit(i);
        const ExtendedPose::Tangent expected =
            difference(preintegrated(1, 100, -step).change, preintegrated(1, 100, step).change) / (2.0 * h);
        // Coning and sculling terms also know of the bias: weight times the increments, 0.1 / 12 times dt.
        EXPECT_LT((sum.bias_jacobian.col(i) - expected).norm(), 3e-4 * expected.norm() + 1e-8) << i;
    }
}

TEST(Preintegration, CorrectedIsWhatUnbiasedSensorsWouldHaveGiven) {
    Bias bias;
    bias << 1e-5, -2e-5, 3e-5, 0.02, -0.03, 0.01;
    const ExtendedPose corrected = preintegrated(1, 100).corrected(bias);
    const ExtendedPose expected = preintegrated(1, 100, bias).change;
    // 4e-5 rad times 0.04 m/s, and the share that the test above allows.
    EXPECT_LT(difference(corrected, expected).norm(), 2e-6 + 3e-4 * 0.04);
    EXPECT_GT(difference(corrected, preintegrated(1, 100).change).norm(), 0.03);
}

}  // namespace
}  // namespace truenorth
