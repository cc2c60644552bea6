// Motion and IMU: what the plant puts out is what was declared.
#include "components/truth_plant.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "inertial/earth.hpp"
#include "truth_plant_fixture.hpp"

namespace truenorth {
namespace {

using truth_plant::MotionKind;
using truth_plant::Outputs;
using truth_plant::Parameters;

TEST_F(TruthPlantTest, OutputsAreValidAfterInitialisation) {
    plant_.parameters.motion.course = 1.0;
    plant_.parameters.motion.sway.amplitude.setZero();
    plant_.parameters.gnss.lever_arm = {0.0, 0.0, 10.0};
    plant_.initialise(5.0);
    const Outputs& outputs = plant_.outputs;
    EXPECT_EQ(outputs.imu.sample, 0);
    EXPECT_EQ(outputs.imu.time, 5.0);
    EXPECT_EQ(outputs.gnss.sample, 0);
    EXPECT_EQ(outputs.gnss.time, 5.0);
    EXPECT_EQ(outputs.gnss.latitude, plant_.parameters.motion.latitude);
    EXPECT_NEAR(outputs.gnss.height, 10.0, 1e-12);
    EXPECT_NEAR(outputs.truth.heading, 1.0, 1e-15);
    EXPECT_LT((outputs.truth.velocity - 10.0 * Eigen::Vector3d(std::sin(1.0), std::cos(1.0), 0.0)).norm(),
              1e-14);
    EXPECT_GT(outputs.truth.gyro_bias.norm(), 0.0);
    EXPECT_GT(outputs.truth.accelerometer_bias.norm(), 0.0);
}

TEST_F(TruthPlantTest, CountsIncrementsAndStampsTheirEnd) {
    plant_.initialise(0.0);
    plant_.step(0.0, 0.01);
    EXPECT_EQ(plant_.outputs.imu.sample, 1);
    EXPECT_EQ(plant_.outputs.imu.time, 0.01);
    plant_.step(0.01, 0.05);
    EXPECT_EQ(plant_.outputs.imu.sample, 2);
    EXPECT_EQ(plant_.outputs.imu.time, 0.06);
}

TEST_F(TruthPlantTest, AVehicleAtRestFeelsGravityAndTheEarthsRate) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.motion.kind = MotionKind::parked_vehicle;
    parameters.motion.course = std::numbers::pi / 2.0;  // forward points east, right points south
    parameters.motion.settle.angle.setZero();
    parameters.motion.vibration.angle.setZero();
    parameters.motion.vibration.acceleration.setZero();
    plant_.initialise(0.0);
    plant_.step(0.0, 1.0);
    const double latitude = parameters.motion.latitude;
    const Eigen::Vector3d rate = earth::kRate * Eigen::Vector3d(-std::cos(latitude), 0.0, std::sin(latitude));
    EXPECT_LT((plant_.outputs.imu.delta_angle - rate).norm(), 1e-16);
    EXPECT_LT(
        (plant_.outputs.imu.delta_velocity - Eigen::Vector3d(0, 0, earth::gravity(latitude, 0.0))).norm(),
        1e-12);
}

TEST_F(TruthPlantTest, TheDefaultParkedVehicleHardlyMoves) {
    plant_.parameters.motion.kind = MotionKind::parked_vehicle;
    plant_.initialise(0.0);
    for (int k = 0; k < 1000; ++k) {
        run(plant_, k, k + 1);
        const auto& truth = plant_.outputs.truth;
        ASSERT_LT(std::abs(truth.roll) + std::abs(truth.pitch), 0.1 * std::numbers::pi / 180.0);
        ASSERT_LT(std::abs(truth.height), 1e-4);
    }
}

TEST_F(TruthPlantTest, TheParkedVehicleVibratesWithTheAccelerationDeclared) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.motion.kind = MotionKind::parked_vehicle;
    parameters.motion.settle.angle.setZero();
    parameters.motion.vibration.angle.setZero();
    parameters.motion.vibration.acceleration = {0.3, 0.0, 0.0};
    parameters.motion.vibration.frequency.setConstant(5.0);
    plant_.initialise(0.0);
    run(plant_, 0, 10, 10);  // the integral of 0.3 sin(10 pi t) over its positive half wave
    EXPECT_NEAR(plant_.outputs.imu.delta_velocity.x(), 2.0 * 0.3 / (10.0 * std::numbers::pi), 1e-8);
}

