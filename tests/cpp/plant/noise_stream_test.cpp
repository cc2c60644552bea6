#include "plant/noise_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace truenorth::plant {
namespace {

constexpr int kCount = 100000;
constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million

class NoiseStreamOfSeed : public testing::TestWithParam<std::uint32_t> {};

TEST_P(NoiseStreamOfSeed, NormalNumbersHaveTheMomentsOfTheNormalDistribution) {
    const NoiseStream stream(GetParam(), NoiseSource::gyro_white);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Vector3d fourth = Eigen::Vector3d::Zero();
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (int k = 0; k < kCount; ++k) {
        const Eigen::Vector3d x = stream.normal(static_cast<std::uint64_t>(k));
        sum += x;
        products += x * x.transpose();
        fourth += x.array().pow(4).matrix();
    }
    // Sigmas of the estimates for N(0, 1): mean 1, variance sqrt(2), covariance 1, fourth moment sqrt(96); /
    // sqrt(n).
    const double bound = kSigmas / std::sqrt(kCount);
    const Eigen::Matrix3d covariance = products / kCount;
    const Eigen::Matrix3d off_diagonal = covariance - Eigen::Matrix3d(covariance.diagonal().asDiagonal());
    EXPECT_LT((sum / kCount).cwiseAbs().maxCoeff(), bound);
    EXPECT_LT((covariance.diagonal().array() - 1.0).abs().maxCoeff(), bound * std::sqrt(2.0));
    EXPECT_LT(off_diagonal.cwiseAbs().maxCoeff(), bound);
    EXPECT_LT((fourth.array() / kCount - 3.0).abs().maxCoeff(), bound * std::sqrt(96.0));
}

TEST_P(NoiseStreamOfSeed, UniformNumbersFillTheUnitInterval) {
    const NoiseStream stream(GetParam(), NoiseSource::gnss_position_outlier);
    Eigen::Matrix<int, 4, 10> histogram = Eigen::Matrix<int, 4, 10>::Zero();
    for (int k = 0; k < kCount; ++k) {
        const Eigen::Vector4d u = stream.uniform(static_cast<std::uint64_t>(k));
        ASSERT_GT(u.minCoeff(), 0.0);
        ASSERT_LT(u.maxCoeff(), 1.0);
        for (int i = 0; i < 4; ++i) {
            ++histogram(i, static_cast<int>(10.0 * u[i]));
        }
    }
    const double expected = kCount / 10.0;
    EXPECT_LT((histogram.cast<double>().array() - expected).abs().maxCoeff(),
              kSigmas * std::sqrt(0.9 * expected));
}

TEST_P(NoiseStreamOfSeed, NeighbouringSamplesSourcesAndSeedsAreUncorrelated) {
    const std::uint32_t seed = GetParam();
    const NoiseStream stream(seed, NoiseSource::gyro_white);
    const NoiseStream other_source(seed, NoiseSource::gyro_markov);
    const NoiseStream other_seed(seed + 1, NoiseSource::gyro_white);
    double next = 0.0;
    double source = 0.0;
    double neighbour = 0.0;
    for (std::uint64_t k = 0; k < kCount; ++k) {
        const double x = stream.normal(k).x();
        next += x * stream.normal(k + 1).x();
        source += x * other_source.normal(k).x();
        neighbour += x * other_seed.normal(k).x();
    }
    const double bound = kSigmas * std::sqrt(kCount);
    EXPECT_NEAR(next, 0.0, bound);
    EXPECT_NEAR(source, 0.0, bound);
    EXPECT_NEAR(neighbour, 0.0, bound);
}

INSTANTIATE_TEST_SUITE_P(Seeds, NoiseStreamOfSeed, testing::Values(0U, 1U, 20111115U, 0x7FFFFFFFU));

TEST_P(NoiseStreamOfSeed, NormalNumbersAreThoseOfBoxAndMuller) {
    const NoiseStream stream(GetParam(), NoiseSource::gyro_white);
    for (std::uint64_t k = 0; k < 20000; ++k) {
        const Eigen::Vector4d u = stream.uniform(k);
        const double radius_0 = std::sqrt(-2.0 * std::log(u[0]));
        const double radius_1 = std::sqrt(-2.0 * std::log(u[2]));
        const double turn = 2.0 * std::numbers::pi;
        const Eigen::Vector3d expected(radius_0 * std::cos(turn * u[1]), radius_0 * std::sin(turn * u[1]),
                                       radius_1 * std::cos(turn * u[3]));
        ASSERT_LT((stream.normal(k) - expected).cwiseAbs().maxCoeff(), 4e-15) << k;
    }
}

TEST(NoiseStream, DrawsBeyondThirtyTwoBitsDiffer) {
    const NoiseStream stream(1, NoiseSource::gyro_white);
    EXPECT_NE(stream.uniform(5), stream.uniform(5 + (std::uint64_t{1} << 32U)));
}

}  // namespace
}  // namespace truenorth::plant
