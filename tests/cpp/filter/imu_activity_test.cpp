#include "filter/imu_activity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace truenorth {
namespace {

using Rates = ImuActivity::Rates;
constexpr int kAxis = 4;

// An IMU that shakes on every axis, with stamps from `start` on; from sample 300 on an axis repeats its
// increment, or its rate.
Eigen::Array<bool, 6, 1> stuck_after(double start, bool increment, int repetitions) {
    ImuActivity activity;
    double before = start;
    for (int k = 1; k <= 300 + repetitions; ++k) {
        const double now = start + 0.01 * k;
        const double dt = now - before;
        before = now;
        Rates rates;
        for (int axis = 0; axis < 6; ++axis) {
            rates(axis) = 0.1 * std::sin(0.7 * k + axis);
        }
        if (k >= 300) {
            rates(kAxis) = increment ? 5e-4 / dt : 0.05;
        }
        activity.add(rates, dt);
    }
    return activity.stuck();
}

TEST(ImuActivity, FindsAnAxisThatStandsStillWhateverTheRoundingOfTheStamps) {
    for (const double start : {0.0, 343.21, 1e5, 1.4e9}) {
        for (const bool increment : {true, false}) {
            EXPECT_FALSE(stuck_after(start, increment, 5).any()) << start;
            const auto stuck = stuck_after(start, increment, 30);
            EXPECT_TRUE(stuck(kAxis)) << start << increment;
            EXPECT_EQ(stuck.count(), 1) << start << increment;
        }
    }
}

TEST(ImuActivity, WhatSwingsIsDoubtedByItsSwingHoweverLongTheGap) {
    // A roll of an amplitude of 0.1 rad: over a gap it changes by 0.2 rad at most, and by 0.1 sqrt(2) rad as
    // a standard deviation of two times at random.
    constexpr double kAmplitude = 0.1;  // [rad]
    constexpr double kPeriod = 8.0;     // [s]
    constexpr double kOmega = 2.0 * std::numbers::pi / kPeriod;
    ImuActivity activity;
    Rates rates = Rates::Zero();
    const auto swing = [&](int k) {
        rates(0) = kAmplitude * kOmega * std::cos(kOmega * 0.01 * k);
        rates(5) = 9.8;
        activity.add(rates, 0.01);
    };
    for (int k = 0; k < 12000; ++k) {
        swing(k);
    }
    for (const double lost : {5.0, 8.6, 10.0}) {
        EXPECT_NEAR(activity.doubt(rates, lost / 0.01, lost)(0), std::numbers::sqrt2 * kAmplitude,
                    0.2 * kAmplitude)
            << lost;
    }
    EXPECT_LT(activity.doubt(rates, 1.0, 0.01)(0), 1e-3 * kAmplitude);
}

TEST(ImuActivity, ATurnIsDoubtedAsFarAsItGoes) {
    // A vehicle that turns this way and that by more than a rad, over longer than is remembered.
    ImuActivity activity;
    Rates rates = Rates::Zero();
    for (int k = 0; k < 6000; ++k) {
        rates(2) = 0.3 * std::sin(2.0 * std::numbers::pi * 0.01 * k / 40.0);
        rates(5) = 9.8;
        activity.add(rates, 0.01);
    }
    EXPECT_GT(activity.doubt(rates, 860.0, 8.6)(2), 1.0);
}

// One second of motion, then a fault of an axis, again and again: that it has stood still for long once does
// not make it usual.
TEST(ImuActivity, FindsAnAxisThatStandsStillASecondTime) {
    for (const int length : {6000, 20000}) {
        ImuActivity activity;
        int k = 0;
        const auto add = [&](bool faulty) {
            ++k;
            Rates rates = Rates::Constant(0.1 * std::sin(0.7 * k));
            rates(kAxis) = faulty ? 0.02 : rates(kAxis);
            activity.add(rates, 0.01);
        };
        for (int fault = 0; fault < 4; ++fault) {
            for (int i = 0; i < 100; ++i) {
                add(false);
            }
            int found = 0;
            for (int i = 1; i <= length; ++i) {
                add(true);
                found = found == 0 && activity.stuck()(kAxis) ? i : found;
            }
            EXPECT_GT(found, 0) << length << ", " << fault;
            EXPECT_LE(found, 12 + 60 * fault * (1 + fault)) << length << ", " << fault;
        }
    }
}

// A vehicle without noise that stands, accelerates and goes on: nothing is stuck.
TEST(ImuActivity, WhatSeldomChangesMayStand) {
    ImuActivity activity;
    for (int k = 1; k <= 6000; ++k) {
        activity.add(Rates::Constant(k > 500 && k <= 1500 ? 1.0 : 0.1), 0.01);
        ASSERT_FALSE(activity.stuck().any()) << k;
    }
}

// A drive with stops, without noise: the first stop is strange, the next are not; one axis alone still is.
TEST(ImuActivity, AVehicleMayStop) {
    ImuActivity activity;
    int k = 0;
    for (int stop = 1; stop <= 5; ++stop) {
        for (int i = 0; i < 3000; ++i) {
            ++k;
            activity.add(Rates::Constant(0.1 * std::sin(0.007 * k)), 0.01);
        }
        for (int i = 0; i < 3000; ++i) {
            activity.add(Rates::Constant(0.01), 0.01);
            ASSERT_TRUE(stop == 1 || !activity.stuck().any()) << stop << ", " << i;
        }
    }
}

TEST(ImuActivity, CountsForHowLong) {
    ImuActivity activity;
    for (int k = 1; k <= 140; ++k) {
        activity.add(Rates::Constant(k <= 100 ? 0.1 * std::sin(0.7 * k) : 0.02), 0.01);
    }
    EXPECT_TRUE((activity.run() == 39.0).all());
}

}  // namespace
}  // namespace truenorth
