#include "elementary/sincos.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "elementary/numbers.hpp"

namespace truenorth {
namespace {

constexpr long double kHalfPi = std::numbers::pi_v<long double> / 2.0L;

// Small and large angles of both signs, and the doubles round multiples of a quarter turn, where what is left
// of the angle has lost the most digits.
std::vector<double> angles() {
    Drawn drawn;
    std::vector<double> all{0.0, 1e-300, 5e-324, 1e8, -1e8};
    for (int i = 0; i < 50000; ++i) {
        all.push_back(drawn.uniform(-7.0, 7.0));
        all.push_back(std::exp2(drawn.uniform(-60.0, 26.5)));
        all.push_back(-std::exp2(drawn.uniform(-60.0, 26.5)));
        const double quarter_turns = std::floor(std::exp2(drawn.uniform(0.0, 25.9)));
        const auto near = static_cast<double>(quarter_turns * kHalfPi);
        all.insert(all.end(),
                   {near, std::nextafter(near, 0.0), std::nextafter(near, 1e9), std::nextafter(-near, 0.0)});
    }
    return all;
}

TEST(Sincos, IsOffByLessThanAnUlp) {
    if (std::numeric_limits<long double>::digits < 64) {
        GTEST_SKIP() << "long double has " << std::numeric_limits<long double>::digits << " digits here";
    }
    for (const double angle : angles()) {
        const auto [sine, cosine] = sincos(angle);
        const auto exact = static_cast<long double>(angle);
        ASSERT_LT(ulps(sine, std::sin(exact)), 0.8) << angle;
        ASSERT_LT(ulps(cosine, std::cos(exact)), 0.8) << angle;
    }
}

TEST(Sincos, OfASetIsThatOfItsElements) {
    const std::vector<double> all = angles();
    using Set = Eigen::Array<double, 1, 21>;
    for (std::size_t first = 0; first + Set::SizeAtCompileTime <= all.size();
         first += Set::SizeAtCompileTime) {
        const Set set = Eigen::Map<const Set>(&all[first]);
        const auto [sine, cosine] = sincos(set);
        for (Eigen::Index i = 0; i < set.size(); ++i) {
            ASSERT_EQ(sine(i), sincos(set(i)).sine) << set(i);
            ASSERT_EQ(cosine(i), sincos(set(i)).cosine) << set(i);
        }
    }
    const auto [sine, cosine] = sincos(Eigen::Array3d(3e8, 0.5, -1e200));
    EXPECT_EQ(sine[0], sincos(3e8).sine);
    EXPECT_EQ(cosine[1], sincos(0.5).cosine);
    EXPECT_EQ(cosine[2], sincos(-1e200).cosine);
}

// Far away as if the angle were off by (2 pi - its double) / 2 pi, 0.35 of its ulp at most.
TEST(Sincos, FarAnglesAreOffByLessThanTheirOwnRounding) {
    for (double angle = 1.1e8; angle < 1e15; angle *= 1.7) {
        const double off = 0.5 * std::abs(std::nextafter(angle, 0.0) - angle);
        EXPECT_NEAR(sincos(angle).sine, std::sin(angle), off + 1e-15) << angle;
        EXPECT_NEAR(sincos(angle).cosine, std::cos(angle), off + 1e-15) << angle;
    }
}

TEST(Sincos, OfWhatIsNoAngleIsNoNumber) {
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double angle : {infinity, -infinity, std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_TRUE(std::isnan(sincos(angle).sine));
        EXPECT_TRUE(std::isnan(sincos(angle).cosine));
        EXPECT_TRUE(std::isnan(sincos(Eigen::Array2d(angle, 1.0)).sine[0]));
    }
}

// The bits are part of the signals. FNV-1a over all of them, as it was on x86-64, with and without AVX2 and
// FMA in the C library, and on aarch64.
TEST(Sincos, HasTheSameBitsEverywhere) {
    Print print;
    for (int i = -200000; i < 200000; ++i) {
        const auto [sine, cosine] = sincos(i * 0x1.9p-7 + 0x1p-40 * i * i);
        print.add(sine);
        print.add(cosine);
    }
    EXPECT_EQ(print.value(), 8973664113680001584U);
}

}  // namespace
}  // namespace truenorth
