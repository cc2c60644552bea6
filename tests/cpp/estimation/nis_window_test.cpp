#include "estimation/nis_window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "estimation/saved_state.hpp"

namespace truenorth {
namespace {

// A measurement a second from `from` to `to`.
void feed(NisWindow& window, int from, int to, double nis, int channels) {
    for (int second = from; second <= to; ++second) {
        window.add(second, nis, channels);
    }
}

TEST(NisWindow, SaysNothingWhereThereIsNothing) {
    const NisWindow window;
    EXPECT_EQ(window.mean(0.0), 0.0);
    EXPECT_EQ(window.deviate(1e6), 0.0);
}

TEST(NisWindow, IsTheMeanForEachChannel) {
    NisWindow window;
    feed(window, 1, 20, 6.0, 3);
    feed(window, 21, 30, 1.0, 1);
    EXPECT_DOUBLE_EQ(window.mean(30.0), 130.0 / 70.0);
    EXPECT_NEAR(window.deviate(30.0), normal_deviate(130.0, 70), 1e-12);
}

TEST(NisWindow, ForgetsWhatIsOlderThanItsLength) {
    NisWindow window;
    feed(window, 0, 59, 20.0, 2);
    feed(window, 60, 113, 2.0, 2);
    EXPECT_DOUBLE_EQ(window.mean(113.0), 208.0 / 118.0);  // of the old, the part from 55 s on is still there
    feed(window, 114, 119, 2.0, 2);
    EXPECT_DOUBLE_EQ(window.mean(119.0), 1.0);
    EXPECT_EQ(window.mean(180.0), 0.0);  // no measurement for a whole length
}

TEST(NisWindow, OfAConsistentFilterIsRarelyBeyondItsLimit) {
    // 4 standard deviations: 3.2e-5 of the windows. Of 2 x 2000 windows without common measurements not one,
    // but with a probability of 12 %; two, but with one of 0.7 %.
    int beyond = 0;
    int beyond_if_larger = 0;
    for (const unsigned seed : {7U, 8U}) {
        std::mt19937 generator(seed);
        std::chi_squared_distribution<double> chi_square(2.0);
        NisWindow window;
        NisWindow larger;
        for (int second = 0; second < 2000 * 60; ++second) {
            const double nis = chi_square(generator);
            window.add(second, nis, 2);
            larger.add(second, 2.0 * nis, 2);
            if (second % 60 == 59) {
                beyond += window.deviate(second) > 4.0 ? 1 : 0;
                beyond_if_larger += larger.deviate(second) > 4.0 ? 1 : 0;
            }
        }
    }
    EXPECT_LE(beyond, 1);
    EXPECT_GT(beyond_if_larger, 3500);  // twice the innovation covariance: seen in seven windows of eight
}

TEST(NisWindow, ComesBackFromASavedState) {
    NisWindow window;
    feed(window, 5, 47, 2.5, 2);
    NisWindow other;
    SavedState::restore(other, SavedState::of(window));
    feed(window, 48, 90, 1.5, 2);
    feed(other, 48, 90, 1.5, 2);
    EXPECT_EQ(other.mean(90.0), window.mean(90.0));
}

// A damaged state may say so; a sum of integers would overflow.
TEST(NisWindow, CountsOnFromTheLargestNumber) {
    NisWindow window;
    feed(window, 0, 59, 1.0, std::numeric_limits<int>::max());
    EXPECT_NEAR(window.mean(59.0), 1.0 / std::numeric_limits<int>::max(), 1e-20);
    EXPECT_TRUE(std::isfinite(window.deviate(59.0)));
}

TEST(NisWindow, StartsAnew) {
    NisWindow window;
    feed(window, 0, 20, 9.0, 2);
    window.restart();
    EXPECT_EQ(window.mean(20.0), 0.0);
}

}  // namespace
}  // namespace truenorth
