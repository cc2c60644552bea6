// Exponentials with the same bits on every processor (see sincos.hpp). Error of e^x below 1 ulp, of e^x - 1
// below 2.
//
// x = k log 2 + r with |r| <= log(2) / 2, e^r = 1 + r + r^2 E(r), E minimax, relative error 2^-61.
#pragma once

#include <algorithm>
#include <cmath>

namespace truenorth {

namespace exponential_detail {  // NOLINTBEGIN(modernize-use-std-numbers): constants in two parts

// e^x = 2^power (1 + more)
struct Parts {
    int power;
    double more;
};

inline Parts parts_of(double x) {
    constexpr double ln2 = 0x1.62e42fefa3000p-1;  // its products with k are exact
    constexpr double rest_of_ln2 = 0x1.3de6af278ece6p-42;
    constexpr double inverse_ln2 = 0x1.71547652b82fep+0;
    const double k = std::floor(x * inverse_ln2 + 0.5);
    const double high = x - k * ln2;
    const double low = k * rest_of_ln2;
    const double r = high - low;
    const double rest = (high - r) - low;
    const double r2 = r * r;
    const double r4 = r2 * r2;
    const double E =
        (0.5 + r * 0x1.5555555555559p-3) + r2 * (0x1.555555555555ap-5 + r * 0x1.111111110f67ep-7) +
        r4 * (((0x1.6c16c16c1441ap-10 + r * 0x1.a01a01affb19dp-13) +
               r2 * (0x1.a01a01b0c8246p-16 + r * 0x1.71ddf8168b1f6p-19)) +
              r4 * ((0x1.27e4c57c1502bp-22 + r * 0x1.af5f32c4088adp-26) + r2 * 0x1.1f959c68fd8bbp-29));
    return {.power = static_cast<int>(k), .more = r + (r2 * E + rest * (1.0 + r))};
}

// Beyond these e^x is 0 and infinite. NOLINTEND(modernize-use-std-numbers)
inline constexpr double kLowest = -746.0;
inline constexpr double kHighest = 710.0;

}  // namespace exponential_detail

// e^x
inline double exponential(double x) {
    if (std::isnan(x)) {
        return x;
    }
    const auto [power, more] = exponential_detail::parts_of(
        std::clamp(x, exponential_detail::kLowest, exponential_detail::kHighest));
    return std::ldexp(1.0 + more, power);
}

// e^x - 1
inline double exponential_minus_one(double x) {
    if (!(x < 40.0)) {  // of which one is no part
        return exponential(x) - 1.0;
    }
    const auto [power, more] = exponential_detail::parts_of(std::max(x, exponential_detail::kLowest));
    return std::ldexp(more, power) + (std::ldexp(1.0, power) - 1.0);
}

}  // namespace truenorth
