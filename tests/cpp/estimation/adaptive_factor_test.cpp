#include "estimation/adaptive_factor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/random_measurement.hpp"

namespace truenorth {
namespace {

class AdaptiveCorrector : public testing::TestWithParam<unsigned> {
  protected:
    // Li, eqs. 15-17 with P for the misprinted P_k, given alpha.
    static void expect_update(const RandomMeasurement& c, double alpha, AdaptiveFactor<kStates>::Form form) {
        const auto correction = AdaptiveFactor<kStates>{{.form = form}}.correct(c.P, c.innovation());
        EXPECT_TRUE(is_sound(correction));
        EXPECT_NEAR(correction.alpha, alpha, 1e-13);
        const DenseUpdate expected(c.P / alpha, c.H, c.R, c.residual, {0, 1, 2});
        EXPECT_LT(relative_difference(correction.deviation, expected.deviation), 1e-10);
        EXPECT_LT(relative_difference(correction.covariance, expected.covariance), 1e-10);
        EXPECT_EQ(correction.noise, Matrix<kChannels>(c.R.asDiagonal()));
        EXPECT_EQ(correction.weight, Channels::Ones());
    }
};

TEST_P(AdaptiveCorrector, UnitFreeComparesStandardisedSquares) {
    RandomCovariance random(GetParam());
    int fired = 0;
    for (int i = 0; i < 200; ++i) {
        const RandomMeasurement c(random, 1.5);
        const Matrix<kChannels> S = c.S();
        double sum = 0.0;
        for (int j = 0; j < kChannels; ++j) {
            sum += c.residual(j) * c.residual(j) / S(j, j);
        }
        const double alpha = sum > 6.3 ? 6.3 / sum : 1.0;
        fired += alpha < 1.0 ? 1 : 0;
        expect_update(c, alpha, AdaptiveFactor<kStates>::Form::unit_free);
    }
    EXPECT_GT(fired, 20);
    EXPECT_LT(fired, 180);
}

TEST_P(AdaptiveCorrector, PrintedComparesTraces) {
    RandomCovariance random(GetParam());
    int fired = 0;
    for (int i = 0; i < 200; ++i) {
        const RandomMeasurement c(random, 1.0);
        const Matrix<kChannels> S = c.S();
        const double trace = (c.residual * c.residual.transpose()).trace();
        const double alpha = trace > S.trace() ? S.trace() / trace : 1.0;
        fired += alpha < 1.0 ? 1 : 0;
        expect_update(c, alpha, AdaptiveFactor<kStates>::Form::printed);
    }
    EXPECT_GT(fired, 20);
    EXPECT_LT(fired, 180);
}

// Gross errors one after the other: no sigma is left beyond the widest, and alpha has a floor.
TEST_P(AdaptiveCorrector, KeepsTheCovarianceWhateverTheInnovation) {
    RandomCovariance random(GetParam());
    AdaptiveFactor<kStates> factor;
    const Prior start = random.covariance<kStates>(0.05, 5.0);
    factor.widest = 1e3 * start.diagonal().cwiseSqrt();
    Prior P = start;
    for (int i = 0; i < 200; ++i) {
        RandomMeasurement c(random, 1.0);
        const auto innovation = innovation_of<kStates, kChannels>(P, c.H, c.R.asDiagonal(), 1e9 * c.residual);
        const auto correction = factor.correct(P, innovation);
        EXPECT_LE(correction.covariance.diagonal().cwiseQuotient(factor.widest.cwiseAbs2()).maxCoeff(),
                  1.0 + 1e-12);
        EXPECT_EQ(correction.alpha, 1e-6);
        EXPECT_TRUE(is_sound(correction)) << i;
        P = correction.covariance + 1e-3 * start;
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AdaptiveCorrector, testing::Values(71U, 7171U));

TEST(AdaptiveFactorOfAbsentChannels, DoesNotCountThem) {
    for (const auto form :
         {AdaptiveFactor<kStates>::Form::unit_free, AdaptiveFactor<kStates>::Form::printed}) {
        RandomCovariance random(72);
        const RandomMeasurement c(random, 4.0);
        auto innovation = c.innovation();
        innovation.remove(1);
        innovation.remove(2);
        const double S = c.H.row(0) * c.P * c.H.row(0).transpose() + c.R(0);
        const double limit = form == AdaptiveFactor<kStates>::Form::printed ? 1.0 : 2.1;
        innovation.residual(0) = std::sqrt(10.0 * S);
        const auto correction = AdaptiveFactor<kStates>{{.form = form}}.correct(c.P, innovation);
        EXPECT_NEAR(correction.alpha, limit / 10.0, 1e-14);
        EXPECT_EQ(correction.weight, Channels(1.0, 0.0, 0.0));
    }
}

// Share of clean epochs of a loose filter in which the factor fires: positions of 10 m, velocities of 0.2 m/s
// (Li's GNSS), the prediction much better than the measurement.
double firing_rate(AdaptiveFactor<6>::Form form, double metre, unsigned seed) {
    constexpr int epochs = 20000;
    RandomCovariance random(seed);
    Vector<6> sigma;
    sigma << Vector<3>::Constant(10.0 * metre), Vector<3>::Constant(0.2);
    const Matrix<6> R = sigma.cwiseAbs2().asDiagonal();
    int fired = 0;
    for (int i = 0; i < epochs; ++i) {
        const Innovation<6, 6> innovation{.residual = sigma.cwiseProduct(random.normal<6, 1>()),
                                          .spread = 1e-6 * R,
                                          .noise = R,
                                          .cross = 1e-6 * R};
        fired +=
            AdaptiveFactor<6>{{.form = form}}.correct(Matrix<6>(1e-6 * R), innovation).alpha < 1.0 ? 1 : 0;
    }
    return static_cast<double>(fired) / epochs;
}

TEST(AdaptiveFactorInCleanEpochs, PrintedFiresInMoreThanAThirdAndDependsOnUnits) {
    // In metres the three positions alone count: P(chi-square_3 > 3) = 0.3916. In units of 50 m, in which
    // they are as large as the velocities, all six do: P(chi-square_6 > 6) = 0.4232. The unit-free form has
    // P(chi-square_6 > 12.6) = 0.0498 in any unit. Four standard deviations of a share of 20000 epochs.
    using Form = AdaptiveFactor<6>::Form;
    for (const unsigned seed : {73U, 74U}) {
        EXPECT_NEAR(firing_rate(Form::printed, 1.0, seed), 0.3916, 4.0 * 0.0035);
        EXPECT_NEAR(firing_rate(Form::printed, 0.02, seed), 0.4232, 4.0 * 0.0035);
        // P(chi-square_6 > 12.6) = 0.0498, in any unit.
        EXPECT_NEAR(firing_rate(Form::unit_free, 1.0, seed), 0.0498, 4.0 * 0.0016);
        EXPECT_NEAR(firing_rate(Form::unit_free, 1e3, seed), 0.0498, 4.0 * 0.0016);
    }
}

}  // namespace
}  // namespace truenorth
