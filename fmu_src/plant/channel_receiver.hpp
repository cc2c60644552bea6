// A GNSS receiver that measures pseudoranges and range rates on up to twelve channels:
//
//     pseudorange = |r_s - r_a| + clock bias + noise + outlier
//     range rate  = u . (v_s - v_a) + clock drift + noise + outlier,    u = (r_s - r_a) / |r_s - r_a|
//
// with the positions r and velocities v of satellite and antenna in the Earth-fixed frame e, all at the time
// of validity. The signal takes no time: there is neither light time nor Sagnac effect, neither atmosphere
// nor ephemeris error; a filter predicts with these equations and no corrections. Every satellite has its own
// noise, whatever channel it is on.
#pragma once

#include <cstdint>

#include "plant/channel_allocation.hpp"
#include "plant/fix.hpp"
#include "plant/noise_scale.hpp"
#include "plant/outliers.hpp"
#include "plant/receiver_clock.hpp"
#include "plant/time_window.hpp"

namespace truenorth::plant {

class ChannelReceiver {
  public:
    struct Reception {
        double constellation_epoch = 0.0;  // time of the constellation at time 0 [s]
        double mask_angle = 0.0;           // satellites below it are not received [rad]
        std::size_t limit = kChannels;     // satellites at most, in the window `limited`
        TimeWindow limited;
    };

    struct Errors {
        double pseudorange_sigma = 0.0;  // [m]
        double range_rate_sigma = 0.0;   // [m/s]
        Outliers pseudorange_outliers;   // [m]
        Outliers range_rate_outliers;    // [m/s]
        NoiseScale noise_scale;
    };

    ChannelReceiver(const Reception& reception, const Errors& errors, std::uint32_t seed)
        : reception_(reception), errors_(errors), seed_(seed) {}

    // The channels of fix number `fix` (1, 2, ...), from the antenna's true state.
    [[nodiscard]] std::array<Channel, kChannels> measure(std::uint64_t fix, const Fix& truth,
                                                         const ReceiverClock::State& clock,
                                                         ChannelAllocation& allocation) const;

  private:
    Reception reception_;
    Errors errors_;
    std::uint32_t seed_;
};

}  // namespace truenorth::plant
