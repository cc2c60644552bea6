#include "plant/gnss_receiver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "plant/fix_queue.hpp"

namespace truenorth::plant {
namespace {

constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million

Fix truth(double time) {
    return {
        .time = time,
        .position = {.latitude = 0.9, .longitude = -1.2, .height = 35.0},
        .velocity = {1.0, 2.0, 3.0},
    };
}

Eigen::Vector3d position_error(const Fix& fix) {
    return earth::displacement(truth(0.0).position, fix.position);
}
Eigen::Vector3d velocity_error(const Fix& fix) { return fix.velocity - truth(0.0).velocity; }

class ReceiverOfSeed : public testing::TestWithParam<std::uint32_t> {};

TEST_P(ReceiverOfSeed, NoiseHasItsSigmas) {
    GnssReceiver::Errors errors;
    errors.position_sigma = {3.0, 4.0, 10.0};
    errors.velocity_sigma = {0.1, 0.2, 0.3};
    const GnssReceiver receiver(errors, GetParam());
    constexpr int count = 20000;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d cross = Eigen::Vector3d::Zero();
    for (std::uint64_t k = 1; k <= count; ++k) {
        const Fix fix = receiver.measure(k, truth(0.0));
        const Eigen::Vector3d p = position_error(fix).cwiseQuotient(errors.position_sigma);
        const Eigen::Vector3d v = velocity_error(fix).cwiseQuotient(errors.velocity_sigma);
        position += p.cwiseAbs2();
        velocity += v.cwiseAbs2();
        cross += p.cwiseProduct(v);
    }
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(position[i] / count, 1.0, kSigmas * std::sqrt(2.0 / count));
        EXPECT_NEAR(velocity[i] / count, 1.0, kSigmas * std::sqrt(2.0 / count));
        EXPECT_NEAR(cross[i] / count, 0.0, kSigmas / std::sqrt(count));
    }
}

TEST_P(ReceiverOfSeed, OutliersComeWithTheirProbability) {
    GnssReceiver::Errors errors;
    errors.velocity_outliers = {.probability = 0.05, .size = 2.0};
    errors.position_outliers = {.probability = 0.2, .size = 50.0};
    const GnssReceiver receiver(errors, GetParam());
    constexpr int count = 20000;
    Eigen::Array3i found = Eigen::Array3i::Zero();  // of the velocity, of the position, of both in one fix
    for (std::uint64_t k = 1; k <= count; ++k) {
        const Fix fix = receiver.measure(k, truth(0.0));
        const int velocity = velocity_error(fix).norm() > 0.0 ? 1 : 0;
        const int position = position_error(fix).norm() > 0.0 ? 1 : 0;
        found += Eigen::Array3i(velocity, position, velocity * position);
    }
    const Eigen::Array3d probability(0.05, 0.2, 0.05 * 0.2);
    const Eigen::Array3d sigma = (probability * (1.0 - probability) / count).sqrt();
    EXPECT_LT(((found.cast<double>() / count - probability) / sigma).abs().maxCoeff(), kSigmas);
}

TEST_P(ReceiverOfSeed, OutliersHaveTheirSizeAndRandomSigns) {
    GnssReceiver::Errors errors;
    errors.velocity_outliers = {.probability = 1.0, .size = 2.0};
    errors.position_outliers = {.probability = 1.0, .size = 50.0};
    const GnssReceiver receiver(errors, GetParam());
    constexpr int count = 20000;
    Eigen::Vector3d signs = Eigen::Vector3d::Zero();
    Eigen::Vector3d products = Eigen::Vector3d::Zero();
    for (std::uint64_t k = 1; k <= count; ++k) {
        const Fix fix = receiver.measure(k, truth(0.0));
        const Eigen::Vector3d sign = 0.5 * velocity_error(fix);
        ASSERT_LT((sign.cwiseAbs() - Eigen::Vector3d::Ones()).norm(), 1e-12);
        ASSERT_LT((position_error(fix).cwiseAbs() / 50.0 - Eigen::Vector3d::Ones()).norm(), 1e-8);
        signs += sign;
        products += Eigen::Vector3d(sign.x() * sign.y(), sign.y() * sign.z(), sign.z() * sign.x());
    }
    EXPECT_LT(signs.cwiseAbs().maxCoeff(), kSigmas * std::sqrt(count));
    EXPECT_LT(products.cwiseAbs().maxCoeff(), kSigmas * std::sqrt(count));
}

INSTANTIATE_TEST_SUITE_P(Seeds, ReceiverOfSeed, testing::Values(1U, 2U, 3U));

TEST(GnssReceiver, OutliersLeaveTheNoiseAsItWas) {
    GnssReceiver::Errors errors;
    errors.velocity_sigma = {0.1, 0.1, 0.1};
    errors.position_sigma = {5.0, 5.0, 5.0};
    const GnssReceiver clean(errors, 1);
    errors.velocity_outliers = {.probability = 1.0, .size = 2.0};
    const GnssReceiver dirty(errors, 1);
    for (std::uint64_t k = 1; k <= 100; ++k) {
        const Eigen::Vector3d difference =
            velocity_error(dirty.measure(k, truth(0.0))) - velocity_error(clean.measure(k, truth(0.0)));
        EXPECT_LT((difference.cwiseAbs() - Eigen::Vector3d::Constant(2.0)).norm(), 1e-12);
        EXPECT_EQ(position_error(dirty.measure(k, truth(0.0))), position_error(clean.measure(k, truth(0.0))));
    }
}

TEST(GnssReceiver, AnOutlierEpochIsCountedInSigmasAndLeavesTheNoiseAsItWas) {
    GnssReceiver::Errors errors;
    errors.position_sigma = {3.0, 4.0, 10.0};
    errors.velocity_sigma = {0.1, 0.2, 0.3};
    errors.noise_scale = {.step_factor = 2.0, .step = {.begin = 0.0, .end = 1.0}, .sine = {}};
    const GnssReceiver clean(errors, 1);
    errors.outlier_epochs = {.probability = 1.0, .channel_probability = 1.0, .least = 20.0, .largest = 20.0};
    const GnssReceiver dirty(errors, 1);
    for (std::uint64_t k = 1; k <= 100; ++k) {
        const Fix one = clean.measure(k, truth(0.0));
        const Fix other = dirty.measure(k, truth(0.0));
        const Eigen::Vector3d position = position_error(other) - position_error(one);
        const Eigen::Vector3d velocity = velocity_error(other) - velocity_error(one);
        EXPECT_LT((position.cwiseAbs() - 40.0 * errors.position_sigma).norm(), 1e-6);
        EXPECT_LT((velocity.cwiseAbs() - 40.0 * errors.velocity_sigma).norm(), 1e-12);
    }
}

// Jing 2023, eq. 21.
TEST(GnssReceiver, TheNoiseFollowsItsProfile) {
    const NoiseScale jing{
        .step_factor = 6.0,
        .step = {.begin = 600.0, .end = 1200.0},
        .sine_amplitude = 9.0,
        .sine_period = 1200.0,
        .sine = {.begin = 2400.0, .end = 3000.0},
    };
    EXPECT_EQ(jing.at(599.0), 1.0);
    EXPECT_EQ(jing.at(600.0), 6.0);
    EXPECT_EQ(jing.at(1199.0), 6.0);
    EXPECT_EQ(jing.at(1200.0), 1.0);
    EXPECT_EQ(jing.at(2400.0), 1.0);
    EXPECT_NEAR(jing.at(2500.0), 5.5, 1e-12);
    EXPECT_NEAR(jing.at(2700.0), 10.0, 1e-12);
    EXPECT_EQ(jing.at(3000.0), 1.0);

    GnssReceiver::Errors errors;
    errors.position_sigma = {1.0, 1.0, 1.0};
    errors.velocity_sigma = {1.0, 1.0, 1.0};
    errors.noise_scale = jing;
    const GnssReceiver receiver(errors, 1);
    const Fix calm = receiver.measure(5, truth(0.0));
    const Fix loud = receiver.measure(5, truth(700.0));
    EXPECT_LT((velocity_error(loud) - 6.0 * velocity_error(calm)).norm(), 1e-12);
    EXPECT_LT((position_error(loud) - 6.0 * position_error(calm)).norm(), 1e-6);
}

TEST(GnssReceiver, FixesAreLostInOutagesAlone) {
    GnssReceiver::Errors errors;
    errors.outages[0] = {.begin = 10.0, .end = 20.0};
    errors.outages[3] = {.begin = 30.0, .end = 31.0};
    const GnssReceiver receiver(errors, 1);
    EXPECT_FALSE(receiver.lost(0.0));  // unused outages begin and end at 0
    EXPECT_FALSE(receiver.lost(9.0));
    EXPECT_TRUE(receiver.lost(10.0));
    EXPECT_TRUE(receiver.lost(19.0));
    EXPECT_FALSE(receiver.lost(20.0));
    EXPECT_TRUE(receiver.lost(30.5));
}

TEST(FixQueue, FixesComeOutInOrderAndWhenTheyAreDue) {
    FixQueue queue;
    for (std::uint64_t k = 0; k < 100; ++k) {
        EXPECT_EQ(queue.due(k), k >= 30);
        if (k >= 30) {
            EXPECT_EQ(queue.pop().time, static_cast<double>(k - 30));
            EXPECT_FALSE(queue.due(k));
        }
        queue.push(truth(static_cast<double>(k)), k + 30);
    }
}

TEST(FixQueue, HoldsItsCapacity) {
    FixQueue queue;
    for (std::size_t k = 0; k < FixQueue::kCapacity; ++k) {
        queue.push(truth(static_cast<double>(k)), 7);
    }
    for (std::size_t k = 0; k < FixQueue::kCapacity; ++k) {
        ASSERT_TRUE(queue.due(7));
        EXPECT_EQ(queue.pop().time, static_cast<double>(k));
    }
    EXPECT_FALSE(queue.due(7));
}

}  // namespace
}  // namespace truenorth::plant
