#include "estimation/huber.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "estimation/random_measurement.hpp"

namespace truenorth {
namespace {

constexpr double kLimit = 1.345;

Huber converged() {
    Huber huber;
    huber.iterations = 2000;
    return huber;
}

class HuberCorrector : public testing::TestWithParam<unsigned> {};

// Where the derivative of the cost is zero, written down with H and without weights.
TEST_P(HuberCorrector, MinimisesHubersCost) {
    RandomCovariance random(GetParam());
    int beyond = 0;
    for (int i = 0; i < 100; ++i) {
        const RandomMeasurement c(random, 4.0);
        const auto correction = converged().correct(c.P, c.innovation());
        const Channels sigma = c.R.cwiseSqrt();
        const Channels u = (c.residual - c.H * correction.deviation).cwiseQuotient(sigma);
        const Channels psi = u.cwiseMax(-kLimit).cwiseMin(kLimit).cwiseQuotient(sigma);
        const Vector<kStates> expected = c.P * c.H.transpose() * psi;
        EXPECT_LT((correction.deviation - expected).norm(), 1e-6 * (1e-3 + expected.norm()));
        beyond += static_cast<int>((u.array().abs() > kLimit + 1e-6).count());
    }
    EXPECT_GT(beyond, 30);
}

TEST_P(HuberCorrector, WeighsByTheResidualThatItLeaves) {
    RandomCovariance random(GetParam());
    for (int i = 0; i < 100; ++i) {
        const RandomMeasurement c(random, 4.0);
        const auto correction = converged().correct(c.P, c.innovation());
        const Channels u = (c.residual - c.H * correction.deviation).cwiseQuotient(c.R.cwiseSqrt());
        for (int j = 0; j < kChannels; ++j) {
            const double expected = std::min(1.0, kLimit / std::abs(u(j)));
            EXPECT_NEAR(correction.weight(j), expected, 1e-5);
            EXPECT_NEAR(correction.noise(j, j), c.R(j) / expected, 1e-4 * c.R(j) / expected);
        }
    }
}

// A gross error in one channel moves the estimate no farther when it grows.
TEST_P(HuberCorrector, BoundsWhatAnOutlierMoves) {
    RandomCovariance random(GetParam());
    for (int i = 0; i < 20; ++i) {
        const RandomMeasurement c(random, 1.0);
        auto innovation = c.innovation();
        const double sigma = std::sqrt(innovation.spread(0, 0) + innovation.noise(0, 0));
        innovation.residual(0) = 1e3 * sigma;
        const auto large = converged().correct(c.P, innovation);
        innovation.residual(0) = 1e6 * sigma;
        const auto huge = converged().correct(c.P, innovation);
        EXPECT_LT((huge.deviation - large.deviation).norm(), 0.01 * large.deviation.norm());
        EXPECT_GT(huge.weight(0), 0.0);
    }
}

// Of a constant that `count` measurements tell, the variance of Huber's estimate is E psi^2 / (E psi')^2 /
// count (Huber 1964): 5 % more than that of the mean where noise is Gaussian, and 0.13 of it where one
// measurement in ten has ten times the sigma. The bounds are 4 sigmas of a variance of 3,000 runs, and 1 %
// for their number.
TEST_P(HuberCorrector, HasTheVarianceOfHubersEstimate) {
    constexpr int count = 40;
    constexpr int runs = 3'000;
    std::mt19937 generator(GetParam());
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    Innovation<1, count> innovation;
    const Matrix<1> P(1e6);
    innovation.spread.setConstant(P(0));
    innovation.cross.setConstant(P(0));
    innovation.noise.setIdentity();
    Huber huber;
    huber.iterations = 8;
    const auto variance_of = [&](double share) {
        double sum = 0.0;
        for (int run = 0; run < runs; ++run) {
            for (double& residual : innovation.residual) {
                residual = normal(generator) * (uniform(generator) < share ? 10.0 : 1.0);
            }
            const double estimate = huber.correct(P, innovation).deviation(0);
            sum += estimate * estimate;
        }
        return count * sum / runs;
    };
    const auto inside = [](double k) { return std::erf(k / std::sqrt(2.0)); };  // P(|u| < k)
    const auto square = [&](double k, double scale) {  // E psi^2 for noise of `scale`
        const double q = k / scale;
        const double density = std::exp(-0.5 * q * q) / std::sqrt(2.0 * std::numbers::pi);
        return scale * scale * (inside(q) - 2.0 * q * density) + k * k * (1.0 - inside(q));
    };
    for (const double share : {0.0, 0.1}) {
        const double slope = (1.0 - share) * inside(kLimit) + share * inside(kLimit / 10.0);
        const double expected =
            ((1.0 - share) * square(kLimit, 1.0) + share * square(kLimit, 10.0)) / (slope * slope);
        EXPECT_NEAR(variance_of(share) / expected, 1.0, 4.0 * std::sqrt(2.0 / runs) + 0.01) << share;
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, HuberCorrector, testing::Values(1U, 20261130U));

}  // namespace
}  // namespace truenorth
