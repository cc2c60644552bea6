#include "elementary/logarithm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "elementary/numbers.hpp"

namespace truenorth {
namespace {

TEST(Logarithm, IsOffByLessThanAnUlp) {
    if (std::numeric_limits<long double>::digits < 64) {
        GTEST_SKIP() << "long double has " << std::numeric_limits<long double>::digits << " digits here";
    }
    Drawn drawn;
    for (int i = 0; i < 200000; ++i) {
        for (const double x : {drawn.uniform(0.0, 1.0), drawn.uniform(0.5, 2.0),
                               1.0 + drawn.uniform(-1e-6, 1e-6), std::exp2(drawn.uniform(-1070.0, 1023.0))}) {
            ASSERT_LT(ulps(logarithm(x), std::log(static_cast<long double>(x))), 1.0) << x;
        }
    }
}

TEST(Logarithm, OfLimitsIsThatOfTheStandard) {
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(logarithm(1.0), 0.0);
    EXPECT_EQ(logarithm(0.0), -infinity);
    EXPECT_EQ(logarithm(infinity), infinity);
    EXPECT_TRUE(std::isnan(logarithm(-1.0)));
    EXPECT_TRUE(std::isnan(logarithm(std::numeric_limits<double>::quiet_NaN())));
}

// As it was on x86-64, with and without AVX2 and FMA in the C library.
TEST(Logarithm, HasTheSameBitsEverywhere) {
    Print print;
    for (int i = 1; i < 400000; ++i) {
        print.add(logarithm(i * 0x1.3p-17));
    }
    EXPECT_EQ(print.value(), 3146742670974488576U);
}

}  // namespace
}  // namespace truenorth
