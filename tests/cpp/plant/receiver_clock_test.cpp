#include "plant/receiver_clock.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

namespace truenorth::plant {
namespace {

constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million

TEST(ReceiverClock, WithoutNoiseTheBiasFollowsTheDrift) {
    const ReceiverClock clock({}, 0.5, {1, NoiseSource::gnss_clock});
    ReceiverClock::State state{.bias = 30.0, .drift = -0.25};
    for (std::uint64_t fix = 1; fix <= 20; ++fix) {
        clock.advance(state, fix);
    }
    EXPECT_DOUBLE_EQ(state.bias, 30.0 - 0.25 * 10.0);
    EXPECT_EQ(state.drift, -0.25);
}

// Periods of the fixes [s]: the statistics after 20 s do not depend on it.
class ClockOfPeriod : public testing::TestWithParam<double> {};

TEST_P(ClockOfPeriod, RandomWalksHaveTheVariancesOfTheirDensities) {
    constexpr double time = 20.0;
    constexpr int count = 4000;  // seeds
    const ReceiverClock::Noise noise{.bias = 0.8, .drift = 0.05};
    const double period = GetParam();
    const auto fixes = static_cast<std::uint64_t>(std::lround(time / period));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // of bias^2, drift^2, bias drift
    for (std::uint32_t seed = 1; seed <= count; ++seed) {
        const ReceiverClock clock(noise, period, {seed, NoiseSource::gnss_clock});
        ReceiverClock::State state;
        for (std::uint64_t fix = 1; fix <= fixes; ++fix) {
            clock.advance(state, fix);
        }
        sum += Eigen::Vector3d(state.bias * state.bias, state.drift * state.drift, state.bias * state.drift);
    }
    const double q_bias = noise.bias * noise.bias;
    const double q_drift = noise.drift * noise.drift;
    const double bias = q_bias * time + q_drift * time * time * time / 3.0;
    const double drift = q_drift * time;
    const double both = q_drift * time * time / 2.0;
    EXPECT_NEAR(sum[0] / count, bias, kSigmas * bias * std::sqrt(2.0 / count));
    EXPECT_NEAR(sum[1] / count, drift, kSigmas * drift * std::sqrt(2.0 / count));
    EXPECT_NEAR(sum[2] / count, both, kSigmas * std::sqrt((bias * drift + both * both) / count));
}

INSTANTIATE_TEST_SUITE_P(Periods, ClockOfPeriod, testing::Values(20.0, 2.0, 0.5));

}  // namespace
}  // namespace truenorth::plant
