// The same parameters give the same signals: whatever the step, restored, initialised again, with other
// sources of noise switched off.
#include <gtest/gtest.h>

#include <cereal/archives/binary.hpp>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include "components/truth_plant.hpp"
#include "contract/invalid_parameter.hpp"
#include "truth_plant_fixture.hpp"

namespace truenorth {
namespace {

using truth_plant::MotionKind;
using truth_plant::Outputs;

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

}  // namespace
}  // namespace truenorth
