#include "plant/channel_receiver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "inertial/ecef.hpp"
#include "plant/constellation.hpp"
#include "plant/motions.hpp"
#include "plant/trajectory.hpp"

namespace truenorth::plant {
namespace {

constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million
constexpr double kMask = 10.0 * kDegree;
constexpr earth::Position kPlace{.latitude = 0.6, .longitude = 2.0, .height = 500.0};

ChannelReceiver::Reception reception() { return {.mask_angle = kMask, .limited = {}}; }

Fix still(double time) { return {.time = time, .position = kPlace}; }

double elevation(const Channel& channel) {
    const Eigen::Vector3d sight = channel.satellite_position - ecef::coordinates(kPlace);
    return std::asin(ecef::axes(kPlace).col(2).dot(sight.normalized()));
}

// By number of the satellite.
std::map<std::int32_t, Channel> by_satellite(const std::array<Channel, kChannels>& channels) {
    std::map<std::int32_t, Channel> found;
    for (const Channel& channel : channels) {
        if (channel.satellite != 0) {
            found[channel.satellite] = channel;
        }
    }
    return found;
}

TEST(ChannelReceiver, ThePseudorangeIsTheDistanceAndTheClockBias) {
    const ChannelReceiver receiver(reception(), {}, 1);
    ChannelAllocation allocation;
    const auto channels =
        by_satellite(receiver.measure(1, still(77.0), {.bias = 250.0, .drift = -3.0}, allocation));
    EXPECT_GE(channels.size(), 4U);
    const auto satellites = constellation(77.0);
    for (const auto& [number, channel] : channels) {
        const Satellite& satellite = satellites[static_cast<std::size_t>(number) - 1];
        EXPECT_EQ(channel.satellite_position, satellite.position);
        EXPECT_EQ(channel.satellite_velocity, satellite.velocity);
        EXPECT_NEAR(channel.pseudorange, (satellite.position - ecef::coordinates(kPlace)).norm() + 250.0,
                    1e-7);
    }
}

// On a flight, with a clock that drifts.
TEST(ChannelReceiver, TheRangeRateIsTheDerivativeOfThePseudorange) {
    constexpr double step = 0.05;
    constexpr double drift = 12.0;
    const ChannelReceiver receiver(reception(), {}, 1);
    const Trajectory trajectory(eventful_flight(), kPlace);
    Trajectory::State state = trajectory.begin(0.0);
    ChannelAllocation allocation;
    const auto measure = [&](double time) {
        for (int k = 1; k <= 5; ++k) {
            trajectory.advance(state, time - step + k * step / 5.0);
        }
        const Fix antenna{
            .time = time,
            .position = state.position(),
            .velocity = state.kinematics.velocity,
        };
        return by_satellite(receiver.measure(1, antenna, {.bias = drift * time, .drift = drift}, allocation));
    };
    trajectory.advance(state, 80.0 - 3.0 * step);
    std::array<std::map<std::int32_t, Channel>, 5> around;
    for (std::size_t i = 0; i < around.size(); ++i) {
        around[i] = measure(80.0 + step * (static_cast<double>(i) - 2.0));
    }
    for (const auto& [number, now] : around[2]) {
        const auto range = [&](std::size_t i) { return around[i].at(number).pseudorange; };
        const double rate = (8.0 * (range(3) - range(1)) - (range(4) - range(0))) / (12.0 * step);
        EXPECT_NEAR(now.range_rate, rate, 1e-5) << "satellite " << number;  // rounding, curvature of the path
    }
}

TEST(ChannelReceiver, ReceivesWhatIsAboveTheMaskAndNothingElse) {
    const ChannelReceiver receiver(reception(), {}, 1);
    ChannelAllocation allocation;
    for (int k = 0; k < 300; ++k) {
        const Fix truth = still(k * 288.0);
        const auto channels = by_satellite(receiver.measure(1, truth, {}, allocation));
        std::size_t in_view = 0;
        for (const Satellite& satellite : constellation(truth.time)) {
            in_view += elevation({.satellite_position = satellite.position}) > kMask ? 1 : 0;
        }
        ASSERT_EQ(channels.size(), in_view) << "t = " << truth.time;
        for (const auto& [number, channel] : channels) {
            ASSERT_GT(elevation(channel), kMask) << "t = " << truth.time;
        }
    }
}

TEST(ChannelReceiver, ASatelliteKeepsItsChannelWhileItIsInView) {
    const ChannelReceiver receiver(reception(), {}, 1);
    ChannelAllocation allocation;
    auto before = receiver.measure(1, still(0.0), {}, allocation);
    for (std::size_t i = 1; i < kChannels && before[i].satellite != 0; ++i) {
        EXPECT_GT(elevation(before[i - 1]), elevation(before[i]));
    }
    int changes = 0;
    for (int k = 1; k < 1440; ++k) {
        const Fix truth = still(k * 60.0);
        const auto now = receiver.measure(1, truth, {}, allocation);
        const auto satellites = constellation(truth.time);
        for (std::size_t i = 0; i < kChannels; ++i) {
            const std::int32_t number = before[i].satellite;
            if (number != 0 && now[i].satellite != number) {
                const Satellite& lost = satellites[static_cast<std::size_t>(number) - 1];
                ASSERT_LE(elevation({.satellite_position = lost.position}), kMask);
                ++changes;
            }
        }
        before = now;
    }
    EXPECT_GT(changes, 24);  // in a day every satellite sets at least once
}

TEST(ChannelReceiver, AnotherEpochIsTheConstellationOfAnotherTime) {
    ChannelReceiver::Reception later = reception();
    later.constellation_epoch = 5000.0;
    ChannelAllocation one;
    ChannelAllocation other;
    const auto shifted = ChannelReceiver(later, {}, 1).measure(1, still(10.0), {}, one);
    const auto waited = ChannelReceiver(reception(), {}, 1).measure(1, still(5010.0), {}, other);
    for (std::size_t i = 0; i < kChannels; ++i) {
        EXPECT_EQ(shifted[i].satellite, waited[i].satellite);
        EXPECT_EQ(shifted[i].pseudorange, waited[i].pseudorange);
    }
}

// ---------------------------------------------------------------- errors

// What the errors add to the measurements of every satellite in view, per fix.
template <class Use>
void for_each_error(const ChannelReceiver::Errors& errors, std::uint32_t seed, std::uint64_t fixes,
                    const Use& use) {
    const ChannelReceiver receiver(reception(), errors, seed);
    const ChannelReceiver perfect(reception(), {}, seed);
    ChannelAllocation allocation;
    ChannelAllocation same;
    for (std::uint64_t fix = 1; fix <= fixes; ++fix) {
        const auto measured = receiver.measure(fix, still(0.0), {}, allocation);
        const auto truth = perfect.measure(fix, still(0.0), {}, same);
        for (std::size_t i = 0; i < kChannels && truth[i].satellite != 0; ++i) {
            use(i, Eigen::Array2d(measured[i].pseudorange - truth[i].pseudorange,
                                  measured[i].range_rate - truth[i].range_rate));
        }
    }
}

class ChannelsOfSeed : public testing::TestWithParam<std::uint32_t> {};

TEST_P(ChannelsOfSeed, NoiseHasItsSigmasAndIsIndependentFromChannelToChannel) {
    constexpr int count = 10000;
    ChannelReceiver::Errors errors;
    errors.pseudorange_sigma = 5.0;
    errors.range_rate_sigma = 0.1;
    const Eigen::Array2d sigma(5.0, 0.1);
    std::array<Eigen::Array2d, kChannels> sum{};
    std::array<Eigen::Array2d, kChannels> squares{};
    std::array<double, kChannels> product{};            // of pseudorange and range rate
    std::array<Eigen::Array2d, kChannels> neighbour{};  // product with the channel before
    sum.fill(Eigen::Array2d::Zero());
    squares.fill(Eigen::Array2d::Zero());
    neighbour.fill(Eigen::Array2d::Zero());
    Eigen::Array2d before = Eigen::Array2d::Zero();
    std::size_t used = 0;
    for_each_error(errors, GetParam(), count, [&](std::size_t i, const Eigen::Array2d& error) {
        const Eigen::Array2d normal = error / sigma;
        sum[i] += normal;
        squares[i] += normal.square();
        product[i] += normal.prod();
        neighbour[i] += i > 0 ? (normal * before).eval() : Eigen::Array2d::Zero().eval();
        before = normal;
        used = std::max(used, i + 1);
    });
    ASSERT_GE(used, 4U);
    for (std::size_t i = 0; i < used; ++i) {
        EXPECT_LT((sum[i] / count).abs().maxCoeff(), kSigmas / std::sqrt(count));
        EXPECT_LT((squares[i] / count - 1.0).abs().maxCoeff(), kSigmas * std::sqrt(2.0 / count));
        EXPECT_LT(std::abs(product[i] / count), kSigmas / std::sqrt(count));
        EXPECT_LT((neighbour[i] / count).abs().maxCoeff(), kSigmas / std::sqrt(count));
    }
}

TEST_P(ChannelsOfSeed, OutliersComeWithTheirProbabilityAndSize) {
    constexpr int count = 10000;
    ChannelReceiver::Errors errors;
    errors.pseudorange_outliers = {.probability = 0.1, .size = 80.0};
    errors.range_rate_outliers = {.probability = 0.03, .size = 4.0};
    Eigen::Array3d found = Eigen::Array3d::Zero();  // of the pseudorange, of the range rate, of both
    Eigen::Array2d sum = Eigen::Array2d::Zero();
    double draws = 0.0;
    for_each_error(errors, GetParam(), count, [&](std::size_t, const Eigen::Array2d& error) {
        const Eigen::Array2d size = error / Eigen::Array2d(80.0, 4.0);
        const Eigen::Array2d hit = (size.abs() > 0.5).cast<double>();
        ASSERT_LT((size.abs() - hit).abs().maxCoeff(), 1e-8);
        found += Eigen::Array3d(hit[0], hit[1], hit.prod());
        sum += size;
        draws += 1.0;
    });
    const Eigen::Array3d probability(0.1, 0.03, 0.003);
    EXPECT_LT(((found / draws - probability) / (probability / draws).sqrt()).abs().maxCoeff(), kSigmas);
    EXPECT_LT((sum / (draws * probability.head<2>()).sqrt()).abs().maxCoeff(), kSigmas);
}

INSTANTIATE_TEST_SUITE_P(Seeds, ChannelsOfSeed, testing::Values(1U, 2U));

TEST(ChannelReceiver, TheNoiseFollowsTheProfileOfTheReceiver) {
    ChannelReceiver::Errors errors;
    errors.pseudorange_sigma = 1.0;
    errors.range_rate_sigma = 1.0;
    std::vector<Eigen::Array2d> calm;
    for_each_error(errors, 1, 3, [&](std::size_t, const Eigen::Array2d& error) { calm.push_back(error); });
    errors.noise_scale = {.step_factor = 6.0, .step = {.begin = 0.0, .end = 1.0}, .sine = {}};
    std::size_t k = 0;
    for_each_error(errors, 1, 3, [&](std::size_t, const Eigen::Array2d& error) {
        EXPECT_LT((error - 6.0 * calm.at(k++)).abs().maxCoeff(), 1e-7);
    });
    EXPECT_EQ(k, calm.size());
}

TEST(ChannelReceiver, ALimitLeavesTheHighestSatellitesWithTheMeasurementsTheyHad) {
    ChannelReceiver::Errors errors;
    errors.pseudorange_sigma = 5.0;
    errors.range_rate_sigma = 0.1;
    ChannelReceiver::Reception few = reception();
    few.limit = 3;
    few.limited = {.begin = 60.0, .end = 120.0};
    const ChannelReceiver open(reception(), errors, 1);
    const ChannelReceiver limited(few, errors, 1);
    ChannelAllocation open_allocation;
    ChannelAllocation limited_allocation;
    for (int t = 1; t <= 180; ++t) {
        const auto fix = static_cast<std::uint64_t>(t);
        const auto all = by_satellite(open.measure(fix, still(t), {}, open_allocation));
        const auto some = by_satellite(limited.measure(fix, still(t), {}, limited_allocation));
        ASSERT_EQ(some.size(), t >= 60 && t < 120 ? 3U : all.size()) << "t = " << t;
        double lowest = 10.0;
        for (const auto& [number, channel] : some) {
            ASSERT_EQ(channel.pseudorange, all.at(number).pseudorange);
            ASSERT_EQ(channel.range_rate, all.at(number).range_rate);
            lowest = std::min(lowest, elevation(channel));
        }
        if (t == 60) {
            for (const auto& [number, channel] : all) {
                EXPECT_TRUE(some.contains(number) || elevation(channel) < lowest);
            }
        }
    }
}

}  // namespace
}  // namespace truenorth::plant
