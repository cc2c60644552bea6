#include "estimation/innovation_mean.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/random_covariance.hpp"

namespace truenorth {
namespace {

class MeanOfInnovations : public testing::TestWithParam<unsigned> {
  protected:
    // The largest deviate while so many innovations of this mean, in their sigmas, come.
    double largest(int count, double offset) {
        InnovationMean<3> mean;
        double found = 0.0;
        for (int n = 0; n < count; ++n) {
            Innovation<4, 3> innovation{
                .residual = 2.0 * (random.normal<3, 1>() + Vector<3>(0.0, offset, 0.0)),
                .spread = 3.0 * Matrix<3>::Identity(),
                .noise = Matrix<3>::Identity(),
                .cross = Matrix<4, 3>::Zero()};
            innovation.remove(2);
            mean.add(n, innovation);
            found = std::max(found, mean.deviate());
        }
        return found;
    }

    RandomCovariance random{GetParam()};
};

TEST_P(MeanOfInnovations, IsNoneOfWhiteOnes) { EXPECT_LT(largest(20000, 0.0), 5.0); }

TEST_P(MeanOfInnovations, IsFoundThoughEachIsWithinItsSigma) { EXPECT_GT(largest(300, 0.5), 5.0); }

TEST_P(MeanOfInnovations, IsNotAskedOfAFew) { EXPECT_EQ(largest(8, 50.0), 0.0); }

TEST_P(MeanOfInnovations, IsForgottenOfAChannelThatIsNotMeasuredAnyMore) {
    InnovationMean<3> mean;
    for (int n = 0; n < 3000; ++n) {
        const double offset = n < 100 ? 2.0 : 0.0;
        Innovation<4, 3> innovation{.residual = random.normal<3, 1>() + Vector<3>::Constant(offset),
                                    .spread = Matrix<3>::Zero(),
                                    .noise = Matrix<3>::Identity(),
                                    .cross = Matrix<4, 3>::Zero()};
        if (n >= 100) {
            innovation.remove(2);
        }
        mean.add(n, innovation);
        if (n == 100) {
            EXPECT_GT(mean.deviate(), 5.0);
        }
    }
    EXPECT_LT(mean.deviate(), 5.0);
}

TEST_P(MeanOfInnovations, OfWhatIsNoNumberIsNotPassedOver) {
    InnovationMean<3> mean;
    for (int n = 0; n < 20; ++n) {
        mean.add(n, Innovation<4, 3>{.residual = random.normal<3, 1>(),
                                     .spread = Vector<3>(0.0, -2.0, 0.0).asDiagonal(),
                                     .noise = Matrix<3>::Identity(),
                                     .cross = Matrix<4, 3>::Zero()});
    }
    EXPECT_TRUE(std::isnan(mean.deviate()));
}

INSTANTIATE_TEST_SUITE_P(Seeds, MeanOfInnovations, testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace truenorth
