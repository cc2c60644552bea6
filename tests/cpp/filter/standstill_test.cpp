// Against a vehicle whose rates and forces are written down here, with noise of known density.
#include "filter/standstill.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace truenorth {
namespace {

using Eigen::Vector3d;
constexpr double kGravity = 9.8;
constexpr double kDt = 0.01;
constexpr double kRateNoise = 1e-5;   // [rad/s^0.5]
constexpr double kForceNoise = 5e-4;  // [m/s^1.5]

Standstill::Signals as_told(double rate_deviation = 0.0, double force_deviation = 0.0) {
    Standstill::Signals signals;
    signals.noise << Eigen::Array3d::Constant(kRateNoise), Eigen::Array3d::Constant(kForceNoise);
    signals.deviation << Eigen::Array3d::Constant(rate_deviation), Eigen::Array3d::Constant(force_deviation);
    return signals;
}

struct Motion {
    std::function<Vector3d(double)> rate = [](double) { return Vector3d(2e-5, 5e-5, 3e-5); };
    std::function<Vector3d(double)> force = [](double) { return Vector3d(0.1, -0.2, kGravity); };
};

// How many windows of `seconds` look like standing.
int windows(const Motion& motion, double seconds, const Standstill::Signals& signals, unsigned seed = 1) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    const auto noise = [&](double density) -> Vector3d {
        return density * std::sqrt(kDt) * Vector3d(normal(generator), normal(generator), normal(generator));
    };
    Standstill standstill;
    int found = 0;
    for (int k = 1; k <= std::lround(seconds / kDt); ++k) {
        const double middle = (k - 0.5) * kDt;
        standstill.add({.dt = kDt,
                        .delta_angle = kDt * motion.rate(middle) + noise(kRateNoise),
                        .delta_velocity = kDt * motion.force(middle) + noise(kForceNoise)},
                       signals);
        standstill.decide(true);
        found += standstill.ended() && standstill.stands() ? 1 : 0;
    }
    return found;
}

// Roll by `angle` [rad] at `period` [s]: the rate about forward, and gravity to the right.
Motion swaying(double angle, double period) {
    const double w = 2.0 * std::numbers::pi / period;
    Motion motion;
    motion.rate = [=](double t) { return Vector3d(0.0, angle * w * std::cos(w * t), 0.0); };
    motion.force = [=](double t) {
        const double roll = angle * std::sin(w * t);
        return Vector3d(-kGravity * std::sin(roll), 0.0, kGravity * std::cos(roll));
    };
    return motion;
}

TEST(Standstill, IsSeenInTheNoiseThatWasTold) {
    for (const unsigned seed : {1U, 2U, 3U}) {
        EXPECT_GE(windows({}, 1000.0, as_told(), seed), 980) << seed;
    }
}

// Down to twenty times what the noise of a window's mean could hide, at any period of a vehicle.
TEST(Standstill, WhoeverSwaysNeverStands) {
    for (const double period : {3.0, 6.0, 8.0, 10.0, 20.0}) {
        for (const double degrees : {8.0, 1.0, 0.1}) {
            const double angle = degrees * std::numbers::pi / 180.0;
            EXPECT_EQ(windows(swaying(angle, period), 1000.0, as_told()), 0) << period << ' ' << degrees;
        }
    }
}

// An engine that shakes is told of; whoever sways beside it is seen all the same.
TEST(Standstill, AnEngineThatRunsMustBeToldOf) {
    Motion shaken;
    shaken.rate = [](double t) {
        return Vector3d::Constant(0.03 * std::numbers::sqrt2 * std::sin(173.0 * t));
    };
    shaken.force = [](double t) {
        return Vector3d(0.0, 0.0, kGravity + 0.1 * std::numbers::sqrt2 * std::sin(131.0 * t));
    };
    EXPECT_EQ(windows(shaken, 100.0, as_told()), 0);
    EXPECT_GE(windows(shaken, 100.0, as_told(0.03, 0.1)), 95);
    Motion afloat = swaying(0.14, 8.0);
    EXPECT_EQ(windows(afloat, 1000.0, as_told(0.03, 0.1)), 0);
}

// A constant velocity looks like standing: it is for the estimate to exclude it.
TEST(Standstill, IsDecidedByWhatElseIsKnown) {
    Standstill standstill;
    for (int k = 0; k < 300; ++k) {
        standstill.add({.dt = kDt, .delta_angle = Vector3d::Zero(), .delta_velocity = {0.0, 0.0, 0.098}},
                       as_told());
    }
    ASSERT_TRUE(standstill.ended() && standstill.looks_like_it());
    standstill.decide(false);
    EXPECT_FALSE(standstill.stands());
    standstill.decide(true);
    EXPECT_TRUE(standstill.stands());
    standstill.interrupt();
    EXPECT_FALSE(standstill.stands() || standstill.ended());
}

// One window alone says nothing: it may be one extreme of a slow motion.
TEST(Standstill, TakesTwoWindowsAfterAnInterruption) {
    Standstill standstill;
    const auto second = [&] {
        for (int k = 0; k < 100; ++k) {
            standstill.add({.dt = kDt, .delta_angle = Vector3d::Zero(), .delta_velocity = {0.0, 0.0, 0.098}},
                           as_told());
        }
        return standstill.looks_like_it();
    };
    EXPECT_FALSE(second());
    EXPECT_TRUE(second());
    standstill.interrupt();
    EXPECT_FALSE(second());
    EXPECT_TRUE(second());
}

// Nine samples are too few to say how they vary.
TEST(Standstill, IsNotToldFromAFewSamples) {
    Standstill standstill;
    for (int k = 0; k < 100; ++k) {
        standstill.add({.dt = 0.2, .delta_angle = Vector3d::Zero(), .delta_velocity = {0.0, 0.0, 1.96}},
                       as_told());
        EXPECT_FALSE(standstill.looks_like_it());
    }
}

}  // namespace
}  // namespace truenorth
