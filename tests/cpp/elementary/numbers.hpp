// What the tests of elementary functions share: numbers of all sizes, and how far one is off.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

namespace truenorth {

// Distance of a number from what it should be, in units of the last place of that.
inline double ulps(double number, long double exact) {
    int exponent = 0;
    std::frexp(exact, &exponent);
    return static_cast<double>(std::abs(number - exact) / std::ldexp(1.0L, exponent - 53));
}

// Numbers that are drawn alike everywhere.
class Drawn {
  public:
    double uniform(double from, double to) {
        return from + (to - from) * (static_cast<double>(bits_() >> 11U) * 0x1p-53);
    }

  private:
    std::mt19937_64 bits_{1};
};

// FNV-1a of the bits of numbers.
class Print {
  public:
    void add(double number) { hash_ = (hash_ ^ std::bit_cast<std::uint64_t>(number)) * 0x100000001b3U; }
    [[nodiscard]] std::uint64_t value() const { return hash_; }

  private:
    std::uint64_t hash_ = 0xcbf29ce484222325U;
};

}  // namespace truenorth
