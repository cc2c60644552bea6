// The sensitivity of what the aids observe is its derivative with respect to the errors of a navigation
// state, as error_models/navigation_error.hpp has them.
#include "aiding/observation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "aiding/body_velocity.hpp"
#include "aiding/heading.hpp"
#include "aiding/height.hpp"
#include "aiding/nonholonomic.hpp"
#include "aiding/standstill.hpp"
#include "error_models/central_difference.hpp"
#include "error_models/navigation_error.hpp"
#include "error_models/random_values.hpp"
#include "estimation/standard.hpp"

namespace truenorth::aiding {
namespace {

using Eigen::Vector3d;
using Errors = Vector<kErrors>;

// The computed state that is off by these errors, and the gyros' with it.
Moment wrong(const Moment& truth, const Errors& errors) {
    return {.state = navigation_error::retract(truth.state, errors.head<9>()),
            .omega_eb_b = truth.omega_eb_b + errors.segment<3>(kGyro),
            .sensors = truth.sensors,
            .gyro_bias = truth.gyro_bias - errors.segment<3>(kGyro)};
}

// Of the channels that were measured.
template <class Sensitivity>
Sensitivity where_measured(Sensitivity sensitivity, const Vector<kChannels>& difference) {
    for (int i = 0; i < kChannels; ++i) {
        if (std::isnan(difference(i))) {
            sensitivity.row(i).setZero();
        }
    }
    return sensitivity;
}

template <class Observe>
void expect_derivative(const Observe& observe, const Moment& truth, double tolerance) {
    const auto measured = [&](const Moment& moment) {  // what was not, depends on nothing
        const Vector<kChannels> difference = observe(moment).difference;
        return Vector<kChannels>(difference.array().isNaN().select(0.0, difference));
    };
    const auto difference = [&](const Errors& errors) { return measured(wrong(truth, errors)); };
    const Matrix<kChannels, kErrors> expected =
        central_difference<kChannels, kErrors>(difference, Errors(Errors::Zero()), 1e-4);
    const Observation found = observe(truth);
    EXPECT_LT((where_measured(found.sensitivity, found.difference) - expected).cwiseAbs().maxCoeff(),
              tolerance);

    // What a sensor's errors are known to be goes into the prediction: what they are more does not.
    const auto known = [&](const Appended::Constants& errors) {
        Moment moment = truth;
        moment.sensors += errors;
        return measured(moment);
    };
    const Matrix<kChannels, kSensorErrors> own = central_difference<kChannels, kSensorErrors>(
        known, Appended::Constants(Appended::Constants::Zero()), 1e-4);
    EXPECT_LT((where_measured(found.own, found.difference) + own).cwiseAbs().maxCoeff(), tolerance);
}

TEST(Observation, SensitivityIsTheDerivativeOfTheDifference) {
    RandomValues random(1);
    for (int n = 0; n < 50; ++n) {
        Moment truth{.state = random.navigation_state(), .omega_eb_b = random.vector(0.5)};
        truth.sensors << 0.01, random.vector(0.02), 0.1, 2.0;
        const Vector3d lever_arm = random.vector(5.0);
        const Vector3d measured = random.vector(20.0);
        expect_derivative([&](const Moment& m) { return body_velocity(m, lever_arm, measured); }, truth,
                          1e-4);
        expect_derivative([&](const Moment& m) { return height(m, 17.0); }, truth, 1e-6);
        expect_derivative([&](const Moment& m) { return nonholonomic(m, lever_arm); }, truth, 1e-4);
        expect_derivative([&](const Moment& m) { return standing(m); }, truth, 1e-4);
        expect_derivative([&](const Moment& m) { return not_turning(m, measured); }, truth, 1e-10);
        if (std::abs((truth.state.q_bn * Vector3d::UnitY()).z()) < 0.95) {
            expect_derivative([&](const Moment& m) { return heading(m, 0.3); }, truth, 1e-4);
        }
    }
}

TEST(Observation, OfTheTruthDiffersByNothing) {
    const Eigen::Matrix3d C_bn = dcm({.roll = 0.1, .pitch = -0.2, .heading = 2.5});
    const Moment truth{.state = {.q_bn = Eigen::Quaterniond(C_bn),
                                 .velocity = {3.0, -4.0, 0.5},
                                 .position = {.latitude = 0.6, .longitude = 1.0, .height = 12.0}},
                       .omega_eb_b = {0.0, 0.0, 0.1}};
    // 2 m forward of the IMU, turning at 0.1 rad/s about up: 0.2 m/s to the left.
    const Vector3d measured = C_bn.transpose() * truth.state.velocity + Vector3d(-0.2, 0.0, 0.0);
    EXPECT_LT(body_velocity(truth, {0.0, 2.0, 0.0}, measured).difference.norm(), 1e-12);
    EXPECT_NEAR(heading(truth, 2.5).difference(0), 0.0, 1e-12);
    EXPECT_NEAR(heading(truth, 2.5 + 6.0).difference(0), -6.0 + 2.0 * 3.141592653589793, 1e-9);
    EXPECT_NEAR(height(truth, 10.0).difference(0), 2.0, 1e-12);
    // Gyros of a body at rest: the Earth, and what they are off by.
    const Moment rest{.state = {.q_bn = truth.state.q_bn, .position = truth.state.position},
                      .gyro_bias = {1e-3, -2e-3, 3e-3}};
    const Vector3d rate = 7.292115e-5 * Vector3d(0.0, std::cos(0.6), std::sin(0.6));
    EXPECT_LT(not_turning(rest, C_bn.transpose() * rate + rest.gyro_bias).difference.norm(), 1e-15);
    EXPECT_EQ(standing(rest).difference.norm(), 0.0);
}

// In a curve an axle follows its own course; 2 m ahead of it, the IMU is swept sideways.
TEST(Observation, WheelsRollForwardWhateverTheIMUDoes) {
    const Eigen::Matrix3d C_bn = dcm({.roll = 0.02, .pitch = 0.05, .heading = 1.2});
    const Vector3d omega(0.0, 0.0, -0.3);
    const Vector3d axle(0.4, -2.0, -0.5);
    const Vector3d imu = Vector3d(0.0, 8.0, 0.0) - omega.cross(axle);
    const Moment truth{.state = {.q_bn = Eigen::Quaterniond(C_bn), .velocity = C_bn * imu, .position = {}},
                       .omega_eb_b = omega};
    const Vector3d difference = nonholonomic(truth, axle).difference;
    EXPECT_NEAR(difference.x(), 0.0, 1e-12);
    EXPECT_TRUE(std::isnan(difference.y()));
    EXPECT_NEAR(difference.z(), 0.0, 1e-12);
    EXPECT_NEAR(nonholonomic(truth, Vector3d::Zero()).difference.x(), 0.6,
                1e-12);  // to the right, as it turns
}

// Standing and a log that measures zero are one measurement.
TEST(Observation, StandingIsALogThatMeasuresNothing) {
    RandomValues random(3);
    const Moment truth{.state = random.navigation_state()};
    const Observation log = body_velocity(truth, Vector3d::Zero(), Vector3d::Zero());
    EXPECT_LT((standing(truth).difference - log.difference).norm(), 1e-12);
    EXPECT_LT((standing(truth).sensitivity - log.sensitivity).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Observation, OfASteepBodyThereIsNoHeading) {
    for (const double pitch : {1.3, 1.5, 1.5707963267948966}) {
        const Eigen::Matrix3d C_bn = dcm({.roll = 0.0, .pitch = pitch, .heading = 0.0});
        Moment steep;
        steep.state.q_bn = Eigen::Quaterniond(C_bn);
        EXPECT_EQ(std::isnan(heading(steep, 0.0).difference(0)), pitch > 1.4);
    }
    const Eigen::Matrix3d upright = dcm({.roll = 0.0, .pitch = 1.5707963267948966, .heading = 0.0});
    EXPECT_TRUE(heading_gradient(Eigen::Quaterniond(upright)).isZero(0.0));
}

TEST(Observation, MakesAnInnovationOfWhatIsMeasured) {
    RandomValues random(2);
    const Moment truth{.state = random.navigation_state(), .omega_eb_b = random.vector(0.5)};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto observation = body_velocity(truth, random.vector(5.0), {nan, 1.0, 2.0});
    const Matrix<kErrors, 4> errors = Matrix<kErrors, 4>::Random();
    const Matrix<4> root = Matrix<4>::Random();
    const Matrix<4> P = root * root.transpose();
    const Vector3d sigma(nan, 0.1, 0.2);
    Appended sensors;
    sensors.prior_sigma << 0.01, 0.1, 0.2, 0.3, 0.0, 0.0;
    sensors.start();
    sensors = sensors.after(Innovation<4, 2>{.residual = Vector<2>::Zero(),
                                             .spread = Matrix<2>::Identity(),
                                             .noise = Matrix<2>::Identity(),
                                             .cross = Matrix<4, 2>::Random()},
                            Matrix<kSensorErrors, 2>(1e-3 * Matrix<kSensorErrors, 2>::Random()));
    const Matrix<4, kSensorErrors> C = sensors.cross<4>();
    ASSERT_FALSE(C.isZero(0.0));
    const auto [innovation, own] = sight_of(observation, sigma, errors, P, sensors);
    EXPECT_EQ(innovation.channels(), 2);
    const Matrix<3, 4> H = observation.sensitivity * errors;
    const Matrix<3, kSensorErrors>& L = observation.own;
    const Matrix<kSensorErrors> S = sensors.covariance();
    for (int i = 1; i < 3; ++i) {
        EXPECT_EQ(innovation.residual(i), observation.difference(i));
        EXPECT_NEAR(innovation.noise(i, i), sigma(i) * sigma(i), 1e-15);
        const Vector<4> h = H.row(i).transpose();
        const Vector<kSensorErrors> l = L.row(i).transpose();
        EXPECT_LT((innovation.cross.col(i) - P * h - C * l).norm(), 1e-9);
        EXPECT_NEAR(innovation.spread(i, i), h.dot(P * h) + l.dot(S * l) + 2.0 * h.dot(C * l), 1e-6);
        EXPECT_LT((own.col(i) - C.transpose() * h - S * l).norm(), 1e-9);
    }
    EXPECT_TRUE(own.col(0).isZero(0.0));
    EXPECT_TRUE(innovation.cross.col(0).isZero(0.0));
    EXPECT_TRUE(innovation.residual.allFinite());
}

// Fifteen states that are the errors themselves: P - P H^T (H P H^T + R)^-1 H P, with H by differences.
TEST(Observation, OfAVehicleThatStandsCorrectsAsADenseFilterDoes) {
    RandomValues random(4);
    const Moment truth{.state = random.navigation_state(), .gyro_bias = random.vector(1e-3)};
    const Vector3d rate = random.vector(1e-3);
    const Matrix<kErrors> root = Matrix<kErrors>::Random();
    const Matrix<kErrors> P = root * root.transpose();
    const double sigma = 0.3;
    const auto expect_dense = [&](const auto& observe) {
        const Matrix<kChannels, kErrors> H = central_difference<kChannels, kErrors>(
            [&](const Errors& errors) { return observe(wrong(truth, errors)).difference; },
            Errors(Errors::Zero()), 1e-4);
        const Observation observation = observe(truth);
        const auto [innovation, own] = sight_of(observation, Vector3d::Constant(sigma),
                                                Matrix<kErrors>(Matrix<kErrors>::Identity()), P, Appended{});
        const auto correction = Standard().correct(P, innovation);
        const Eigen::Matrix3d S = H * P * H.transpose() + sigma * sigma * Eigen::Matrix3d::Identity();
        const Matrix<kErrors, 3> gain = P * H.transpose() * S.inverse();
        EXPECT_LT((correction.deviation - gain * observation.difference).norm(), 1e-6);
        EXPECT_LT((correction.covariance - (P - gain * H * P)).cwiseAbs().maxCoeff(), 1e-6);
        EXPECT_TRUE(own.isZero(0.0));
    };
    expect_dense([](const Moment& m) { return standing(m); });
    expect_dense([&](const Moment& m) { return not_turning(m, rate); });
}

}  // namespace
}  // namespace truenorth::aiding
