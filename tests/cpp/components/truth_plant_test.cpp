#include "components/truth_plant.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cereal/archives/binary.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "components/invalid_parameter.hpp"
#include "inertial/earth.hpp"

namespace truenorth {
namespace {

using truth_plant::MotionKind;
using truth_plant::Outputs;
using truth_plant::Parameters;

class Lines : public Log {
  public:
    std::vector<std::string> lines;

    [[nodiscard]] bool listens() const override { return true; }
    void event(const std::string& text) override { lines.push_back(text); }
};

// Every error source at once.
void switch_everything_on(Parameters& parameters) {
    parameters.seed = 42;
    parameters.motion.wave.velocity.setConstant(0.5);
    parameters.motion.turn.angle[0] = 1.0;
    parameters.motion.turn.begin[0] = 1.0;
    parameters.motion.turn.duration[0] = 3.0;
    parameters.imu.gyro.markov_sigma = 1e-6;
    parameters.imu.gyro.wave_sigma = 1e-6;
    parameters.imu.gyro.quantisation = 1e-6;
    parameters.imu.gyro.scale_factor.setConstant(1e-4);
    parameters.imu.gyro.misalignment.setConstant(1e-4);
    parameters.imu.gyro.bias_step.setConstant(1e-6);
    parameters.imu.gyro.bias_step_time = 2.0;
    parameters.imu.accelerometer.markov_sigma = 1e-3;
    parameters.imu.accelerometer.wave_sigma = 1e-3;
    parameters.imu.accelerometer.quantisation = 1e-5;
    parameters.gnss.rate = 10.0;
    parameters.gnss.latency = 0.25;
    parameters.gnss.lever_arm = {1.0, 2.0, 3.0};
    parameters.gnss.velocity_outlier.probability = 0.3;
    parameters.gnss.position_outlier.probability = 0.3;
    parameters.motion.segment.duration.head<3>() = Eigen::Vector3d(1.0, 2.0, 1.5);
    parameters.motion.segment.acceleration[0] = 3.0;
    parameters.motion.segment.climb_angle[1] = 0.1;
    parameters.motion.segment.turn_angle[2] = -0.4;
    parameters.imu.accelerometer.bias_step.setConstant(1e-2);
    parameters.imu.accelerometer.bias_step_time = 1.0;
    parameters.imu.accelerometer.bias_step_duration = 1.5;
    parameters.gnss.outlier_epoch.probability = 0.3;
    parameters.gnss.pseudorange_outlier.probability = 0.3;
    parameters.gnss.range_rate_outlier.probability = 0.3;
    parameters.gnss.satellite_limit = {.count = 3, .begin = 2.0, .end = 4.0};
    parameters.gnss.clock = {.bias = 300.0, .drift = 5.0, .bias_noise = 1.0, .drift_noise = 0.1};
}

void make_perfect(Parameters& parameters) {
    parameters.imu.gyro.bias_sigma = 0.0;
    parameters.imu.gyro.white_noise = 0.0;
    parameters.imu.accelerometer.bias_sigma = 0.0;
    parameters.imu.accelerometer.white_noise = 0.0;
    parameters.gnss.position_sigma.setZero();
    parameters.gnss.velocity_sigma.setZero();
    parameters.gnss.pseudorange_sigma = 0.0;
    parameters.gnss.range_rate_sigma = 0.0;
}

std::string bytes(const Outputs& outputs) {
    std::ostringstream stream;
    cereal::BinaryOutputArchive{stream}(outputs);
    return stream.str();
}

// IMU periods from the start, `periods` a step.
void run(TruthPlant& plant, int from, int to, int periods = 1) {
    for (int k = from; k < to; k += periods) {
        plant.step(k / plant.parameters.imu.rate, periods / plant.parameters.imu.rate);
    }
}

class TruthPlantTest : public testing::Test {
  protected:
    Lines log_;
    TruthPlant plant_{log_};
};

// ---------------------------------------------------------------- outputs

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
    biased.parameters.imu.gyro.markov_sigma = 1e-5;
    biased.parameters.imu.accelerometer.bias_sigma = 1e-2;
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

// ---------------------------------------------------------------- GNSS

TEST_F(TruthPlantTest, FixesComeEveryPeriodFromTheFirstOn) {
    make_perfect(plant_.parameters);
    plant_.initialise(0.0);
    run(plant_, 0, 99);
    EXPECT_EQ(plant_.outputs.gnss.sample, 0);
    run(plant_, 99, 100);
    EXPECT_EQ(plant_.outputs.gnss.sample, 1);
    EXPECT_EQ(plant_.outputs.gnss.time, 1.0);
    EXPECT_EQ(plant_.outputs.gnss.latitude, plant_.outputs.truth.latitude);
    EXPECT_EQ(plant_.outputs.gnss.velocity, plant_.outputs.truth.velocity);
    run(plant_, 100, 350);
    EXPECT_EQ(plant_.outputs.gnss.sample, 3);
    EXPECT_EQ(plant_.outputs.gnss.time, 3.0);
}

TEST_F(TruthPlantTest, OfSeveralFixesInAStepTheLastIsPutOutAndAllAreCounted) {
    plant_.initialise(0.0);
    plant_.step(0.0, 3.5);
    EXPECT_EQ(plant_.outputs.gnss.sample, 3);
    EXPECT_EQ(plant_.outputs.gnss.time, 3.0);
    EXPECT_EQ(plant_.outputs.imu.sample, 1);
}

TEST_F(TruthPlantTest, ALateFixIsTheSameFix) {
    TruthPlant late(log_);
    late.parameters.gnss.latency = 0.123;  // appears with the first sample at or after 0.123 s
    plant_.initialise(0.0);
    late.initialise(0.0);
    run(plant_, 0, 100);
    run(late, 0, 112);
    EXPECT_EQ(late.outputs.gnss.sample, 0);
    run(late, 112, 113);
    EXPECT_EQ(late.outputs.gnss.sample, 1);
    EXPECT_EQ(late.outputs.gnss.time, 1.0);
    EXPECT_EQ(late.outputs.gnss.latitude, plant_.outputs.gnss.latitude);
    EXPECT_EQ(late.outputs.gnss.velocity, plant_.outputs.gnss.velocity);
}

TEST_F(TruthPlantTest, MoreThanAPeriodOfLatencyKeepsFixesUnderWay) {
    plant_.parameters.gnss.rate = 10.0;
    plant_.parameters.gnss.latency = 3.1;  // the most that is allowed
    plant_.initialise(0.0);
    for (int k = 0; k < 1000; ++k) {
        run(plant_, k, k + 1);
        const int fixes = std::max(0, (k + 1 - 310) / 10);
        ASSERT_EQ(plant_.outputs.gnss.sample, fixes) << "after sample " << k + 1;
        ASSERT_EQ(plant_.outputs.gnss.time, fixes / 10.0);
    }
}

TEST_F(TruthPlantTest, AnOutageLosesFixesAndLeavesTheOthersAsTheyWere) {
    TruthPlant dark(log_);
    dark.parameters.gnss.outage.begin[0] = 3.0;
    dark.parameters.gnss.outage.end[0] = 6.0;
    plant_.initialise(0.0);
    dark.initialise(0.0);
    run(plant_, 0, 550);
    run(dark, 0, 550);
    EXPECT_EQ(plant_.outputs.gnss.sample, 5);
    EXPECT_EQ(dark.outputs.gnss.sample, 2);
    EXPECT_EQ(dark.outputs.gnss.time, 2.0);
    EXPECT_EQ(log_.lines,
              (std::vector<std::string>{"fix at 3 s lost: gnss.outage", "fix at 4 s lost: gnss.outage",
                                        "fix at 5 s lost: gnss.outage"}));
    run(plant_, 550, 600);
    run(dark, 550, 600);
    EXPECT_EQ(dark.outputs.gnss.sample, 3);
    EXPECT_EQ(dark.outputs.gnss.velocity, plant_.outputs.gnss.velocity);
    EXPECT_EQ(dark.outputs.gnss.longitude, plant_.outputs.gnss.longitude);
}

// Of the truth or of a fix.
template <class Group>
earth::Position place(const Group& group) {
    return {.latitude = group.latitude, .longitude = group.longitude, .height = group.height};
}

TEST_F(TruthPlantTest, TheAntennaIsAtTheEndOfTheLeverArm) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.gnss.lever_arm = {0.0, 0.0, 20.0};
    parameters.motion.sway.amplitude = {0.1, 0.0, 0.0};
    plant_.initialise(0.0);
    run(plant_, 0, 100);
    const auto& truth = plant_.outputs.truth;
    const auto& gnss = plant_.outputs.gnss;
    const Eigen::Vector3d offset = earth::displacement(place(truth), place(gnss));
    EXPECT_LT((offset - 20.0 * Eigen::Vector3d(std::sin(truth.roll), 0.0, std::cos(truth.roll))).norm(),
              1e-6);
    const double omega = 2.0 * std::numbers::pi / 8.0;
    const double roll_rate = 0.1 * omega * std::cos(omega * 1.0 + 0.3);
    const Eigen::Vector3d swing =
        20.0 * roll_rate * Eigen::Vector3d(std::cos(truth.roll), 0.0, -std::sin(truth.roll));
    EXPECT_LT((gnss.velocity - truth.velocity - swing).norm(), 1e-4);  // the transport rate is 2e-6 rad/s
}

// ---------------------------------------------------------------- GNSS channels

int valid_channels(const Outputs& outputs) {
    return static_cast<int>(std::ranges::count(outputs.gnss.channel.valid, true));
}

TEST_F(TruthPlantTest, ChannelsComeWithTheFirstFix) {
    plant_.initialise(0.0);
    run(plant_, 0, 99);
    EXPECT_EQ(valid_channels(plant_.outputs), 0);
    run(plant_, 99, 100);
    EXPECT_GE(valid_channels(plant_.outputs), 4);
    const auto& channel = plant_.outputs.gnss.channel;
    for (std::size_t i = 0; i < channel.valid.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        EXPECT_EQ(channel.valid[i], channel.satellite[i] >= 1 && channel.satellite[i] <= 24);
        EXPECT_EQ(channel.valid[i], channel.pseudorange[row] > 19e6 && channel.pseudorange[row] < 26e6);
        EXPECT_EQ(channel.valid[i], std::abs(channel.satellite_position.row(row).norm() - 26560e3) < 1e-6);
    }
}

// Four satellites and more, without noise, place the antenna and tell the clock bias: least squares by
// Gauss-Newton in Earth-fixed axes, from the centre of the Earth.
TEST_F(TruthPlantTest, PseudorangesPlaceTheAntennaAndTellTheClockBias) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.gnss.latency = 0.2;
    parameters.gnss.lever_arm = {1.0, 2.0, 30.0};
    parameters.gnss.clock.bias = 1000.0;
    parameters.gnss.clock.drift = 10.0;
    plant_.initialise(0.0);
    run(plant_, 0, 520);
    const auto& gnss = plant_.outputs.gnss;
    Eigen::Vector4d solution = Eigen::Vector4d::Zero();  // antenna, clock bias
    for (int iteration = 0; iteration < 20; ++iteration) {
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Eigen::Vector4d right = Eigen::Vector4d::Zero();
        for (std::size_t i = 0; i < gnss.channel.valid.size(); ++i) {
            if (gnss.channel.valid[i]) {
                const auto row = static_cast<Eigen::Index>(i);
                const Eigen::Vector3d sight =
                    gnss.channel.satellite_position.row(row).transpose() - solution.head<3>();
                const Eigen::Vector4d gradient(-sight.x() / sight.norm(), -sight.y() / sight.norm(),
                                               -sight.z() / sight.norm(), 1.0);
                normal += gradient * gradient.transpose();
                right += gradient * (gnss.channel.pseudorange[row] - sight.norm() - solution[3]);
            }
        }
        solution += normal.inverse() * right;
    }
    const double N = earth::radii(gnss.latitude).prime_vertical;
    const double from_axis = (N + gnss.height) * std::cos(gnss.latitude);
    const Eigen::Vector3d antenna(
        from_axis * std::cos(gnss.longitude), from_axis * std::sin(gnss.longitude),
        (N * (1.0 - earth::kEccentricity2) + gnss.height) * std::sin(gnss.latitude));
    EXPECT_EQ(gnss.time, 5.0);
    EXPECT_LT((solution.head<3>() - antenna).norm(), 1e-5);
    EXPECT_NEAR(solution[3], 1000.0 + 10.0 * 5.0, 1e-5);
}

