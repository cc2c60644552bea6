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

// Chen 2019, eqs. 26, 27, 29: the factors of an epoch.
Channels printed_factors(const RandomMeasurement& c, double k0, double k1) {
    const Matrix<kChannels> P_v = c.S();
    if ((c.residual.cwiseAbs2() - 9.0 * P_v.diagonal()).maxCoeff() <= 0.0) {
        return Channels::Ones();
    }
    Channels lambda;
    for (int i = 0; i < kChannels; ++i) {
        double others = 0.0;
        for (int j = 0; j < kChannels; ++j) {
            others += j == i ? 0.0 : std::abs(c.residual(j)) / (kChannels - 1);
        }
        const double d = std::abs(c.residual(i) / others);
        lambda(i) = 1.0;
        if (d > k0) {
            lambda(i) = d * (k1 - k0) * (k1 - k0) / (k0 * (k1 - d) * (k1 - d));
        }
        if (d > k1) {
            lambda(i) = 0.0;
        }
    }
    return lambda;
}

Igg<kStates> printed_igg() {
    Igg<kStates> igg;
    igg.form = Igg<kStates>::Form::printed;
    return igg;
}

TEST_P(IggCorrector, PrintedScalesTheCovarianceOfTheInnovationAsInChen2019) {
    RandomCovariance random(GetParam());
    Igg<kStates> igg = printed_igg();
    int suspects = 0;
    int gross = 0;
    for (int i = 0; i < 600; ++i) {
        const RandomMeasurement c(random, 3.0);
        const Channels lambda = printed_factors(c, igg.k0, igg.k1);
        const auto innovation = c.innovation();
        const Channels S = (innovation.spread + innovation.noise).diagonal();
        Channels R = lambda.cwiseProduct(S) - innovation.spread.diagonal();
        R = R.cwiseMax(1e-6 * c.R);  // nothing is left of the noise
        const DenseUpdate expected(c.P, c.H, R, c.residual, {0, 1, 2});
        const auto correction = igg.correct(c.P, innovation);
        EXPECT_LT((correction.noise.diagonal() - R).cwiseQuotient(R).norm(), 1e-9);
        EXPECT_LT((correction.deviation - expected.deviation).norm(), 1e-6 * expected.deviation.norm());
        EXPECT_LT(relative_difference(correction.covariance, expected.covariance), 1e-6);
        EXPECT_LT((correction.weight - c.R.cwiseQuotient(R).cwiseMin(1.0)).norm(), 1e-9);
        suspects += (lambda.array() > 1.0).any() ? 1 : 0;
        gross += (lambda.array() == 0.0).any() ? 1 : 0;
    }
    EXPECT_GT(suspects, 30);
    EXPECT_GT(gross, 10);
}

TEST_P(IggCorrector, PrintedTakesAGrossErrorAtItsWord) {
    // One channel is 100 sigma off: the corrected form removes it, the printed one leaves none of it in the
    // residual of the posterior.
    RandomCovariance random(GetParam());
    for (int i = 0; i < 50; ++i) {
        RandomMeasurement c(random, 1.0);
        const auto sound = Standard().correct(c.P, c.innovation());
        const Channels S = (c.innovation().spread + c.innovation().noise).diagonal();
        c.residual(1) += 100.0 * std::sqrt(S(1));
        const auto corrected = Igg<kStates>().correct(c.P, c.innovation());
        const auto printed = printed_igg().correct(c.P, c.innovation());
        EXPECT_EQ(corrected.weight(1), 0.0);
        EXPECT_EQ(printed.weight(1), 1.0);
        const auto left = [&](const Vector<kStates>& deviation) {
            return std::abs(c.residual(1) - c.H.row(1) * deviation);
        };
        EXPECT_LT(left(printed.deviation), 1e-3 * std::abs(c.residual(1)));
        EXPECT_GT(left(corrected.deviation), 0.9 * std::abs(c.residual(1)));
        EXPECT_GT((printed.deviation - sound.deviation).norm(),
                  10.0 * (corrected.deviation - sound.deviation).norm());
    }
}

TEST_P(IggCorrector, PrintedDependsOnTheUnits) {
    // Metres and metres per second make one mean: the same velocity in millimetres per second gets other
    // factors. Beyond eq. 26 nothing of the corrected form changes.
    RandomCovariance random(GetParam());
    int changed = 0;
    for (int i = 0; i < 50; ++i) {
        RandomMeasurement c(random, 5.0);
        RandomMeasurement in_millimetres = c;
        in_millimetres.H.row(2) *= 1e3;
        in_millimetres.R(2) *= 1e6;
        in_millimetres.residual(2) *= 1e3;
        const auto printed = printed_igg().correct(c.P, c.innovation());
        const auto other = printed_igg().correct(c.P, in_millimetres.innovation());
        changed += (printed.weight - other.weight).norm() > 1e-6 ? 1 : 0;
        const Channels weight = Igg<kStates>().correct(c.P, c.innovation()).weight;
        EXPECT_LT((Igg<kStates>().correct(c.P, in_millimetres.innovation()).weight - weight).norm(), 1e-9);
    }
    EXPECT_GT(changed, 5);
}

TEST(IggPrinted, WithOneChannelIsTheStandardUpdate) {
    Igg<1> igg;
    igg.form = Igg<1>::Form::printed;
    const auto innovation =
        innovation_of<1, 1>(Matrix<1>(3.0), Matrix<1>(1.0), Matrix<1>(1.0), Vector<1>(40.0));
    EXPECT_EQ(igg.correct(Matrix<1>(3.0), innovation).deviation(0),
              Standard().correct(Matrix<1>(3.0), innovation).deviation(0));
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
