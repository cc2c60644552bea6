#include "contract/step_sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace truenorth {
namespace {

constexpr double kEpoch = 1.4e9;  // a start in seconds of Unix time
constexpr double kPeriod = 0.0025;
constexpr double kSlack = 1e-3 * kPeriod;
constexpr std::int64_t kDay = 86400 * 400;  // steps

TEST(StepSequence, FollowsAMasterThatSumsUpItsStepsForADay) {
    StepSequence sequence(kEpoch);
    double time = kEpoch;
    std::int64_t refused = 0;
    for (std::int64_t k = 0; k < kDay; ++k) {
        refused += sequence.continues(time, kSlack) ? 0 : 1;
        sequence.advance(time, kPeriod);
        time += kPeriod;
    }
    EXPECT_EQ(refused, 0);
    EXPECT_GT(std::abs(time - kEpoch - 86400.0), 100.0 * kPeriod);  // by now far from where it should be
}

TEST(StepSequence, FollowsAMasterThatMultipliesItsStep) {
    StepSequence sequence(kEpoch);
    std::int64_t refused = 0;
    for (std::int64_t k = 0; k < kDay; ++k) {
        const double time = kEpoch + static_cast<double>(k) * kPeriod;
        refused += sequence.continues(time, kSlack) ? 0 : 1;
        sequence.advance(time, kPeriod);
    }
    EXPECT_EQ(refused, 0);
}

// However long the master has summed up before: no allowance for that adds up.
TEST(StepSequence, RefusesASkippedAndARepeatedStepAtAnyTime) {
    StepSequence sequence(kEpoch);
    double time = kEpoch;
    for (std::int64_t k = 0; k < 1'000'000; ++k) {
        ASSERT_FALSE(sequence.continues(time + kPeriod, kSlack));
        ASSERT_FALSE(sequence.continues(time - kPeriod, kSlack));
        ASSERT_FALSE(sequence.continues(time + 0.01 * kPeriod, kSlack));
        sequence.advance(time, kPeriod);
        time += kPeriod;
    }
}

TEST(StepSequence, ATimeThatIsNoneIsRefused) {
    EXPECT_FALSE(StepSequence(0.0).continues(std::nan(""), kSlack));
}

}  // namespace
}  // namespace truenorth
