#include "plant/outliers.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace truenorth::plant {
namespace {

constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million

class OutlierEpochsOfSeed : public testing::TestWithParam<std::uint32_t> {
  protected:
    NoiseStream stream_{GetParam(), NoiseSource::gnss_outlier_epoch};
};

// A fix is affected when it is an outlier epoch and at least one of its six components is off.
TEST_P(OutlierEpochsOfSeed, ComeWithTheirProbabilities) {
    const OutlierEpochs outliers{
        .probability = 0.03, .channel_probability = 0.5, .least = 10.0, .largest = 50.0};
    constexpr int count = 100000;
    int fixes = 0;
    Eigen::Array<double, 6, 1> components = Eigen::Array<double, 6, 1>::Zero();
    for (std::uint64_t fix = 1; fix <= count; ++fix) {
        const Eigen::Array<double, 6, 1> off = (outliers.draw(stream_, fix).array() != 0.0).cast<double>();
        fixes += off.sum() > 0.0 ? 1 : 0;
        components += off;
    }
    const double fix_rate = 0.03 * (1.0 - std::pow(0.5, 6));
    EXPECT_NEAR(fixes / double{count}, fix_rate, kSigmas * std::sqrt(fix_rate / count));
    for (const double rate : components / count) {
        EXPECT_NEAR(rate, 0.015, kSigmas * std::sqrt(0.015 / count));
    }
}

TEST_P(OutlierEpochsOfSeed, AreUniformBetweenTheirLimitsWithRandomSigns) {
    const OutlierEpochs outliers{
        .probability = 1.0, .channel_probability = 1.0, .least = 10.0, .largest = 50.0};
    constexpr int count = 20000;
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    Vector6 sum = Vector6::Zero();
    Vector6 magnitude = Vector6::Zero();
    Eigen::Matrix<double, 6, 6> products = Eigen::Matrix<double, 6, 6>::Zero();
    for (std::uint64_t fix = 1; fix <= count; ++fix) {
        const Vector6 error = outliers.draw(stream_, fix);
        ASSERT_GE(error.cwiseAbs().minCoeff(), 10.0);
        ASSERT_LE(error.cwiseAbs().maxCoeff(), 50.0);
        sum += error;
        magnitude += error.cwiseAbs();
        products += error * error.transpose();
    }
    const double mean_square = (50.0 * 50.0 * 50.0 - 10.0 * 10.0 * 10.0) / 3.0 / 40.0;
    const double spread = 40.0 / std::sqrt(12.0);
    // Variance of the square of U(10, 50): E u^4 - (E u^2)^2.
    const double square_variance =
        (std::pow(50.0, 5) - std::pow(10.0, 5)) / 5.0 / 40.0 - mean_square * mean_square;
    for (int i = 0; i < 6; ++i) {
        EXPECT_NEAR(sum[i] / count, 0.0, kSigmas * std::sqrt(mean_square / count));
        EXPECT_NEAR(magnitude[i] / count, 30.0, kSigmas * spread / std::sqrt(count));
        for (int j = 0; j < 6; ++j) {
            const double expected = i == j ? mean_square : 0.0;
            const double variance = i == j ? square_variance : mean_square * mean_square;
            EXPECT_NEAR(products(i, j) / count, expected, kSigmas * std::sqrt(variance / count));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, OutlierEpochsOfSeed, testing::Values(1U, 2U));

}  // namespace
}  // namespace truenorth::plant
