#include "filter/filter_status.hpp"

#include <gtest/gtest.h>

#include <tuple>

namespace truenorth {
namespace {

using State = FilterStatus::State;
constexpr FilterStatus::Rules kRules{.heading_sigma = 0.01, .hold_time = 10.0, .coasting_delay = 5.0};
constexpr double kGood = 0.009;
constexpr double kPoor = 0.01;

FilterStatus::Evidence evidence(double heading_sigma, bool sensing = true, bool coarse = false) {
    return {.sensing = sensing,
            .silent = false,
            .suspect = false,
            .coarse = coarse,
            .recovering = false,
            .consistent = true,
            .measured = true,
            .heading_sigma = heading_sigma};
}

// Fixes every second from `from` to `to`; the last state.
State with_fixes(FilterStatus& status, int from, int to, double heading_sigma) {
    State state = State::waiting;
    for (int second = from; second <= to; ++second) {
        status.use_fix(second);
        state = status.judge(second, evidence(heading_sigma), kRules);
    }
    return state;
}

TEST(FilterStatus, WaitsForSamplesAndFixes) {
    FilterStatus status;
    status.start(0.0);
    EXPECT_EQ(status.judge(0.0, evidence(kGood, false), kRules), State::waiting);
    EXPECT_EQ(status.judge(100.0, evidence(kGood), kRules), State::waiting);
    status.use_fix(100.0);
    EXPECT_EQ(status.judge(100.0, evidence(kGood), kRules), State::aligning);
}

TEST(FilterStatus, ConvergesWhenTheHeadingHasBeenGoodForLongEnough) {
    FilterStatus status;
    status.start(0.0);
    EXPECT_EQ(with_fixes(status, 1, 30, kPoor), State::aligning);
    EXPECT_EQ(with_fixes(status, 31, 40, kGood), State::aligning);
    EXPECT_EQ(with_fixes(status, 41, 41, kGood), State::converged);
    EXPECT_EQ(with_fixes(status, 42, 42, kPoor), State::aligning);
    EXPECT_EQ(with_fixes(status, 43, 52, kGood), State::aligning);
    EXPECT_EQ(with_fixes(status, 53, 53, kGood), State::converged);
}

TEST(FilterStatus, ConvergesAtTheSameStepForAMasterThatAddsItsStepsUp) {
    FilterStatus status;
    status.start(0.0);
    double added = 0.0;
    int converged_at = 0;
    for (int step = 1; converged_at == 0; ++step) {
        added += 0.1;
        status.use_fix(added);
        const double sigma = step < 70 ? kPoor : kGood;
        converged_at = status.judge(added, evidence(sigma), kRules) == State::converged ? step : 0;
    }
    EXPECT_EQ(converged_at, 170);
}

TEST(FilterStatus, OfACoastingFilterIsNotConvergedAndTheHoldTimeBeginsAgain) {
    FilterStatus status;
    status.start(0.0);
    ASSERT_EQ(with_fixes(status, 1, 20, kGood), State::converged);
    EXPECT_EQ(status.judge(25.0, evidence(kGood), kRules), State::converged);
    EXPECT_EQ(status.judge(25.1, evidence(kGood), kRules), State::coasting);
    EXPECT_EQ(with_fixes(status, 30, 39, kGood), State::aligning);
    EXPECT_EQ(with_fixes(status, 40, 40, kGood), State::converged);
}

TEST(FilterStatus, OfACoarseStageIsNeverConverged) {
    FilterStatus status;
    status.start(0.0);
    EXPECT_EQ(status.judge(1.0, evidence(kGood, true, true), kRules), State::waiting);
    status.use_fix(1.0);
    EXPECT_EQ(status.judge(2.0, evidence(kGood, true, true), kRules), State::coarse);
    EXPECT_EQ(status.judge(7.0, evidence(kGood, true, true), kRules), State::coasting);
    EXPECT_EQ(with_fixes(status, 20, 29, kGood), State::aligning);
    EXPECT_EQ(with_fixes(status, 30, 30, kGood), State::converged);
}

TEST(FilterStatus, IsInconsistentWhileTheInnovationsContradictAndTheHoldTimeBeginsAgain) {
    FilterStatus status;
    status.start(0.0);
    ASSERT_EQ(with_fixes(status, 1, 20, kGood), State::converged);
    FilterStatus::Evidence contradicted = evidence(kGood);
    contradicted.consistent = false;
    status.use_fix(21.0);
    EXPECT_EQ(status.judge(21.0, contradicted, kRules), State::inconsistent);
    contradicted.coarse = true;
    EXPECT_EQ(status.judge(21.0, contradicted, kRules), State::coarse);
    EXPECT_EQ(status.judge(27.0, contradicted, kRules), State::coasting);
    EXPECT_EQ(with_fixes(status, 28, 37, kGood), State::aligning);
    EXPECT_EQ(with_fixes(status, 38, 38, kGood), State::converged);
}

TEST(FilterStatus, NothingThatSpeaksAgainstItIsConvergedAndTheHoldTimeBeginsAgain) {
    using Evidence = FilterStatus::Evidence;
    const std::tuple<bool Evidence::*, bool, State> hindrances[] = {
        {&Evidence::silent, true, State::silent},
        {&Evidence::suspect, true, State::suspect},
        {&Evidence::recovering, true, State::recovering},
        {&Evidence::measured, false, State::aligning}};
    for (const auto& [hindrance, value, state] : hindrances) {
        FilterStatus status;
        status.start(0.0);
        ASSERT_EQ(with_fixes(status, 1, 20, kGood), State::converged);
        Evidence bad = evidence(kGood);
        bad.*hindrance = value;
        status.use_fix(21.0);
        EXPECT_EQ(status.judge(21.0, bad, kRules), state);
        EXPECT_EQ(with_fixes(status, 22, 31, kGood), State::aligning);
        EXPECT_EQ(with_fixes(status, 32, 32, kGood), State::converged);
    }
}

TEST(FilterStatus, OfASilentImuIsToldBeforeThatOfASilentReceiver) {
    FilterStatus status;
    status.start(0.0);
    ASSERT_EQ(with_fixes(status, 1, 20, kGood), State::converged);
    FilterStatus::Evidence silent = evidence(kGood);
    silent.silent = true;
    EXPECT_EQ(status.judge(60.0, silent, kRules), State::silent);
}

TEST(FilterStatus, OfAFaultIsFinalUntilTheNextStart) {
    FilterStatus status;
    status.start(0.0);
    ASSERT_EQ(with_fixes(status, 1, 20, kGood), State::converged);
    status.fault();
    EXPECT_EQ(with_fixes(status, 21, 60, kGood), State::faulted);
    status.start(60.0);
    EXPECT_EQ(with_fixes(status, 61, 71, kGood), State::converged);
}

}  // namespace
}  // namespace truenorth
