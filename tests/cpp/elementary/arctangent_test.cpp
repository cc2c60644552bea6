#include "elementary/arctangent.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "elementary/numbers.hpp"

namespace truenorth {
namespace {

struct Point {
    double y, x;
};

// Of all directions and sizes, and where the function is pieced together.
std::vector<Point> points() {
    Drawn drawn;
    std::vector<Point> all;
    for (int i = 0; i < 100000; ++i) {
        all.push_back({drawn.uniform(-1.0, 1.0), drawn.uniform(-1.0, 1.0)});
        const double size = std::exp2(drawn.uniform(-60.0, 60.0));
        all.push_back({size * drawn.uniform(-1.0, 1.0), drawn.uniform(-1.0, 1.0)});
        const double eighths = std::floor(drawn.uniform(-8.0, 9.0));
        const double near = eighths * std::numbers::pi / 8.0 + drawn.uniform(-1e-9, 1e-9);
        all.push_back({std::sin(near), std::cos(near)});
    }
    return all;
}

TEST(Arctangent, IsOffByLessThanTwoAndAHalfUlp) {
    if (std::numeric_limits<long double>::digits < 64) {
        GTEST_SKIP() << "long double has " << std::numeric_limits<long double>::digits << " digits here";
    }
    for (const auto& [y, x] : points()) {
        const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
        ASSERT_LT(ulps(arctangent(y, x), exact), 2.5) << y << ", " << x;
    }
}

TEST(Arctangent, OfAxesAndZerosIsThatOfTheStandard) {
    for (const double y : {0.0, -0.0, 1.0, -1.0, 5e-324}) {
        for (const double x : {0.0, -0.0, 1.0, -1.0, -5e-324}) {
            const double expected = std::atan2(y, x);
            EXPECT_EQ(arctangent(y, x), expected) << y << ", " << x;
            EXPECT_EQ(std::signbit(arctangent(y, x)), std::signbit(expected)) << y << ", " << x;
        }
    }
}

TEST(Arctangent, OfWhatIsNoNumberIsNone) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(arctangent(none, 1.0)));
    EXPECT_TRUE(std::isnan(arctangent(1.0, none)));
    EXPECT_TRUE(std::isnan(arctangent(none, none)));
}

TEST(Arctangent, OfASetIsThatOfItsElements) {
    const Eigen::Array4d y(0.1, -3.0, 0.0, 1e-9);
    const Eigen::Array4d x(-2.0, 0.5, -1.0, 1e3);
    const Eigen::Array4d angles = arctangent(y, x);
    for (Eigen::Index i = 0; i < angles.size(); ++i) {
        EXPECT_EQ(angles(i), arctangent(y(i), x(i)));
    }
}

// As it was on x86-64, with and without AVX2 and FMA in the C library.
TEST(Arctangent, HasTheSameBitsEverywhere) {
    Print print;
    for (int i = -200000; i < 200000; ++i) {
        print.add(arctangent(i * 0x1.3p-9, 300.0 - i * 0x1.1p-8));
    }
    EXPECT_EQ(print.value(), 3769415193649580237U);
}

}  // namespace
}  // namespace truenorth
