#include "plant/channel_allocation.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <utility>

namespace truenorth::plant {
namespace {

constexpr double kMask = 0.1;

using Satellites = std::array<std::int32_t, kChannels>;

// Elevations of the satellites named; all others are below the horizon.
ChannelAllocation::Elevations elevations(std::initializer_list<std::pair<std::size_t, double>> in_view) {
    ChannelAllocation::Elevations all{};
    all.fill(-1.0);
    for (const auto& [satellite, elevation] : in_view) {
        all[satellite - 1] = elevation;
    }
    return all;
}

TEST(ChannelAllocation, TheHighestSatellitesComeFirst) {
    ChannelAllocation allocation;
    allocation.update(elevations({{3, 0.5}, {24, 1.2}, {7, 0.11}, {1, 0.09}, {10, 0.8}}), kMask, kChannels);
    EXPECT_EQ(allocation.satellites(), (Satellites{24, 10, 3, 7}));
}

TEST(ChannelAllocation, ASatelliteKeepsItsChannelAndANewOneTakesTheFirstFreeOne) {
    ChannelAllocation allocation;
    allocation.update(elevations({{3, 0.5}, {24, 1.2}, {10, 0.8}}), kMask, kChannels);
    allocation.update(elevations({{3, 1.0}, {24, 0.2}, {10, 0.05}}), kMask, kChannels);
    EXPECT_EQ(allocation.satellites(), (Satellites{24, 0, 3}));
    allocation.update(elevations({{3, 1.1}, {24, 0.15}, {5, 0.11}, {6, 0.12}}), kMask, kChannels);
    EXPECT_EQ(allocation.satellites(), (Satellites{24, 6, 3, 5}));
}

TEST(ChannelAllocation, OfMoreSatellitesThanChannelsTheLowestWait) {
    ChannelAllocation::Elevations all{};
    for (std::size_t i = 0; i < kSatellites; ++i) {
        all[i] = 0.2 + 0.01 * static_cast<double>(i);
    }
    ChannelAllocation allocation;
    allocation.update(all, kMask, kChannels);
    EXPECT_EQ(allocation.satellites(), (Satellites{24, 23, 22, 21, 20, 19, 18, 17, 16, 15, 14, 13}));
    all[19] = 0.0;
    allocation.update(all, kMask, kChannels);
    EXPECT_EQ(allocation.satellites(), (Satellites{24, 23, 22, 21, 12, 19, 18, 17, 16, 15, 14, 13}));
}

TEST(ChannelAllocation, ALimitDropsTheLowestAndKeepsTheOthersThroughout) {
    ChannelAllocation allocation;
    const auto before = elevations({{1, 0.9}, {2, 0.8}, {3, 0.7}, {4, 0.6}});
    allocation.update(before, kMask, kChannels);
    const auto changed = elevations({{1, 0.5}, {2, 0.9}, {3, 0.7}, {4, 0.6}});
    allocation.update(changed, kMask, 2);
    EXPECT_EQ(allocation.satellites(), (Satellites{0, 2, 3}));
    allocation.update(before, kMask, 2);  // those followed stay, however high others are
    EXPECT_EQ(allocation.satellites(), (Satellites{0, 2, 3}));
    allocation.update(elevations({{1, 0.9}, {2, 0.8}, {3, 0.05}, {4, 0.6}}), kMask, 2);
    EXPECT_EQ(allocation.satellites(), (Satellites{1, 2}));
    allocation.update(before, kMask, kChannels);
    EXPECT_EQ(allocation.satellites(), (Satellites{1, 2, 3, 4}));
    allocation.update(before, kMask, 0);
    EXPECT_EQ(allocation.satellites(), Satellites{});
}

}  // namespace
}  // namespace truenorth::plant
