// The natural logarithm with the same bits on every processor (see sincos.hpp). Error below 1 ulp.
//
// x = 2^k (1 + f) with 1 + f from sqrt(1/2) to sqrt(2), and with s = f / (2 + f)
//
//     log(1 + f) = 2 atanh s = 2 s + s R(s^2) = f - (f^2 / 2 - s (f^2 / 2 + R(s^2)))
//
// where R is minimax, relative error of the whole 2^-59.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace truenorth {

// Of x; minus infinity at 0, no number below it.
inline double logarithm(double x) {  // NOLINTBEGIN(modernize-use-std-numbers, *-nested-conditional-operator)
    constexpr double ln2 = 0x1.62e42fefa3000p-1;  // its products with exponents are exact
    constexpr double rest_of_ln2 = 0x1.3de6af278ece6p-42;
    constexpr double sqrt_half = 0x1.6a09e667f3bcdp-1;

    if (!(x > 0.0) || x == std::numeric_limits<double>::infinity()) {
        return x == 0.0 ? -std::numeric_limits<double>::infinity()
                        : (x > 0.0 ? x : std::numeric_limits<double>::quiet_NaN());
    }
    int exponent = 0;
    double mantissa = std::frexp(x, &exponent);
    if (mantissa < sqrt_half) {
        mantissa *= 2.0;
        --exponent;
    }
    const double f = mantissa - 1.0;
    const double s = f / (2.0 + f);
    const double z = s * s;
    const double z2 = z * z;
    const double R =
        z * ((0x1.5555555555592p-1 + z * 0x1.999999997fd76p-2) +
             z2 * ((0x1.24924941f5011p-2 + z * 0x1.c71c520604be4p-3) +
                   z2 * ((0x1.74663fa29c0c2p-3 + z * 0x1.39a1a6ef4624fp-3) + z2 * 0x1.2f0634b6afe37p-3)));
    const double half_square = 0.5 * f * f;
    return exponent * ln2 - ((half_square - (s * (half_square + R) + exponent * rest_of_ln2)) - f);
}  // NOLINTEND(modernize-use-std-numbers, *-nested-conditional-operator)

}  // namespace truenorth