TEST_F(TruthPlantTest, TheTrueClockRunsOnBetweenTheFixes) {
    plant_.parameters.gnss.clock.bias = 7.0;
    plant_.parameters.gnss.clock.drift = 2.0;
    plant_.initialise(3.0);
    const auto& truth = plant_.outputs.truth;
    EXPECT_EQ(truth.clock_bias, 7.0);
    for (int k = 0; k < 250; ++k) {
        plant_.step(3.0 + k / 100.0, 0.01);
        ASSERT_NEAR(truth.clock_bias, 7.0 + 2.0 * (k + 1) / 100.0, 1e-12);
        ASSERT_EQ(truth.clock_drift, 2.0);
    }
}

TEST_F(TruthPlantTest, FewSatellitesAreReceivedWhileALimitLasts) {
    plant_.parameters.gnss.satellite_limit = {.count = 3, .begin = 3.0, .end = 6.0};
    plant_.initialise(0.0);
    for (int second = 1; second <= 8; ++second) {
        run(plant_, 100 * (second - 1), 100 * second);
        const bool few = second >= 3 && second < 6;
        EXPECT_EQ(valid_channels(plant_.outputs) == 3, few) << "t = " << second;
        EXPECT_EQ(plant_.outputs.gnss.sample, second);
    }
}

