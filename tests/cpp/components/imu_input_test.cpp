#include "components/imu_input.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace truenorth {
namespace {

using Eigen::Vector3d;
using Verdict = ImuInput::Verdict;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const Vector3d kAngle(1e-3, 2e-3, 3e-3);
const Vector3d kVelocity(0.0, 0.01, 0.098);

class ImuInputTest : public testing::Test {
  protected:
    ImuInputTest() { imu.start(100.0); }
    Verdict read(int sample, double time) { return imu.read(sample, time, kAngle, kVelocity); }

    ImuInput imu;
};

TEST_F(ImuInputTest, BeforeTheFirstSampleHasTheStartTimeAndNothingElse) {
    EXPECT_EQ(imu.time(), 100.0);
    EXPECT_FALSE(imu.any());
    EXPECT_EQ(read(0, 100.0), Verdict::stale);  // no sample has been put out
}

TEST_F(ImuInputTest, TakesTheIntervalFromTheTimeStamps) {
    EXPECT_EQ(read(1, 100.02), Verdict::accepted);
    EXPECT_NEAR(imu.increment().dt, 0.02, 1e-12);
    EXPECT_EQ(imu.increment().delta_angle, kAngle);
    EXPECT_EQ(imu.increment().delta_velocity, kVelocity);
    EXPECT_EQ(imu.time(), 100.02);
    EXPECT_TRUE(imu.any());
    EXPECT_EQ(read(2, 100.03), Verdict::accepted);
    EXPECT_NEAR(imu.increment().dt, 0.01, 1e-12);
}

TEST_F(ImuInputTest, ASampleSeenBeforeIsStale) {
    read(1, 100.01);
    EXPECT_EQ(read(1, 100.01), Verdict::stale);
    EXPECT_EQ(read(1, 100.02), Verdict::stale);
    EXPECT_EQ(imu.time(), 100.01);
    EXPECT_EQ(imu.rejected(), 0);
}

TEST_F(ImuInputTest, TheFirstCountMayBeAnything) {
    EXPECT_EQ(read(4711, 100.01), Verdict::accepted);
    EXPECT_EQ(imu.missed(), 0);
    EXPECT_EQ(imu.increment().delta_angle, kAngle);
}

TEST_F(ImuInputTest, RejectsWhatIsNotFinite) {
    read(1, 100.01);
    int sample = 1;
    for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
        for (int axis = 0; axis < 3; ++axis) {
            Vector3d spoilt = kAngle;
            spoilt(axis) = bad;
            EXPECT_EQ(imu.read(++sample, 100.02, spoilt, kVelocity), Verdict::rejected);
            EXPECT_EQ(imu.read(++sample, 100.02, kAngle, spoilt), Verdict::rejected);
        }
        EXPECT_EQ(read(++sample, bad), Verdict::rejected);
    }
    EXPECT_EQ(imu.rejected(), 14);
    EXPECT_EQ(imu.time(), 100.01);
}

TEST_F(ImuInputTest, RejectsTimeThatDoesNotAdvance) {
    read(1, 100.01);
    EXPECT_EQ(read(2, 100.01), Verdict::rejected);
    EXPECT_EQ(read(3, 99.0), Verdict::rejected);
    EXPECT_EQ(imu.rejected(), 2);
    EXPECT_EQ(imu.time(), 100.01);
}

TEST_F(ImuInputTest, RejectsRatesAndForcesThatNoVehicleHas) {
    const double dt = 0.01;
    EXPECT_EQ(imu.read(1, 100.0 + dt, Vector3d(51.0 * dt, 0.0, 0.0), kVelocity), Verdict::rejected);
    EXPECT_EQ(imu.read(2, 100.0 + dt, kAngle, Vector3d(0.0, 2001.0 * dt, 0.0)), Verdict::rejected);
    EXPECT_EQ(imu.read(3, 100.0 + dt, Vector3d(49.0 * dt, 0.0, 0.0), Vector3d(0.0, 1999.0 * dt, 0.0)),
              Verdict::accepted);
}

