#include "estimation/igg.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "estimation/random_measurement.hpp"

namespace truenorth {
namespace {

// The three pieces of IGG III for k0 = 2.5, k1 = 8.
double weight_of(double u) {
    if (u > 8.0) {
        return 0.0;
    }
    return u > 2.5 ? 2.5 / u * std::pow((8.0 - u) / 5.5, 2) : 1.0;
}

TEST(IggWeight, HasThreePiecesThatMeet) {
    const Igg<kStates> igg;
    EXPECT_EQ(igg.weight(0.0), 1.0);
    EXPECT_EQ(igg.weight(2.5), 1.0);
    EXPECT_NEAR(igg.weight(2.5000001), 1.0, 1e-6);
    EXPECT_NEAR(igg.weight(5.25), 2.5 / 5.25 / 4.0, 1e-15);  // half way
    EXPECT_NEAR(igg.weight(7.9999999), 0.0, 1e-15);
    EXPECT_EQ(igg.weight(8.0), 0.0);
    EXPECT_EQ(igg.weight(1e9), 0.0);
}

class IggCorrector : public testing::TestWithParam<unsigned> {};

TEST_P(IggCorrector, InflatesTheNoiseOfSuspectsAndRemovesOutliers) {
    RandomCovariance random(GetParam());
    int suspects = 0;
    int outliers = 0;
    for (int i = 0; i < 300; ++i) {
        const RandomMeasurement c(random, 4.0);
        std::vector<int> kept;
        Channels weight;
        Channels R = c.R;
        for (int j = 0; j < kChannels; ++j) {
            const double S = c.H.row(j) * c.P * c.H.row(j).transpose() + c.R(j);
            weight(j) = weight_of(std::abs(c.residual(j)) / std::sqrt(S));
            if (weight(j) > 0.0) {
                R(j) = c.R(j) / weight(j);
                kept.push_back(j);
            }
            outliers += weight(j) == 0.0 ? 1 : 0;
            suspects += weight(j) > 0.0 && weight(j) < 1.0 ? 1 : 0;
        }
        const auto correction = Igg<kStates>().correct(c.P, c.innovation());
        EXPECT_TRUE(is_sound(correction));
        EXPECT_LT((correction.weight - weight).norm(), 1e-12);
        for (const int j : kept) {
            EXPECT_NEAR(correction.noise(j, j), R(j), 1e-9 * R(j));
        }
        if (kept.empty()) {
            EXPECT_EQ(correction.deviation, Vector<kStates>::Zero());
            EXPECT_EQ(correction.covariance, c.P);
            continue;
        }
        const DenseUpdate expected(c.P, c.H, R, c.residual, kept);
        EXPECT_LT((correction.deviation - expected.deviation).norm(), 1e-8);
        EXPECT_LT(relative_difference(correction.covariance, expected.covariance), 1e-11);
    }
    EXPECT_GT(suspects, 100);
    EXPECT_GT(outliers, 20);
}

TEST_P(IggCorrector, KeepsCorrelationsOfTheNoise) {
    RandomCovariance random(GetParam());
    const RandomMeasurement c(random, 1.0);
    auto innovation = c.innovation();
    innovation.noise = random.covariance<kChannels>(0.1, 2.0);
    innovation.residual.setZero();
    innovation.residual(1) = 4.0 * std::sqrt(innovation.spread(1, 1) + innovation.noise(1, 1));
    const Matrix<kChannels> R = Igg<kStates>().correct(c.P, innovation).noise;
    const auto correlation = [](const Matrix<kChannels>& A, int i, int j) {
        return A(i, j) / std::sqrt(A(i, i) * A(j, j));
    };
    EXPECT_NEAR(R(1, 1), innovation.noise(1, 1) / weight_of(4.0), 1e-12 * R(1, 1));
    EXPECT_NEAR(correlation(R, 0, 1), correlation(innovation.noise, 0, 1), 1e-14);
    EXPECT_EQ(R(0, 2), innovation.noise(0, 2));
}

INSTANTIATE_TEST_SUITE_P(Seeds, IggCorrector, testing::Values(61U, 6161U));

// One state, measured directly: P = 3, R = 1.
Innovation<1, 1> scalar(double u) {
    return innovation_of<1, 1>(Matrix<1>(3.0), Matrix<1>(1.0), Matrix<1>(1.0), Vector<1>(2.0 * u));
}

TEST(IggGuard, HandsOverAfterFiveConsecutiveBadEpochs) {
    Igg<1> igg;
    const Matrix<1> P(3.0);
    for (int k = 0; k < 5; ++k) {
        const auto correction = igg.correct(P, scalar(20.0));
        EXPECT_EQ(correction.weight(0), 0.0);
        EXPECT_EQ(correction.alpha, 1.0);
    }
    const auto handed_over = igg.correct(P, scalar(20.0));
    EXPECT_EQ(handed_over.weight(0), 1.0);
    EXPECT_NEAR(handed_over.alpha, 2.1 / 400.0, 1e-15);
    EXPECT_NEAR(handed_over.deviation(0), 40.0, 0.1);
    // A good epoch gives it back, and the count begins anew.
    EXPECT_EQ(igg.correct(P, scalar(1.0)).alpha, 1.0);
    EXPECT_EQ(igg.correct(P, scalar(20.0)).weight(0), 0.0);
}

TEST(IggGuard, CountsOnlyConsecutiveEpochs) {
    Igg<1> igg;
    const Matrix<1> P(3.0);
    for (int k = 0; k < 40; ++k) {
        EXPECT_EQ(igg.correct(P, scalar(k % 5 == 4 ? 1.0 : 20.0)).alpha, 1.0);
    }
}

TEST(IggGuard, TakesADownWeightedEpochForBad) {
    Igg<1> igg;
    const Matrix<1> P(3.0);
    for (int k = 0; k < 5; ++k) {
        EXPECT_EQ(igg.correct(P, scalar(3.0)).alpha, 1.0);
    }
    EXPECT_NEAR(igg.correct(P, scalar(3.0)).alpha, 2.1 / 9.0, 1e-15);
}

}  // namespace
}  // namespace truenorth
