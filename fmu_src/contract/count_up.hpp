// A counter that stays where it cannot go on. It may be anything: a stored state has it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace truenorth {

inline void count_up(int& counter, int by = 1) {
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    counter = static_cast<int>(std::min(std::int64_t{counter} + by, most));
}

}  // namespace truenorth