// ---------------------------------------------------------------- determinism

// Sums of the delta angles and delta velocities of single IMU periods.
std::pair<Eigen::Vector3d, Eigen::Vector3d> summed_increments(TruthPlant& plant, int from, int to) {
    std::pair<Eigen::Vector3d, Eigen::Vector3d> sums(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
    for (int k = from; k < to; ++k) {
        run(plant, k, k + 1);
        sums.first += plant.outputs.imu.delta_angle;
        sums.second += plant.outputs.imu.delta_velocity;
    }
    return sums;
}

class LongerSteps : public TruthPlantTest, public testing::WithParamInterface<std::tuple<MotionKind, int>> {};

TEST_P(LongerSteps, SumTheSameSignals) {
    const auto [kind, periods] = GetParam();
    TruthPlant fine(log_);
    switch_everything_on(fine.parameters);
    fine.parameters.motion.kind = kind;
    plant_.parameters = fine.parameters;
    fine.initialise(0.0);
    plant_.initialise(0.0);
    for (int k = 0; k < 600; k += periods) {
        const auto [angle, velocity] = summed_increments(fine, k, k + periods);
        run(plant_, k, k + periods, periods);
        ASSERT_LT((plant_.outputs.imu.delta_angle - angle).norm(), 1e-15);
        ASSERT_LT((plant_.outputs.imu.delta_velocity - velocity).norm(), 1e-14);
        ASSERT_EQ(plant_.outputs.imu.time, fine.outputs.imu.time);
        Outputs others = fine.outputs;
        others.imu = plant_.outputs.imu;
        ASSERT_EQ(bytes(plant_.outputs), bytes(others));
    }
}

INSTANTIATE_TEST_SUITE_P(Periods, LongerSteps,
                         testing::Combine(testing::Values(MotionKind::ship, MotionKind::flight),
                                          testing::Values(2, 5, 10)));

TEST_F(TruthPlantTest, ARestoredPlantContinuesToTheBit) {
    for (const MotionKind kind : {MotionKind::ship, MotionKind::parked_vehicle, MotionKind::flight}) {
        TruthPlant original(log_);
        switch_everything_on(original.parameters);
        original.parameters.motion.kind = kind;
        original.initialise(0.0);
        run(original, 0, 237);  // two fixes are under way
        std::stringstream stream;
        cereal::BinaryOutputArchive{stream}(original);

        TruthPlant restored(log_);
        cereal::BinaryInputArchive{stream}(restored);
        EXPECT_EQ(bytes(restored.outputs), bytes(original.outputs));
        for (int k = 237; k < 600; ++k) {
            run(original, k, k + 1);
            run(restored, k, k + 1);
            ASSERT_EQ(bytes(restored.outputs), bytes(original.outputs)) << "sample " << k + 1;
        }
    }
}

TEST_F(TruthPlantTest, APlantThatWasNotInitialisedIsRestoredAsSuch) {
    plant_.parameters.imu.rate = 0.0;
    std::stringstream stream;
    cereal::BinaryOutputArchive{stream}(plant_);
    TruthPlant restored(log_);
    restored.initialise(0.0);
    cereal::BinaryInputArchive{stream}(restored);
    EXPECT_EQ(restored.parameters.imu.rate, 0.0);
    EXPECT_THROW(restored.step(0.0, 0.01), std::logic_error);
}

TEST_F(TruthPlantTest, InitialisedAgainItRunsAgain) {
    switch_everything_on(plant_.parameters);
    plant_.initialise(0.0);
    run(plant_, 0, 500);
    const std::string first = bytes(plant_.outputs);
    plant_.initialise(0.0);
    run(plant_, 0, 500);
    EXPECT_EQ(bytes(plant_.outputs), first);
}

TEST_F(TruthPlantTest, AnotherSeedGivesOtherNoiseOnTheSameMotion) {
    TruthPlant other(log_);
    other.parameters.seed = 2;
    plant_.initialise(0.0);
    other.initialise(0.0);
    run(plant_, 0, 100);
    run(other, 0, 100);
    EXPECT_EQ(plant_.outputs.truth.velocity, other.outputs.truth.velocity);
    EXPECT_NE(plant_.outputs.truth.gyro_bias, other.outputs.truth.gyro_bias);
    EXPECT_NE(plant_.outputs.imu.delta_angle, other.outputs.imu.delta_angle);
    EXPECT_NE(plant_.outputs.gnss.velocity, other.outputs.gnss.velocity);
}

TEST_F(TruthPlantTest, SwitchingOffTheGyroNoiseChangesNothingElse) {
    TruthPlant quiet(log_);
    switch_everything_on(plant_.parameters);
    switch_everything_on(quiet.parameters);
    quiet.parameters.imu.gyro.white_noise = 0.0;
    plant_.initialise(0.0);
    quiet.initialise(0.0);
    for (int k = 0; k < 500; ++k) {
        run(plant_, k, k + 1);
        run(quiet, k, k + 1);
        Outputs rest = quiet.outputs;
        rest.imu.delta_angle = plant_.outputs.imu.delta_angle;
        ASSERT_EQ(bytes(rest), bytes(plant_.outputs));
    }
    EXPECT_NE(quiet.outputs.imu.delta_angle, plant_.outputs.imu.delta_angle);
}

TEST_F(TruthPlantTest, ChannelsAndTheirClockChangeNothingElse) {
    TruthPlant plain(log_);
    switch_everything_on(plant_.parameters);
    switch_everything_on(plain.parameters);
    plain.parameters.gnss.pseudorange_sigma = 0.0;
    plain.parameters.gnss.range_rate_outlier.probability = 0.0;
    plain.parameters.gnss.satellite_limit.count = 0;
    plain.parameters.gnss.clock = {};
    plant_.initialise(0.0);
    plain.initialise(0.0);
    for (int k = 0; k < 500; ++k) {
        run(plant_, k, k + 1);
        run(plain, k, k + 1);
        Outputs rest = plain.outputs;
        rest.gnss.channel = plant_.outputs.gnss.channel;
        rest.truth.clock_bias = plant_.outputs.truth.clock_bias;
        rest.truth.clock_drift = plant_.outputs.truth.clock_drift;
        ASSERT_EQ(bytes(rest), bytes(plant_.outputs));
    }
    EXPECT_NE(bytes(plain.outputs), bytes(plant_.outputs));
}

TEST_F(TruthPlantTest, NoiseLevelsCanBeTunedBetweenSteps) {
    TruthPlant tuned(log_);
    make_perfect(plant_.parameters);
    make_perfect(tuned.parameters);
    plant_.initialise(0.0);
    tuned.initialise(0.0);
    run(plant_, 0, 150);
    run(tuned, 0, 150);
    tuned.parameters.gnss.velocity_sigma.setConstant(1.0);
    tuned.parameters.imu.gyro.white_noise = 1e-3;
    tuned.retune();
    run(plant_, 150, 200);
    run(tuned, 150, 200);
    EXPECT_EQ(tuned.outputs.truth.velocity, plant_.outputs.truth.velocity);
    EXPECT_NE(tuned.outputs.gnss.velocity, plant_.outputs.gnss.velocity);
    EXPECT_NE(tuned.outputs.imu.delta_angle, plant_.outputs.imu.delta_angle);
    EXPECT_EQ(tuned.outputs.imu.delta_velocity, plant_.outputs.imu.delta_velocity);

    tuned.parameters.imu.gyro.white_noise = -1.0;
    EXPECT_THROW(tuned.retune(), InvalidParameter);
}

// ---------------------------------------------------------------- what is refused

std::string refusal(const std::function<void()>& action) {
    try {
        action();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST_F(TruthPlantTest, RefusesStepsThatAreNoWholeNumberOfImuPeriods) {
    plant_.initialise(0.0);
    EXPECT_EQ(
        refusal([&] { plant_.step(0.0, 0.015); }),
        "communication step of 0.015 s: must be a whole number of IMU periods of 0.01 s (imu.rate = 100)");
    EXPECT_THROW(plant_.step(0.0, 0.0), std::invalid_argument);
    EXPECT_THROW(plant_.step(0.0, -0.01), std::invalid_argument);
    EXPECT_THROW(plant_.step(0.0, std::nan("")), std::invalid_argument);
    EXPECT_EQ(plant_.outputs.imu.sample, 0);
}

TEST_F(TruthPlantTest, RefusesStepsFromAnotherTime) {
    plant_.initialise(2.0);
    plant_.step(2.0, 0.01);
    EXPECT_EQ(refusal([&] { plant_.step(2.0, 0.01); }),
              "communication step from 2 s: the plant is at 2.01 s");
}

TEST_F(TruthPlantTest, AcceptsTimesThatAMasterSummedUp) {
    plant_.initialise(0.0);
    double time = 0.0;
    for (int k = 0; k < 100000; ++k) {
        plant_.step(time, 0.01);
        time += 0.01;
    }
    EXPECT_EQ(plant_.outputs.imu.time, 1000.0);
}

TEST_F(TruthPlantTest, RefusesToPassAPole) {
    plant_.parameters.motion.latitude = 1.57;
    plant_.parameters.motion.course = std::numbers::pi;
    plant_.initialise(0.0);
    EXPECT_NO_THROW(plant_.step(0.0, 1.0));
    plant_.parameters.motion.course = 0.0;
    plant_.initialise(0.0);
    EXPECT_EQ(refusal([&] { plant_.step(0.0, 1.0); }),
              "the motion has come to a pole, which the local-level frame excludes");
}

struct Refusal {
    std::function<void(Parameters&)> change;
    std::string sentence;
};

class RefusedParameter : public TruthPlantTest, public testing::WithParamInterface<Refusal> {};

TEST_P(RefusedParameter, IsNamedWithItsValueAndTheRule) {
    GetParam().change(plant_.parameters);
    EXPECT_THROW(plant_.initialise(0.0), InvalidParameter);
    EXPECT_EQ(refusal([&] { plant_.initialise(0.0); }), GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, RefusedParameter,
    testing::Values(
        Refusal{[](Parameters& p) { p.imu.rate = 0.0; }, "imu.rate = 0: must be greater than 0"},
        Refusal{[](Parameters& p) { p.motion.latitude = 1.6; },
                "motion.latitude = 1.6: must be at most 1.57"},
        Refusal{[](Parameters& p) { p.gnss.rate = 3.0; },
                "gnss.rate = 3: must be imu.rate (100) divided by a whole number"},
        Refusal{[](Parameters& p) {
                    p.imu.rate = 0.5;
                    p.motion.sway.period.setConstant(100.0);
                },
                "gnss.rate = 1: must be imu.rate (0.5) divided by a whole number"},
        Refusal{[](Parameters& p) { p.gnss.latency = 40.0; },
                "gnss.latency = 40: must be at most 31 periods of gnss.rate (31)"},
        Refusal{[](Parameters& p) { p.gnss.outage.begin[2] = 5.0; },
                "gnss.outage.end[3] = 0: must be at least gnss.outage.begin[3] (5)"},
        Refusal{[](Parameters& p) { p.gnss.noise_scale.step.end = 1.0; },
                "gnss.noise_scale.step.end = 1: must be at least gnss.noise_scale.step.begin (600)"},
        Refusal{[](Parameters& p) { p.gnss.noise_scale.sine.end = 1.0; },
                "gnss.noise_scale.sine.end = 1: must be at least gnss.noise_scale.sine.begin (2400)"},
        Refusal{[](Parameters& p) { p.gnss.outlier_epoch.largest = 5.0; },
                "gnss.outlier_epoch.largest = 5: must be at least gnss.outlier_epoch.least (10)"},
        Refusal{[](Parameters& p) { p.gnss.satellite_limit.begin = 5.0; },
                "gnss.satellite_limit.end = 0: must be at least gnss.satellite_limit.begin (5)"},
        Refusal{[](Parameters& p) { p.gnss.satellite_limit.count = 13; },
                "gnss.satellite_limit.count = 13: must be at most 12"},
        Refusal{[](Parameters& p) {
                    p.motion.kind = MotionKind::flight;
                    p.motion.segment.duration[3] = 2.0;
                    p.motion.segment.acceleration[3] = -5.5;
                },
                "motion.segment.acceleration[4] = -5.5: must be at least what stops the aircraft (-5)"},
        Refusal{[](Parameters& p) {
                    p.motion.kind = MotionKind::flight;
                    p.motion.speed = 100.0;
                    p.motion.segment.duration.head<2>().setConstant(2.0);
                    p.motion.segment.climb_angle[0] = 0.2;
                },
                "motion.segment.climb_angle[2] = 0: must be reached in more than motion.segment.duration[2] "
                "(2): the push-over would be weightless"},
        Refusal{[](Parameters& p) {
                    p.imu.rate = 10.0;
                    p.motion.sway.period[1] = 0.2;
                },
                "motion.sway.period[2] = 0.2: must be greater than two IMU periods (0.2)"},
        Refusal{[](Parameters& p) {
                    p.imu.rate = 10.0;
                    p.motion.wave.velocity[2] = 1.0;
                    p.motion.wave.period[2] = 0.1;
                },
                "motion.wave.period[3] = 0.1: must be greater than two IMU periods (0.2)"},
        Refusal{[](Parameters& p) {
                    p.motion.kind = MotionKind::parked_vehicle;
                    p.motion.vibration.frequency[0] = 50.0;
                },
                "motion.vibration.frequency[1] = 50: must be less than half of imu.rate (50)"}));

TEST_F(TruthPlantTest, AnAircraftMayStopAndStandStill) {
    Parameters& parameters = plant_.parameters;
    parameters.motion.kind = MotionKind::flight;
    parameters.motion.speed = 10.0;
    parameters.motion.segment.duration.head<3>().setConstant(30.0);
    parameters.motion.segment.acceleration.head<2>() = Eigen::Vector2d(3.1, -(10.0 + 93.0) / 30.0);
    plant_.initialise(0.0);
    EXPECT_NO_THROW(run(plant_, 0, 10000, 100));
    EXPECT_LT(plant_.outputs.truth.velocity.norm(), 1e-12);
}

TEST_F(TruthPlantTest, OscillationsThatAreOffMayHaveAnyPeriod) {
    plant_.parameters.imu.rate = 1.0;
    plant_.parameters.motion.sway.amplitude.setZero();
    plant_.parameters.motion.sway.period.setConstant(0.1);
    EXPECT_NO_THROW(plant_.initialise(0.0));
}

}  // namespace
}  // namespace truenorth
