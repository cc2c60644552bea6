#include "elementary/exponential.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "elementary/numbers.hpp"

namespace truenorth {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Exponential, IsOffByLessThanAnUlpAndLessOneByLessThanTwo) {
    if (std::numeric_limits<long double>::digits < 64) {
        GTEST_SKIP() << "long double has " << std::numeric_limits<long double>::digits << " digits here";
    }
    Drawn drawn;
    for (int i = 0; i < 200000; ++i) {
        for (const double x : {drawn.uniform(-1.0, 1.0), drawn.uniform(-700.0, 700.0),
                               -std::exp2(drawn.uniform(-60.0, 5.0)), std::exp2(drawn.uniform(-60.0, 5.0))}) {
            const auto exact = static_cast<long double>(x);
            ASSERT_LT(ulps(exponential(x), std::exp(exact)), 1.0) << x;
            ASSERT_LT(ulps(exponential_minus_one(x), std::expm1(exact)), 2.0) << x;
        }
    }
}

TEST(Exponential, OfLimitsIsThatOfTheStandard) {
    for (const double x :
         {0.0, -0.0, -745.0, -745.2, -1e9, 709.7, 709.79, 711.0, 1e9, -kInfinity, kInfinity}) {
        EXPECT_DOUBLE_EQ(exponential(x), std::exp(x)) << x;
        EXPECT_DOUBLE_EQ(exponential_minus_one(x), std::expm1(x)) << x;
    }
    EXPECT_TRUE(std::isnan(exponential(std::numeric_limits<double>::quiet_NaN())));
    EXPECT_TRUE(std::isnan(exponential_minus_one(std::numeric_limits<double>::quiet_NaN())));
}

// As it was on x86-64, with and without AVX2 and FMA in the C library.
TEST(Exponential, HasTheSameBitsEverywhere) {
    Print print;
    for (int i = -200000; i < 200000; ++i) {
        print.add(exponential(i * 0x1.3p-10));
        print.add(exponential_minus_one(i * 0x1.3p-13));
    }
    EXPECT_EQ(print.value(), 5030932952825814422U);
}

}  // namespace
}  // namespace truenorth
