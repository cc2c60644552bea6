#include "plant/channel_allocation.hpp"

#include <algorithm>
#include <numeric>

namespace truenorth::plant {

void ChannelAllocation::update(const Elevations& elevations, double mask, std::size_t most) {
    const auto elevation = [&](std::int32_t satellite) {
        return elevations[static_cast<std::size_t>(satellite) - 1];
    };
    const auto followed = [&](std::int32_t satellite) {
        return std::ranges::find(satellites_, satellite) != satellites_.end();
    };

    std::array<std::int32_t, kSatellites> highest_first{};
    std::iota(highest_first.begin(), highest_first.end(), 1);
    std::ranges::sort(highest_first, std::ranges::greater{}, elevation);

    std::array<std::int32_t, kChannels> kept{};
    std::size_t count = 0;
    for (const std::int32_t satellite : highest_first) {
        if (followed(satellite) && elevation(satellite) > mask && count < most) {
            kept[static_cast<std::size_t>(std::ranges::find(satellites_, satellite) - satellites_.begin())] =
                satellite;
            ++count;
        }
    }
    satellites_ = kept;
    for (const std::int32_t satellite : highest_first) {
        if (!followed(satellite) && elevation(satellite) > mask && count < most) {
            *std::ranges::find(satellites_, 0) = satellite;
            ++count;
        }
    }
}

}  // namespace truenorth::plant