TEST_F(ImuInputTest, BridgesMissedSamplesWithTheMeanRateOfTheNext) {
    read(1, 100.01);
    EXPECT_EQ(read(4, 100.04), Verdict::accepted);
    EXPECT_EQ(imu.gap(), 2);
    EXPECT_EQ(imu.missed(), 2);
    EXPECT_NEAR(imu.increment().dt, 0.03, 1e-12);
    EXPECT_LT((imu.increment().delta_angle - 3.0 * kAngle).norm(), 1e-18);
    EXPECT_LT((imu.increment().delta_velocity - 3.0 * kVelocity).norm(), 1e-16);
    EXPECT_EQ(read(5, 100.05), Verdict::accepted);
    EXPECT_EQ(imu.gap(), 0);
    EXPECT_EQ(imu.missed(), 2);
}

TEST_F(ImuInputTest, BridgesARejectedSampleWithoutCountingItAsMissed) {
    read(1, 100.01);
    imu.read(2, 100.02, kNaN * kAngle, kVelocity);
    EXPECT_EQ(read(3, 100.03), Verdict::accepted);
    EXPECT_NEAR(imu.increment().dt, 0.02, 1e-12);
    EXPECT_LT((imu.increment().delta_angle - 2.0 * kAngle).norm(), 1e-18);
    EXPECT_EQ(imu.gap(), 0);
    EXPECT_EQ(imu.missed(), 0);
    EXPECT_EQ(imu.rejected(), 1);
}

TEST_F(ImuInputTest, TellsRejectedFromMissedInOneGap) {
    read(1, 100.01);
    imu.read(3, 100.03, kNaN * kAngle, kVelocity);
    EXPECT_EQ(read(5, 100.05), Verdict::accepted);  // 2 and 4 never came, 3 was refused
    EXPECT_EQ(imu.missed(), 2);
    EXPECT_LT((imu.increment().delta_angle - 4.0 * kAngle).norm(), 1e-17);
}

TEST_F(ImuInputTest, AfterTheCountHasBeenResetMissesNothing) {
    read(50, 100.01);
    EXPECT_EQ(read(1, 100.02), Verdict::accepted);
    EXPECT_EQ(imu.missed(), 0);
    EXPECT_EQ(imu.increment().delta_angle, kAngle);
}

TEST_F(ImuInputTest, StartForgetsEverything) {
    read(1, 100.01);
    read(9, 100.09);
    imu.start(5.0);
    EXPECT_EQ(imu.time(), 5.0);
    EXPECT_FALSE(imu.any());
    EXPECT_EQ(imu.missed(), 0);
    EXPECT_EQ(read(9, 5.01), Verdict::accepted);
}

TEST_F(ImuInputTest, ASingleTimeFarAheadIsRefusedAndForgotten) {
    read(1, 100.01);
    EXPECT_EQ(read(2, 3600.0), Verdict::rejected);
    EXPECT_EQ(read(3, 100.03), Verdict::accepted);
    EXPECT_NEAR(imu.increment().dt, 0.02, 1e-12);
    EXPECT_EQ(imu.rejected(), 1);
}

TEST_F(ImuInputTest, ALeapThatTheNextSampleConfirmsIsResumedFrom) {
    read(1, 100.01);
    EXPECT_EQ(read(5000, 150.0), Verdict::rejected);
    EXPECT_EQ(read(5001, 150.01), Verdict::resumed);
    EXPECT_NEAR(imu.increment().dt, 0.01, 1e-9);
    EXPECT_EQ(imu.increment().delta_angle, kAngle);  // nothing of the gap is made up
    EXPECT_EQ(imu.time(), 150.01);
    EXPECT_EQ(read(5002, 150.02), Verdict::accepted);
}

}  // namespace
}  // namespace truenorth
