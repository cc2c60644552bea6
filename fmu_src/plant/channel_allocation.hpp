// Which satellite each channel of a receiver follows. A satellite keeps its channel while it is received;
// those that come into view take the free channels in order, the highest first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "plant/constellation.hpp"
#include "plant/fix.hpp"

namespace truenorth::plant {

class ChannelAllocation {
  public:
    using Elevations = std::array<double, kSatellites>;  // [rad], or any function that grows with it

    // Receives satellites above `mask`, and of these `most` at most: if more are followed already, the lowest
    // ones are lost.
    void update(const Elevations& elevations, double mask, std::size_t most);

    // Number of each channel's satellite, from 1 on; 0: the channel is free.
    [[nodiscard]] const std::array<std::int32_t, kChannels>& satellites() const { return satellites_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(satellites_);
    }

  private:
    std::array<std::int32_t, kChannels> satellites_{};
};

}  // namespace truenorth::plant
