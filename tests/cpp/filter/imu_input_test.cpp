#include "filter/imu_input.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace truenorth {
namespace {

using Eigen::Vector3d;
using Finding = ImuInput::Finding;
using Verdict = ImuInput::Verdict;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPeriod = 0.01;  // [s]
const Vector3d kAngle(1e-3, 2e-3, 3e-3);
const Vector3d kVelocity(0.0, 0.01, 0.098);

// An IMU of which stamps, count and the master's clock go each their way.
class ImuInputTest : public testing::Test {
  protected:
    ImuInputTest() { imu.start(100.0); }

    // With a clock that agrees with the stamps.
    Verdict read(int sample, double time) { return imu.read(sample, time, kAngle, kVelocity, time); }
    Verdict read(int sample, double time, double clock) {
        return imu.read(sample, time, kAngle, kVelocity, clock);
    }

    // `count` samples with a noise that makes no two alike.
    void run(int count) {
        for (int k = 0; k < count; ++k) {
            ++sample;
            time += kPeriod;
            clock += kPeriod;
            ASSERT_EQ(noisy(), Verdict::accepted) << sample;
        }
    }
    Verdict noisy(const Vector3d& more_angle = Vector3d::Zero(),
                  const Vector3d& more_velocity = Vector3d::Zero()) {
        std::normal_distribution<double> normal(0.0, 1e-5);
        const auto noise = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
        return imu.read(sample, time, kAngle + noise() + more_angle, kVelocity + noise() + more_velocity,
                        clock);
    }

