#include "plant/gnss_receiver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "plant/fix_queue.hpp"

namespace truenorth::plant {
namespace {

constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million

Fix truth(double time) { return {time, {0.9, -1.2, 35.0}, {1.0, 2.0, 3.0}}; }

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

TEST_P(ReceiverOfSeed, OutliersComeWithTheirProbabilityAndSize) {
    GnssReceiver::Errors errors;
    errors.velocity_outliers = {0.05, 2.0};
    errors.position_outliers = {0.2, 50.0};
    const GnssReceiver receiver(errors, GetParam());
    constexpr int count = 20000;
    int velocity_outliers = 0;
    int position_outliers = 0;
    int both = 0;
    Eigen::Vector3d signs = Eigen::Vector3d::Zero();
    for (std::uint64_t k = 1; k <= count; ++k) {
        const Fix fix = receiver.measure(k, truth(0.0));
        const bool velocity_is_off = velocity_error(fix).norm() > 0.0;
        const bool position_is_off = position_error(fix).norm() > 0.0;
        if (velocity_is_off) {
            ASSERT_LT((velocity_error(fix).cwiseAbs() - Eigen::Vector3d::Constant(2.0)).norm(), 1e-12);
            signs += velocity_error(fix).cwiseSign();
        }
        if (position_is_off) {
            ASSERT_LT((position_error(fix).cwiseAbs() - Eigen::Vector3d::Constant(50.0)).norm(), 1e-6);
        }
        velocity_outliers += velocity_is_off ? 1 : 0;
        position_outliers += position_is_off ? 1 : 0;
        both += velocity_is_off && position_is_off ? 1 : 0;
    }
    const auto rate = [](int number) { return static_cast<double>(number) / count; };
    const auto bound = [](double probability) {
        return kSigmas * std::sqrt(probability * (1.0 - probability) / count);
    };
    EXPECT_NEAR(rate(velocity_outliers), 0.05, bound(0.05));
    EXPECT_NEAR(rate(position_outliers), 0.2, bound(0.2));
    EXPECT_NEAR(rate(both), 0.01, bound(0.01));  // independent
    EXPECT_LT(signs.cwiseAbs().maxCoeff(), kSigmas * std::sqrt(velocity_outliers));
}

INSTANTIATE_TEST_SUITE_P(Seeds, ReceiverOfSeed, testing::Values(1U, 2U, 3U));

TEST(GnssReceiver, OutliersLeaveTheNoiseAsItWas) {
    GnssReceiver::Errors errors;
    errors.velocity_sigma = {0.1, 0.1, 0.1};
    errors.position_sigma = {5.0, 5.0, 5.0};
    const GnssReceiver clean(errors, 1);
    errors.velocity_outliers = {1.0, 2.0};
    const GnssReceiver dirty(errors, 1);
    for (std::uint64_t k = 1; k <= 100; ++k) {
        const Eigen::Vector3d difference =
            velocity_error(dirty.measure(k, truth(0.0))) - velocity_error(clean.measure(k, truth(0.0)));
        EXPECT_LT((difference.cwiseAbs() - Eigen::Vector3d::Constant(2.0)).norm(), 1e-12);
        EXPECT_EQ(position_error(dirty.measure(k, truth(0.0))), position_error(clean.measure(k, truth(0.0))));
    }
}

// Jing 2023, eq. 21.
TEST(GnssReceiver, TheNoiseFollowsItsProfile) {
    const NoiseScale jing{6.0, {600.0, 1200.0}, 9.0, 1200.0, {2400.0, 3000.0}};
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
    errors.outages[0] = {10.0, 20.0};
    errors.outages[3] = {30.0, 31.0};
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
