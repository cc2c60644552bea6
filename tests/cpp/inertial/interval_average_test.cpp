#include "inertial/interval_average.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace truenorth {
namespace {

TEST(IntervalAverage, OfATurnIsTheMeanOfTheAttitudeNotAnAttitude) {
    // 90 degrees of heading within one second: the mean of cos over the quarter is 2 / pi.
    Mechanisation mechanisation({.position = {.latitude = 0.5, .longitude = 0.0, .height = 0.0}});
    IntervalAverage average;
    const double rate = 0.5 * std::numbers::pi;
    for (int k = 0; k < 100; ++k) {
        const NavigationState before = mechanisation.state;
        mechanisation.advance(
            {.dt = 0.01, .delta_angle = {0.0, 0.0, rate * 0.01}, .delta_velocity = Eigen::Vector3d::Zero()});
        average.add(before, mechanisation, 0.01);
    }
    EXPECT_NEAR(average.duration(), 1.0, 1e-12);
    // The trapezium rule over steps of 0.9 degrees: (0.0157)^2 / 12.
    const double mean = 2.0 / std::numbers::pi;
    const double tolerance = 1e-4 + 1e-4;  // and the Earth turned by 7e-5 rad
    EXPECT_NEAR(average.C_bn()(0, 0), mean, tolerance);
    EXPECT_NEAR(average.C_bn()(1, 0), mean, tolerance);
    EXPECT_NEAR(average.C_bn()(2, 2), 1.0, tolerance);
}

TEST(IntervalAverage, WeighsIncrementsByTheirDuration) {
    Mechanisation mechanisation({.position = {.latitude = 0.5, .longitude = 0.0, .height = 0.0}});
    IntervalAverage average;
    const auto add = [&](double dt, double force) {
        const NavigationState before = mechanisation.state;
        mechanisation.advance(
            {.dt = dt, .delta_angle = Eigen::Vector3d::Zero(), .delta_velocity = {force * dt, 0.0, 0.0}});
        average.add(before, mechanisation, dt);
    };
    add(0.01, 1.0);
    add(0.03, 5.0);
    EXPECT_NEAR(average.duration(), 0.04, 1e-15);
    EXPECT_NEAR(average.force().x(), 4.0, 1e-5);
    // East velocity 0 -> 0.01 -> 0.16: mean (0.005 * 0.01 + 0.085 * 0.03) / 0.04.
    EXPECT_NEAR(average.velocity().x(), 0.065, 1e-6);
}

}  // namespace
}  // namespace truenorth
