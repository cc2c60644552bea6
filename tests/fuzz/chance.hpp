// Random arguments, the awkward ones more often than they deserve. Equal seeds make equal arguments.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>
#include <vector>

namespace truenorth::fuzz {

class Chance {
  public:
    explicit Chance(std::uint64_t seed) : engine_(seed) {}

    // A whole number below `end`.
    std::size_t below(std::size_t end) { return static_cast<std::size_t>(engine_() % end); }

    bool one_in(std::size_t count) { return below(count) == 0; }

    double uniform(double least, double most) {
        return least + (most - least) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
    }

    double real() {
        static constexpr std::array awkward{0.0,
                                            -0.0,
                                            1.0,
                                            -1.0,
                                            0.01,
                                            1e-300,
                                            1e9,
                                            -1e10,
                                            1e100,
                                            std::numeric_limits<double>::max(),
                                            std::numeric_limits<double>::lowest(),
                                            std::numeric_limits<double>::infinity(),
                                            std::numeric_limits<double>::quiet_NaN(),
                                            std::numeric_limits<double>::denorm_min()};
        return one_in(2) ? awkward[below(awkward.size())] : uniform(-10.0, 10.0);
    }

    std::int32_t integer() {
        static constexpr std::array awkward{0, 1, -1, std::numeric_limits<std::int32_t>::max(),
                                            std::numeric_limits<std::int32_t>::min()};
        return one_in(2) ? awkward[below(awkward.size())] : static_cast<std::int32_t>(below(8));
    }

    // A reference of the `count` that there are, now and then one that there is not.
    std::uint32_t reference(std::size_t count) {
        return static_cast<std::uint32_t>(one_in(50) ? engine_() : below(count + 2));
    }

    // The pointer, now and then NULL.
    template <class T>
    T* perhaps(T* pointer) {
        return one_in(40) ? nullptr : pointer;
    }

  private:
    std::mt19937_64 engine_;
};

}  // namespace truenorth::fuzz
