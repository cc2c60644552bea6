#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "estimation/example_models.hpp"
#include "estimation/innovation_gate.hpp"
#include "estimation/random_measurement.hpp"
#include "estimation/standard.hpp"

namespace truenorth {
namespace {

TEST(Innovation, StandardisesEachChannelByItsOwnSigma) {
    RandomCovariance random(3);
    const RandomMeasurement c(random, 1.0);
    const Channels u = c.innovation().standardised();
    for (int i = 0; i < kChannels; ++i) {
        const double variance = c.H.row(i) * c.P * c.H.row(i).transpose() + c.R(i);
        EXPECT_NEAR(u(i), std::abs(c.residual(i)) / std::sqrt(variance), 1e-14);
    }
}

TEST(Innovation, ARemovedChannelHasNotBeenMeasured) {
    for (const unsigned seed : {51U, 52U}) {
        RandomCovariance random(seed);
        for (int i = 0; i < 50; ++i) {
            const RandomMeasurement c(random, 2.0);
            auto innovation = c.innovation();
            innovation.remove(1);
            const auto correction = Standard().correct(c.P, innovation);
            const DenseUpdate without(c.P, c.H, c.R, c.residual, {0, 2});
            EXPECT_LT(relative_difference(correction.deviation, without.deviation), 1e-11);
            EXPECT_LT(relative_difference(correction.covariance, without.covariance), 1e-12);
            EXPECT_EQ(correction.weight, Channels(1.0, 0.0, 1.0));
            EXPECT_TRUE(correction.used());

            const Eigen::Vector2d v(c.residual(0), c.residual(2));
            EXPECT_NEAR(nis(innovation), v.dot(without.S.inverse() * v), 1e-10 * nis(innovation));
            EXPECT_EQ(innovation.channels(), 2);
        }
    }
}

TEST(Innovation, WithoutChannelsChangesNothing) {
    RandomCovariance random(53);
    const RandomMeasurement c(random, 2.0);
    auto innovation = c.innovation();
    for (int i = 0; i < kChannels; ++i) {
        innovation.remove(i);
    }
    const auto correction = Standard().correct(c.P, innovation);
    EXPECT_EQ(correction.deviation, Vector<kStates>::Zero());
    EXPECT_EQ(correction.covariance, c.P);
    EXPECT_FALSE(correction.used());
    EXPECT_EQ(nis(innovation), 0.0);
}

TEST(Innovation, AsUsedHasTheCovarianceThatTheCorrectionBelieved) {
    for (const unsigned seed : {61U, 62U}) {
        RandomCovariance random(seed);
        const RandomMeasurement c(random, 2.0);
        const auto innovation = c.innovation();
        auto correction = Standard().correct(c.P, innovation);
        EXPECT_EQ(nis(as_used(innovation, correction)), nis(innovation));

        correction.alpha = 0.25;
        correction.noise *= 9.0;
        correction.weight(1) = 0.0;
        const auto used = as_used(innovation, correction);
        const DenseUpdate expected(4.0 * c.P, c.H, 9.0 * c.R, c.residual, {0, 2});
        const Eigen::Vector2d v(c.residual(0), c.residual(2));
        EXPECT_NEAR(nis(used), v.dot(expected.S.inverse() * v), 1e-10 * nis(used));
        EXPECT_EQ(used.channels(), 2);
    }
}

struct IntermittentModel : LinearModel<4> {
    struct Fix {
        Eigen::Vector2d value;
        Eigen::Array<bool, 2, 1> valid;
    };
    [[nodiscard]] static Eigen::Array<bool, 2, 1> present(const Fix& fix) { return fix.valid; }
    [[nodiscard]] static Eigen::Vector2d residual(const Vector<4>& x, const Fix& fix) {
        return fix.value - x.head<2>();
    }
    [[nodiscard]] static Matrix<2, 4> measurement_matrix(const Vector<4>& /*x*/, const Fix& fix) {
        Matrix<2, 4> H = Matrix<2, 4>::Identity();
        if (!fix.valid(0)) {
            H.row(0).setConstant(std::numeric_limits<double>::quiet_NaN());
        }
        return H;
    }
    [[nodiscard]] static Eigen::Matrix2d measurement_noise(const Vector<4>& /*x*/, const Fix& /*fix*/) {
        return Eigen::Vector2d(0.04, 0.09).asDiagonal();
    }
};
static_assert(IntermittentMeasurement<IntermittentModel>);
static_assert(!IntermittentMeasurement<LinearModel<4>>);

TEST(Innovation, NothingOfAnAbsentChannelMatters) {
    const IntermittentModel model;
    const Matrix<4> P = 4.0 * Matrix<4>::Identity();
    const auto innovation =
        innovate(model, Vector<4>::Zero(), P,
                 {.value = {std::numeric_limits<double>::quiet_NaN(), 1.0}, .valid = {false, true}});
    EXPECT_FALSE(innovation.present(0));
    EXPECT_TRUE(innovation.present(1));
    const auto correction = Standard().correct(P, innovation);
    EXPECT_NEAR(correction.deviation(1), 4.0 / 4.09, 1e-15);
    EXPECT_EQ(correction.deviation(0), 0.0);
    EXPECT_EQ(correction.covariance(0, 0), 4.0);
}

TEST(InnovationGate, HasOneConfidenceForAnyNumberOfChannels) {
    // Quantiles of chi-square at 1 - exp(-8) = 0.99966454, where two channels have 16 (scipy.stats.chi2.isf).
    const InnovationGate gate{{.enabled = true, .threshold = 16.0}};
    EXPECT_EQ(gate.threshold_for(2), 16.0);
    EXPECT_NEAR(gate.threshold_for(1), 12.861, 0.02 * 12.861);
    EXPECT_NEAR(gate.threshold_for(6), 25.042, 0.02 * 25.042);
    EXPECT_NEAR(gate.threshold_for(24), 54.777, 0.02 * 54.777);
}

TEST(InnovationGate, CountsTheChannelsThatArePresent) {
    Innovation<1, 3> innovation{.residual = Vector<3>::Zero(),
                                .spread = Matrix<3>::Zero(),
                                .noise = Matrix<3>::Identity(),
                                .cross = Matrix<1, 3>::Zero()};
    const InnovationGate gate{{.enabled = true, .threshold = 16.0}};
    innovation.residual(0) = std::sqrt(17.0);  // admitted as one of three, not as one of two
    EXPECT_TRUE(gate.admits(nis(innovation), innovation.channels()));
    innovation.remove(2);
    EXPECT_FALSE(gate.admits(nis(innovation), innovation.channels()));
}

}  // namespace
}  // namespace truenorth
