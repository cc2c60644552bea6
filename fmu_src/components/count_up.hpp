// A counter that stays where it cannot go on.
#pragma once

#include <limits>

namespace truenorth {

inline void count_up(int& counter, int by = 1) {
    counter = by > std::numeric_limits<int>::max() - counter ? std::numeric_limits<int>::max() : counter + by;
}

}  // namespace truenorth