    ImuInput imu;
    int sample = 0;
    double time = 100.0;
    double clock = 100.0;
    std::mt19937 random{1};
};

TEST_F(ImuInputTest, BeforeTheFirstSampleHasTheStartTimeAndNothingElse) {
    EXPECT_EQ(imu.time(), 100.0);
    EXPECT_FALSE(imu.any());
    EXPECT_EQ(read(0, 100.0), Verdict::stale);  // no sample has been put out
}

TEST_F(ImuInputTest, TakesTheIntervalFromTheTimeStamps) {
    EXPECT_EQ(read(1, 100.01), Verdict::accepted);
    EXPECT_NEAR(imu.increment().dt, 0.01, 1e-12);
    EXPECT_EQ(imu.increment().delta_angle, kAngle);
    EXPECT_EQ(imu.increment().delta_velocity, kVelocity);
    EXPECT_EQ(imu.time(), 100.01);
    EXPECT_TRUE(imu.any());
    EXPECT_EQ(read(2, 100.02), Verdict::accepted);
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

TEST_F(ImuInputTest, TheFirstStampMayBeAnything) {
    for (const double stamp : {1.4e9, 5.0, 99.0, 103.0}) {
        imu.start(100.0);
        EXPECT_EQ(read(1, stamp, 100.01), Verdict::resumed) << stamp;
        EXPECT_NEAR(imu.increment().dt, 0.01, 1e-3) << stamp;  // by the force
        EXPECT_EQ(read(2, stamp + 0.01, 100.02), Verdict::accepted) << stamp;
        EXPECT_NEAR(imu.increment().dt, 0.01, 1e-6) << stamp;
        EXPECT_NEAR(imu.stamp(), stamp + 0.01, 1e-6) << stamp;
    }
}

TEST_F(ImuInputTest, RejectsWhatIsNotFinite) {
    read(1, 100.01);
    int number = 1;
    for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
        for (int axis = 0; axis < 3; ++axis) {
            Vector3d spoilt = kAngle;
            spoilt(axis) = bad;
            EXPECT_EQ(imu.read(++number, 100.02, spoilt, kVelocity, 100.02), Verdict::rejected);
            EXPECT_EQ(imu.read(++number, 100.02, kAngle, spoilt, 100.02), Verdict::rejected);
        }
        EXPECT_EQ(read(++number, bad, 100.02), Verdict::rejected);
    }
    EXPECT_EQ(imu.rejected(), 14);
    EXPECT_EQ(imu.time(), 100.01);
    EXPECT_EQ(imu.finding(), Finding::not_finite);
}

TEST_F(ImuInputTest, RejectsASensorThatMeasuresNothing) {
    read(1, 100.01);
    EXPECT_EQ(imu.read(2, 100.02, Vector3d::Zero(), Vector3d::Zero(), 100.02), Verdict::rejected);
    EXPECT_EQ(imu.finding(), Finding::dead);
    EXPECT_EQ(imu.read(3, 100.03, Vector3d::Zero(), kVelocity, 100.03), Verdict::accepted);
}

TEST_F(ImuInputTest, RejectsASampleThatIsOld) {
    read(1, 100.01);
    read(2, 100.02);
    EXPECT_EQ(read(3, 100.02, 100.03), Verdict::rejected);  // the time stands still
    EXPECT_EQ(read(1, 100.01, 100.03), Verdict::rejected);
    EXPECT_EQ(imu.finding(), Finding::old);
    EXPECT_EQ(imu.rejected(), 2);
    EXPECT_EQ(imu.time(), 100.02);
}

TEST_F(ImuInputTest, RejectsRatesAndForcesThatNoVehicleHas) {
    run(60);
    sample += 1;
    time += kPeriod;
    EXPECT_EQ(noisy(Vector3d(51.0 * kPeriod, 0.0, 0.0)), Verdict::rejected);
    sample += 1;
    EXPECT_EQ(noisy(Vector3d::Zero(), Vector3d(0.0, 2001.0 * kPeriod, 0.0)), Verdict::rejected);
    EXPECT_EQ(imu.finding(), Finding::impossible);
    EXPECT_EQ(imu.rejected(), 2);
}

TEST_F(ImuInputTest, RejectsRatesInPlaceOfIncrementsAndComesBack) {
    // From the start, and in the middle.
    for (const int sound_ones : {0, 200}) {
        imu.start(100.0);
        sample = 0;
        time = clock = 100.0;
        run(sound_ones);
        int rejected = 0;
        for (int k = 0; k < 1000; ++k) {
            ++sample;
            time += kPeriod;
            clock += kPeriod;
            const auto verdict = imu.read(sample, time, kAngle / kPeriod * 0.1,
                                          kVelocity / kPeriod * (1.0 + 1e-6 * (k % 7)), clock);
            rejected += verdict == Verdict::rejected ? 1 : 0;
        }
        EXPECT_GT(rejected, sound_ones == 0 ? 999 : 800);
        EXPECT_EQ(imu.finding(), Finding::no_increment);
        int accepted = 0;
        for (int k = 0; k < 4000; ++k) {
            ++sample;
            time += kPeriod;
            clock += kPeriod;
            accepted += noisy() == Verdict::rejected ? 0 : 1;
        }
        EXPECT_GT(accepted, 100);
        EXPECT_LT(imu.silent_for(), 1e-9);
    }
}

TEST_F(ImuInputTest, BridgesMissedSamplesWithTheRateOfTheNextWhileItKnowsLittle) {
    read(1, 100.01);
    EXPECT_EQ(read(4, 100.04), Verdict::accepted);
    EXPECT_EQ(imu.gap(), 2);
    EXPECT_EQ(imu.missed(), 2);
    EXPECT_NEAR(imu.increment().dt, 0.03, 1e-12);
    EXPECT_LT((imu.increment().delta_angle - 3.0 * kAngle).norm(), 1e-12);
    EXPECT_LT((imu.increment().delta_velocity - 3.0 * kVelocity).norm(), 1e-12);
    EXPECT_EQ(read(5, 100.05), Verdict::accepted);
    EXPECT_EQ(imu.gap(), 0);
    EXPECT_EQ(imu.missed(), 2);
}

TEST_F(ImuInputTest, BridgesARejectedSampleWithoutCountingItAsMissed) {
    read(1, 100.01);
    imu.read(2, 100.02, kNaN * kAngle, kVelocity, 100.02);
    EXPECT_EQ(read(3, 100.03), Verdict::accepted);
    EXPECT_NEAR(imu.increment().dt, 0.02, 1e-12);
    EXPECT_LT((imu.increment().delta_angle - 2.0 * kAngle).norm(), 1e-12);
    EXPECT_EQ(imu.gap(), 0);
    EXPECT_EQ(imu.missed(), 0);
    EXPECT_EQ(imu.rejected(), 1);
}

TEST_F(ImuInputTest, TellsRejectedFromMissedInOneGap) {
    read(1, 100.01);
    imu.read(3, 100.03, kNaN * kAngle, kVelocity, 100.03);
    EXPECT_EQ(read(5, 100.05), Verdict::accepted);  // 2 and 4 never came, 3 was refused
    EXPECT_EQ(imu.missed(), 2);
    EXPECT_LT((imu.increment().delta_angle - 4.0 * kAngle).norm(), 1e-12);
}

TEST_F(ImuInputTest, DoubtsWhatItMadeUpTheMoreTheLongerTheGap) {
    run(500);
    double before = 0.0;
    for (const int lost : {1, 10, 100, 500}) {
        sample += lost + 1;
        time += (lost + 1) * kPeriod;
        clock = time;
        ASSERT_EQ(noisy(), Verdict::accepted);
        EXPECT_GT(imu.doubtful_angle().norm(), before);
        EXPECT_LT(imu.doubtful_angle().norm(), 10.0 * 1e-5 / kPeriod * (lost + 1) * kPeriod);
        EXPECT_LT((imu.increment().delta_angle - (lost + 1) * kAngle).norm(), 1e-4 * (lost + 1));
        before = imu.doubtful_angle().norm();
        run(1);
        EXPECT_TRUE(imu.doubtful_angle().isZero(0.0));
    }
}

TEST_F(ImuInputTest, WhatItMadeUpIsTheSameWhetherSamplesWereRefusedOrNeverCame) {
    for (const bool refused : {false, true}) {
        imu.start(100.0);
        sample = 0;
        time = clock = 100.0;
        run(500);
        for (int k = 0; k < 300; ++k) {
            ++sample;
            time += kPeriod;
            clock += kPeriod;
            if (refused) {
                EXPECT_EQ(imu.read(sample, time, kNaN * kAngle, kVelocity, clock), Verdict::rejected);
            }
        }
        run(1);
        EXPECT_NEAR(imu.bridged(), 3.0, 1e-9) << refused;
        EXPECT_EQ(imu.gap(), refused ? 0 : 300);
        run(1);
        EXPECT_EQ(imu.bridged(), 0.0);
    }
}

TEST_F(ImuInputTest, GapsOfASampleAreFilledFromBothSides) {
    // Of the roll of a ship, every other sample from rest to the fastest: its integral comes out right, where
    // the next sample in the place of the lost one would make it half an increment too large.
    constexpr double kAmplitude = 1e-3;  // of the increments [rad]
    constexpr int kQuarter = 200;        // of its period [samples]
    const auto roll = [](int k) -> Vector3d {
        return {kAmplitude * std::sin(0.5 * std::numbers::pi * k / kQuarter), 2e-3, 3e-3};
    };
    double sum = 0.0;
    double true_sum = 0.0;
    for (int k = 1; k <= 13 * kQuarter; ++k) {
        ++sample;
        time += kPeriod;
        clock += kPeriod;
        const bool half = k > 12 * kQuarter;
        if (!half || k % 2 == 0) {
            ASSERT_EQ(imu.read(sample, time, roll(k), kVelocity, clock), Verdict::accepted);
        }
        if (half) {
            true_sum += roll(k).x();
            sum += k % 2 == 0 ? imu.increment().delta_angle.x() : 0.0;
        }
    }
    EXPECT_EQ(imu.missed(), kQuarter / 2);
    EXPECT_NEAR(sum, true_sum, 0.01 * kAmplitude);
}

TEST_F(ImuInputTest, AfterTheCountHasBeenResetMissesNothing) {
    read(50, 100.01);
    EXPECT_EQ(read(1, 100.02), Verdict::accepted);
    EXPECT_EQ(imu.missed(), 0);
    EXPECT_EQ(imu.increment().delta_angle, kAngle);
}

TEST_F(ImuInputTest, ACountThatLeapsAloneLosesNothing) {
    for (const int leap : {2, 10, 100, 1000, 1 << 30}) {
        imu.start(100.0);
        read(1, 100.01);
        read(2, 100.02);
        EXPECT_EQ(read(2 + leap, 100.03), Verdict::accepted) << leap;
        EXPECT_EQ(imu.increment().delta_angle, kAngle) << leap;
        EXPECT_EQ(imu.finding(), Finding::count_leapt) << leap;
        EXPECT_EQ(imu.missed(), 0) << leap;
        EXPECT_EQ(imu.disagreements(), 1) << leap;
        EXPECT_EQ(read(3 + leap, 100.04), Verdict::accepted) << leap;
        EXPECT_EQ(imu.increment().delta_angle, kAngle) << leap;
        EXPECT_EQ(imu.finding(), Finding::none) << leap;
    }
}

TEST_F(ImuInputTest, ACountOfWhatALoggerSummedUpIsLearned) {
    // Ten raw samples an increment, all of which it covers.
    for (int k = 1; k <= 100; ++k) {
        clock = 100.0 + 0.1 * k;
        ASSERT_EQ(imu.read(10 * k, clock, 10.0 * kAngle, 10.0 * kVelocity, clock), Verdict::accepted);
        EXPECT_EQ(imu.increment().delta_angle, 10.0 * kAngle);
        EXPECT_EQ(imu.missed(), 0);
        EXPECT_EQ(imu.finding(), k >= 2 && k <= 4 ? Finding::count_leapt : Finding::none) << k;
    }
}

// 250 or 150 raw samples a second, in increments of a hundredth of a second.
TEST_F(ImuInputTest, ACountThatAdvancesUnevenlyIsLearned) {
    for (const double raw : {2.5, 1.5}) {
        imu.start(100.0);
        for (int k = 1; k <= 100; ++k) {
            sample = static_cast<int>(raw * k);
            time = clock = 100.0 + kPeriod * k;
            ASSERT_EQ(noisy(), Verdict::accepted);
            EXPECT_NEAR(imu.increment().dt, kPeriod, 1e-9);
            if (k > 6) {
                EXPECT_EQ(imu.finding(), Finding::none) << raw << ", " << k;
            }
        }
        EXPECT_EQ(imu.missed(), 0) << raw;
        sample = static_cast<int>(raw * 103.0);  // two are lost
        time = clock = 101.03;
        EXPECT_EQ(noisy(), Verdict::accepted);
        EXPECT_EQ(imu.gap(), 2) << raw;
        sample = static_cast<int>(raw * 104.0) + 10;  // the count leaps alone
        time = clock = 101.04;
        EXPECT_EQ(noisy(), Verdict::accepted);
        EXPECT_EQ(imu.finding(), Finding::count_leapt) << raw;
    }
}

TEST_F(ImuInputTest, ALostSampleIsMissedHoweverStrongTheForceIs) {
    for (const double force : {1.0, 2.0, 4.0}) {  // of gravity, after a minute of level flight
        imu.start(100.0);
        sample = 0;
        time = clock = 100.0;
        run(6000);
        const Vector3d pulled = (force - 1.0) * kVelocity;
        for (int k = 0; k < 50; ++k) {
            ++sample;
            time = clock = clock + kPeriod;
            noisy(Vector3d::Zero(), pulled);
        }
        sample += 2;
        time = clock = clock + 2.0 * kPeriod;
        noisy(Vector3d::Zero(), pulled);
        EXPECT_EQ(imu.missed(), 1) << force;
        EXPECT_NEAR(imu.increment().delta_velocity.norm(), 2.0 * force * kVelocity.norm(), 0.02) << force;
    }
}

// A stamp that is late makes a long interval and a short one; the samples after it are as before.
TEST_F(ImuInputTest, AStampThatIsLateLosesNothing) {
    for (const double late : {0.0035, 0.0045}) {
        imu.start(100.0);
        sample = 0;
        time = clock = 100.0;
        std::normal_distribution<double> vibration(0.0, 4e-3);  // of the increment [m/s]
        for (int k = 1; k <= 12000; ++k) {
            sample = k;
            clock = 100.0 + kPeriod * k;
            time = clock + (k == 6000 ? late : 0.0);
            ASSERT_EQ(noisy(Vector3d::Zero(), Vector3d::Constant(vibration(random))), Verdict::accepted);
        }
        EXPECT_EQ(imu.missed(), 0) << late;
    }
}

TEST_F(ImuInputTest, OfAFirstSampleThatWasWaitedForNothingIsKnown) {
    for (const double waited : {0.01, 5.0, 30.0}) {
        imu.start(100.0);
        EXPECT_EQ(read(1, 100.0 + 1.4e9, 100.0 + waited), Verdict::resumed);
        EXPECT_EQ(imu.blind_for(), waited > ImuInput::kLongestInterval ? waited : 0.0);
    }
}

TEST_F(ImuInputTest, TellsForHowLongNothingWasSeen) {
    run(100);
    EXPECT_EQ(imu.blind_for(), 0.0);
    sample += 1000;
    time += 10.5;
    clock += 10.5;
    EXPECT_EQ(noisy(), Verdict::resumed);
    EXPECT_NEAR(imu.blind_for(), 10.5 - kPeriod, 1e-9);
    run(1);
    EXPECT_EQ(imu.blind_for(), 0.0);
}

TEST_F(ImuInputTest, ACountThatWrapsGoesOn) {
    constexpr int kMost = std::numeric_limits<int>::max();
    constexpr int kLeast = std::numeric_limits<int>::min();
    read(kMost - 1, 100.01);
    read(kMost, 100.02);
    EXPECT_EQ(read(kLeast, 100.03), Verdict::accepted);
    EXPECT_EQ(imu.finding(), Finding::none);
    EXPECT_EQ(read(kLeast + 2, 100.05), Verdict::accepted);
    EXPECT_EQ(imu.missed(), 1);
}

TEST_F(ImuInputTest, AClockThatIsSetLeavesTheIntervalAndIsTold) {
    for (const double step : {1.0, -0.5, -20.0, 3600.0, 1.4e9, -99.0}) {
        imu.start(100.0);
        sample = 0;
        time = clock = 100.0;
        run(100);
        const double before = imu.time();
        time += step;
        ++sample;
        time += kPeriod;
        clock += kPeriod;
        ASSERT_EQ(noisy(), Verdict::accepted) << step;
        EXPECT_EQ(imu.finding(), Finding::clock_set) << step;
        EXPECT_NEAR(imu.increment().dt, kPeriod, 1e-9) << step;
        EXPECT_NEAR(imu.time() - before, kPeriod, 1e-6) << step;
        EXPECT_NEAR(imu.stamp(), time, 1e-6) << step;
        EXPECT_EQ(imu.disagreements(), 1) << step;
        EXPECT_EQ(imu.missed(), 0) << step;
        run(100);
        EXPECT_NEAR(imu.time() - before, 101 * kPeriod, 1e-5) << step;
        EXPECT_EQ(imu.disagreements(), 1) << step;
    }
}

TEST_F(ImuInputTest, OneWrongStampIsSetAndSetBack) {
    run(100);
    const double before = imu.time();
    time += 3600.0;
    ++sample;
    clock += kPeriod;
    noisy();
    time -= 3600.0 - kPeriod;
    ++sample;
    time += kPeriod;
    clock += kPeriod;
    noisy();
    EXPECT_NEAR(imu.time() - before, 2 * kPeriod, 1e-9);
    EXPECT_EQ(imu.disagreements(), 2);
}

TEST_F(ImuInputTest, ASensorThatIsSwitchedOffAndOnIsResumedOrBridged) {
    // Count and clock begin again, after 3 s by the master's clock.
    run(200);
    const double before = imu.time();
    clock += 3.0;
    int refused = 0;
    for (sample = 1, time = 0.01; refused < 10; ++sample, time += kPeriod, clock += kPeriod) {
        if (noisy() != Verdict::rejected) {
            break;
        }
        ++refused;
    }
    EXPECT_EQ(refused, 2);  // the third confirms it
    EXPECT_NEAR(imu.time() - before, 3.03 - kPeriod, 2 * kPeriod);
    EXPECT_GT(imu.doubtful_angle().norm(), 0.0);
    EXPECT_NEAR(imu.stamp(), time, 1e-9);
}

TEST_F(ImuInputTest, AMasterThatTakesLongerStepsIsFollowed) {
    run(200);
    for (int k = 0; k < 20; ++k) {
        ++sample;
        time += 0.1;
        clock += 0.1;
        ASSERT_EQ(imu.read(sample, time, 10.0 * kAngle * (1.0 + 1e-6 * k), 10.0 * kVelocity, clock),
                  Verdict::accepted);
        EXPECT_NEAR(imu.increment().dt, 0.1, 1e-9);
        EXPECT_NEAR((imu.increment().delta_angle - 10.0 * kAngle).norm(), 0.0, 1e-5);
        EXPECT_EQ(imu.missed(), 0);
    }
    EXPECT_EQ(imu.disagreements(), 0);
}

TEST_F(ImuInputTest, IsSilentByTheMastersClock) {
    run(100);
    EXPECT_LT(imu.silent_for(), 1e-9);
    for (int k = 0; k < 300; ++k) {
        clock += kPeriod;
        EXPECT_EQ(noisy(), Verdict::stale);
    }
    EXPECT_NEAR(imu.silent_for(), 3.0, 1e-9);
    EXPECT_GT(imu.silent_for(), imu.patience());
    sample += 301;
    time += 3.01;
    clock += kPeriod;
    EXPECT_EQ(noisy(), Verdict::accepted);
    EXPECT_EQ(imu.missed(), 300);
    EXPECT_EQ(imu.silent_for(), 0.0);
}

TEST_F(ImuInputTest, ALongGapIsResumedFrom) {
    run(100);
    sample += 5000;
    time += 50.0;
    clock += 50.0;
    EXPECT_EQ(noisy(), Verdict::resumed);
    EXPECT_NEAR(imu.increment().dt, kPeriod, 1e-9);  // nothing of the gap is made up
    EXPECT_NEAR(imu.time(), time, 1e-9);
    run(10);
}

TEST_F(ImuInputTest, HoldsAnAxisThatLeapsAndDoubtsIt) {
    for (int axis = 0; axis < 6; ++axis) {
        run(200);
        ++sample;
        time += kPeriod;
        clock += kPeriod;
        Vector3d angle = Vector3d::Zero();
        Vector3d velocity = Vector3d::Zero();
        (axis < 3 ? angle : velocity)(axis % 3) = axis < 3 ? 0.3 : 1.0;
        EXPECT_EQ(noisy(angle, velocity), Verdict::accepted);
        EXPECT_EQ(imu.finding(), Finding::jump);
        EXPECT_LT((imu.increment().delta_angle - kAngle).norm(), 1e-3);
        EXPECT_LT((imu.increment().delta_velocity - kVelocity).norm(), 1e-3);
        EXPECT_NEAR(imu.doubtful_angle().norm(), axis < 3 ? 0.3 : 0.0, 1e-3);
        EXPECT_NEAR(imu.doubtful_velocity().norm(), axis < 3 ? 0.0 : 1.0, 1e-3);
        EXPECT_EQ(imu.suspected(), clock);
        run(1);
        EXPECT_EQ(imu.finding(), Finding::none);
        EXPECT_TRUE(imu.doubtful_angle().isZero(0.0));
    }
}

TEST_F(ImuInputTest, BelievesALeapThatStays) {
    run(200);
    for (int k = 0; k < 10; ++k) {
        ++sample;
        time += kPeriod;
        clock += kPeriod;
        noisy(Vector3d(0.01, 0.0, 0.0));
        EXPECT_EQ(imu.finding(), k < 3 ? Finding::jump : Finding::none) << k;
    }
    EXPECT_NEAR(imu.increment().delta_angle.x(), kAngle.x() + 0.01, 1e-4);
}

TEST_F(ImuInputTest, NoiseAloneNeverLeaps) {
    run(100000);
    EXPECT_EQ(imu.disagreements(), 0);
    EXPECT_LT(imu.suspected(), 0.0);
}

TEST_F(ImuInputTest, DoubtsAnAxisThatStandsStill) {
    // A turn to and fro of 0.1 rad/s about the up axis, which gets stuck for 2 s.
    double doubt = 0.0;
    const auto turn = [&](bool stuck) {
        ++sample;
        time += kPeriod;
        clock += kPeriod;
        const double rate = 0.1 * std::sin(time);
        Vector3d angle(1e-6 * std::sin(7.0 * time), 1e-6 * std::sin(9.0 * time),
                       stuck ? 5e-4 : rate * kPeriod);
        ASSERT_EQ(imu.read(sample, time, angle, kVelocity * (1.0 + 1e-6 * std::sin(time)), clock),
                  Verdict::accepted);
        doubt = std::hypot(doubt, imu.doubtful_angle().z());
    };
    for (int k = 0; k < 3000; ++k) {
        turn(false);
    }
    EXPECT_EQ(doubt, 0.0);
    EXPECT_EQ(imu.finding(), Finding::none);
    for (int k = 0; k < 200; ++k) {
        turn(true);
    }
    EXPECT_EQ(imu.finding(), Finding::stuck);
    EXPECT_GT(doubt, 0.05);
    EXPECT_LT(doubt, 0.2);
    for (int k = 0; k < 10; ++k) {
        turn(false);
    }
    EXPECT_EQ(imu.finding(), Finding::none);
}

TEST_F(ImuInputTest, ASensorWithoutNoiseMayRepeatItself) {
    for (int k = 1; k <= 5000; ++k) {
        ASSERT_EQ(read(k, 100.0 + kPeriod * k), Verdict::accepted);
        ASSERT_EQ(imu.finding(), Finding::none);
    }
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

}  // namespace
}  // namespace truenorth
