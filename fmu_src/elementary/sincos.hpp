// Sine and cosine together, of one angle or of each of a set, with the same bits on every processor: nothing
// but additions, multiplications and bit patterns of IEEE 754, where a C library chooses its instructions by
// the machine. Error below 1 ulp.
//
// The angle is k quarter turns and a remainder |y| <= pi/4 (Cody and Waite, "Software manual for the
// elementary functions", 1980). pi/2 is the sum of four parts: for |k| < 2^26 the products of k with three of
// them are exact, and so are the differences from the first two. Of y the polynomials
//
//     sin y = y + y^3 S(y^2),    cos y = 1 - y^2 / 2 + y^4 C(y^2)
//
// are minimax, relative errors 2^-57 and 2^-63. What is rounded off y counts to first order.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace truenorth {

template <class Angles>
struct SineCosine {
    Angles sine, cosine;
};

namespace sincos_detail {

// Beyond this [rad] whole turns of the rounded 2 pi are taken off first, exactly: as if the angle were off by
// less than half an ulp.
inline constexpr double kFarthest = 1e8;

inline double within_reach(double angle) {
    return std::abs(angle) <= kFarthest ? angle : std::remainder(angle, 2.0 * std::numbers::pi);
}

inline SineCosine<double> within_reach_of(double angle) {
    // Added to a number below 2^51 it leaves the nearest integer, in the last bits of the sum too.
    constexpr double rounder = 0x1.8p52;
    const double rounded = angle * (2.0 * std::numbers::inv_pi) + rounder;
    const auto quadrant = std::bit_cast<std::uint64_t>(rounded);
    const double k = rounded - rounder;

    const double exact = (angle - k * 0x1.921fb54p+0) - k * 0x1.10b46p-30;
    const double third = k * 0x1.1a6263p-54;
    const double y = exact - third;
    const double rest = ((exact - y) - third) - k * 0x1.8a2e03707344ap-81;

    const double z = y * y;
    const double z2 = z * z;
    const double S = (-0x1.555555555554dp-3 + z * 0x1.111111110fd03p-7) +
                     z2 * ((-0x1.a01a019c823a1p-13 + z * 0x1.71de35c7f0850p-19) +
                           z2 * (-0x1.ae5e9bc4c2139p-26 + z * 0x1.5da094f980492p-33));
    const double C = (0x1.5555555555553p-5 + z * -0x1.6c16c16c15eb3p-10) +
                     z2 * ((0x1.a01a019dcd628p-16 + z * -0x1.27e4f8be6373ap-22) +
                           z2 * (0x1.1eea59e6592fbp-29 + z * -0x1.8fe26496c0bd0p-37));
    const double half = 0.5 * z;
    const double near_one = 1.0 - half;
    const auto sine = std::bit_cast<std::uint64_t>(y + (y * z * S + rest * near_one));
    const auto cosine =
        std::bit_cast<std::uint64_t>(near_one + (((1.0 - near_one) - half) + (z2 * C - y * rest)));

    // An odd number of quarter turns exchanges them, two change both signs.
    const std::uint64_t exchanged = (sine ^ cosine) & -(quadrant & 1U);
    return {.sine = std::bit_cast<double>((sine ^ exchanged) ^ (quadrant & 2U) << 62U),
            .cosine = std::bit_cast<double>((cosine ^ exchanged) ^ ((quadrant + 1U) & 2U) << 62U)};
}

}  // namespace sincos_detail

inline SineCosine<double> sincos(double angle) {
    return sincos_detail::within_reach_of(sincos_detail::within_reach(angle));
}

// Of every element of an array of fixed size.
template <class Derived>
SineCosine<typename Derived::PlainObject> sincos(const Eigen::ArrayBase<Derived>& angles) {
    typename Derived::PlainObject angle = angles;
    if (angle.abs().maxCoeff() > sincos_detail::kFarthest) {
        angle = angle.unaryExpr(&sincos_detail::within_reach);
    }
    SineCosine<typename Derived::PlainObject> result;
    for (Eigen::Index i = 0; i < angle.size(); ++i) {
        const auto [sine, cosine] = sincos_detail::within_reach_of(angle(i));
        result.sine(i) = sine;
        result.cosine(i) = cosine;
    }
    return result;
}

}  // namespace truenorth