TEST_F(TruthPlantTest, AFlightFliesItsSegments) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.motion.kind = MotionKind::flight;
    parameters.motion.course = 0.5;
    parameters.motion.speed = 60.0;
    parameters.motion.height = 300.0;
    parameters.motion.segment.duration.head<4>() = Eigen::Vector4d(10.0, 5.0, 20.0, 5.0);
    parameters.motion.segment.acceleration[0] = 4.0;
    parameters.motion.segment.climb_angle.segment<2>(1).setConstant(0.1);
    parameters.motion.segment.turn_angle[2] = 1.0;
    plant_.initialise(0.0);
    const auto& truth = plant_.outputs.truth;
    EXPECT_NEAR(truth.velocity.norm(), 60.0, 1e-12);
    run(plant_, 0, 1000, 100);
    EXPECT_LT((truth.velocity - 100.0 * Eigen::Vector3d(std::sin(0.5), std::cos(0.5), 0.0)).norm(), 1e-12);
    run(plant_, 1000, 2500, 100);
    EXPECT_NEAR(truth.pitch, 0.1, 1e-14);
    EXPECT_NEAR(truth.heading, 1.0, 1e-14);  // half-way in the turn
    const double course_rate = 1.875 * 1.0 / 20.0;
    EXPECT_NEAR(truth.roll, std::atan(100.0 * course_rate / earth::kStandardGravity), 1e-14);
    run(plant_, 2500, 4000, 100);
    EXPECT_NEAR(truth.heading, 1.5, 1e-14);
    EXPECT_NEAR(truth.pitch, 0.0, 1e-14);
    // The mean climb angle while the nose goes up and down is half of 0.1 rad.
    EXPECT_NEAR(truth.height, 300.0 + 100.0 * std::sin(0.1) * (2.5 + 20.0 + 2.5), 0.5);
}

TEST_F(TruthPlantTest, AnAccelerometerFaultBeginsAndEnds) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.imu.accelerometer.bias_step = {0.0, 0.05 * earth::kStandardGravity, 0.0};
    parameters.imu.accelerometer.bias_step_time = 10.0;
    parameters.imu.accelerometer.bias_step_duration = 30.0;
    plant_.initialise(0.0);
    const auto forward = [&](int from, int to) {
        run(plant_, from, to, 100);
        return plant_.outputs.truth.accelerometer_bias.y();
    };
    EXPECT_EQ(forward(0, 1000), 0.0);
    EXPECT_EQ(forward(1000, 1100), 0.05 * earth::kStandardGravity);
    EXPECT_EQ(forward(1100, 4000), 0.05 * earth::kStandardGravity);
    EXPECT_EQ(forward(4000, 4100), 0.0);
}

TEST_F(TruthPlantTest, TruthBiasesAreWhatTheIncrementsShow) {
    make_perfect(plant_.parameters);
    TruthPlant biased(log_);
    biased.parameters = plant_.parameters;
    biased.parameters.imu.gyro.bias_sigma = 1e-5;
    biased.parameters.imu.gyro.bias_random_walk = 1e-6;
    biased.parameters.imu.gyro.markov_sigma = 1e-5;
    biased.parameters.imu.accelerometer.bias_sigma = 1e-2;
    biased.parameters.imu.accelerometer.bias_random_walk = 1e-3;
    biased.parameters.imu.accelerometer.markov_sigma = 1e-2;
    plant_.initialise(0.0);
    biased.initialise(0.0);
    for (int k = 0; k < 100; ++k) {
        run(plant_, k, k + 1);
        run(biased, k, k + 1);
        const Eigen::Vector3d gyro =
            100.0 * (biased.outputs.imu.delta_angle - plant_.outputs.imu.delta_angle);
        const Eigen::Vector3d accelerometer =
            100.0 * (biased.outputs.imu.delta_velocity - plant_.outputs.imu.delta_velocity);
        ASSERT_LT((gyro - biased.outputs.truth.gyro_bias).norm(), 1e-15);
        ASSERT_LT((accelerometer - biased.outputs.truth.accelerometer_bias).norm(), 1e-12);
    }
}

}  // namespace
}  // namespace truenorth
