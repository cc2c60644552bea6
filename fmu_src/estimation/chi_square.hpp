// Quantiles of chi-square in terms of the normal distribution: the cube root of chi-square per degree of
// freedom is nearly normal, of mean 1 - v and variance v = 2 / (9 degrees) (Wilson and Hilferty 1931).
#pragma once

#include <cmath>

#include "elementary/exponential.hpp"
#include "elementary/logarithm.hpp"

namespace truenorth {

// What chi-square of so many degrees of freedom exceeds as rarely as a standard normal variable exceeds
// `deviate`.
inline double chi_square_beyond(double deviate, int degrees) {
    const double v = 2.0 / (9.0 * degrees);
    const double root = 1.0 - v + deviate * std::sqrt(v);
    return degrees * root * root * root;
}

// The inverse: the standard normal variable that is as rare as this chi-square.
inline double normal_deviate(double chi_square, double degrees) {
    const double v = 2.0 / (9.0 * degrees);
    const double share = chi_square / degrees;
    const double root = std::copysign(exponential(logarithm(std::abs(share)) / 3.0), share);
    return (root - (1.0 - v)) / std::sqrt(v);
}

}  // namespace truenorth
