#include "components/imu_activity.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(ImuActivity, CountsForHowLong) {
    ImuActivity activity;
    for (int k = 1; k <= 140; ++k) {
        activity.add(Rates::Constant(k <= 100 ? 0.1 * std::sin(0.7 * k) : 0.02), 0.01);
    }
    EXPECT_TRUE((activity.run() == 39.0).all());
}

}  // namespace
}  // namespace truenorth
