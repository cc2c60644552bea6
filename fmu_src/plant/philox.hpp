// Philox4x32-10, the counter-based random bit generator of Salmon et al. 2011 ("Parallel random numbers: as
// easy as 1, 2, 3", SC11): a bijection of a 128-bit counter, chosen by a 64-bit key. It has no state, so any
// draw of any stream can be had at any time, and no draw depends on another.
#pragma once

#include <array>
#include <cstdint>

namespace truenorth::plant {

using PhiloxCounter = std::array<std::uint32_t, 4>;
using PhiloxKey = std::array<std::uint32_t, 2>;

constexpr PhiloxCounter philox(PhiloxCounter counter, PhiloxKey key) {
    constexpr std::uint64_t multiplier_0 = 0xD2511F53U;
    constexpr std::uint64_t multiplier_1 = 0xCD9E8D57U;
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t product_0 = multiplier_0 * counter[0];
        const std::uint64_t product_1 = multiplier_1 * counter[2];
        counter = {
            static_cast<std::uint32_t>(product_1 >> 32U) ^ counter[1] ^ key[0],
            static_cast<std::uint32_t>(product_1),
            static_cast<std::uint32_t>(product_0 >> 32U) ^ counter[3] ^ key[1],
            static_cast<std::uint32_t>(product_0),
        };
        key[0] += 0x9E3779B9U;  // the golden ratio
        key[1] += 0xBB67AE85U;  // sqrt(3) - 1
    }
    return counter;
}

}  // namespace truenorth::plant
