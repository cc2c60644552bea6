#include "estimation/corrector.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <utility>

#include "estimation/random_measurement.hpp"
#include "estimation/saved_state.hpp"

namespace truenorth {
namespace {

using Any = Corrector<kStates, kChannels>;
using Method = Any::Method;
constexpr std::array kMethods{
    Method::standard,          Method::h_infinity, Method::igg,  Method::adaptive_factor,
    Method::variational_bayes, Method::combined,   Method::huber};

class AnyCorrector : public testing::TestWithParam<unsigned> {};

TEST_P(AnyCorrector, GivesSoundCorrections) {
    for (const Method method : kMethods) {
        for (const double size : {0.3, 1.0, 5.0, 30.0}) {
            RandomCovariance random(GetParam());
            Any corrector;
            corrector.method = method;
            corrector.gate.enabled = false;
            for (int i = 0; i < 100; ++i) {
                const RandomMeasurement c(random, size);
                auto innovation = c.innovation();
                if (i % 3 == 0) {
                    innovation.remove(i % kChannels);
                }
                const auto correction = corrector.correct(c.P, innovation);
                EXPECT_TRUE(is_sound(correction)) << static_cast<int>(method) << ' ' << size << ' ' << i;
                for (int j = 0; j < kChannels; ++j) {
                    EXPECT_TRUE(innovation.present(j) || correction.weight(j) == 0.0);
                }
            }
        }
    }
}

TEST_P(AnyCorrector, IsTheStandardOneAtItsNeutralSetting) {
    for (const Method method : kMethods) {
        RandomCovariance random(GetParam());
        Any corrector;
        corrector.method = method;
        corrector.gate.enabled = false;
        corrector.h_infinity.gamma = std::numeric_limits<double>::infinity();
        corrector.igg.k0 = 10.0;
        corrector.igg.k1 = 11.0;
        corrector.adaptive_factor.threshold = 100.0;
        corrector.variational_bayes.iterations = 0;
        corrector.huber.k = std::numeric_limits<double>::infinity();
        corrector.combined.limit = 1.0;
        corrector.gate.threshold = 1e100;
        for (int i = 0; i < 200; ++i) {
            const RandomMeasurement c(random, 1.0);
            const auto correction = corrector.correct(c.P, c.innovation());
            EXPECT_TRUE(same_estimate(correction, Standard().correct(c.P, c.innovation())));
            EXPECT_EQ(correction.alpha, 1.0);
            EXPECT_EQ(correction.gamma_effective, std::numeric_limits<double>::infinity());
        }
    }
}

TEST_P(AnyCorrector, WithDefaultsDiffersFromTheStandardOneWhenProvoked) {
    for (const Method method : kMethods) {
        RandomCovariance random(GetParam());
        Any corrector;
        corrector.method = method;
        corrector.gate.enabled = method == Method::combined;  // which explains what that holds back
        const RandomMeasurement c(random, 30.0);
        const auto standard = Standard().correct(c.P, c.innovation());
        EXPECT_EQ(same_estimate(corrector.correct(c.P, c.innovation()), standard),
                  method == Method::standard);
    }
}

TEST_P(AnyCorrector, StandsBehindTheGate) {
    for (const Method method : kMethods) {
        RandomCovariance random(GetParam());
        Any corrector;
        corrector.method = method;
        const RandomMeasurement c(random, 1.0);
        corrector.correct(c.P, c.innovation());
        const auto learned = [&corrector] {
            return std::pair(SavedState::of(corrector.igg), SavedState::of(corrector.variational_bayes));
        };
        const auto before = learned();
        const int contradictions = corrector.contradictions();

        auto beyond = c.innovation();
        beyond.residual *= 1e3;
        ASSERT_GT(nis(beyond), corrector.gate.threshold_for(kChannels));
        const auto correction = corrector.correct(c.P, beyond);
        EXPECT_FALSE(correction.used());
        EXPECT_EQ(correction.deviation, Vector<kStates>::Zero());
        EXPECT_EQ(correction.covariance, c.P);
        EXPECT_EQ(learned(), before);
        EXPECT_EQ(corrector.contradictions(), contradictions + 1);
    }
}

TEST_P(AnyCorrector, LearnsNothingFromAnEpochWithoutChannels) {
    for (const Method method : kMethods) {
        RandomCovariance random(GetParam());
        const RandomMeasurement c(random, 0.3);
        auto beyond = c.innovation();
        beyond.residual *= 1e3;
        auto silent = c.innovation();
        for (int i = 0; i < kChannels; ++i) {
            silent.remove(i);
        }
        for (const bool gated : {false, true}) {  // its patience, and that of IGG
            Any corrector;
            corrector.method = method;
            corrector.gate.enabled = gated;
            corrector.gate.patience = 3;
            corrector.correct(c.P, beyond);
            const auto before = SavedState::of(corrector);
            const auto correction = corrector.correct(c.P, silent);
            EXPECT_FALSE(correction.used());
            EXPECT_EQ(correction.deviation, Vector<kStates>::Zero());
            EXPECT_EQ(correction.covariance, c.P);
            EXPECT_EQ(SavedState::of(corrector), before);
        }
    }
}

TEST_P(AnyCorrector, GoesOnFromASavedState) {
    for (const Method method : kMethods) {
        RandomCovariance random(GetParam());
        Any original;
        original.method = method;
        original.gate.enabled = false;
        for (int i = 0; i < 7; ++i) {
            const RandomMeasurement c(random, 5.0);
            original.correct(c.P, c.innovation());
        }
        Any restored;
        restored.method = method;
        restored.gate.enabled = false;
        SavedState::restore(restored, SavedState::of(original));
        const RandomMeasurement c(random, 5.0);
        EXPECT_TRUE(
            same_estimate(restored.correct(c.P, c.innovation()), original.correct(c.P, c.innovation())));
    }
}

TEST_P(AnyCorrector, LosesPatienceWithAGateThatRefusesTooManyInARow) {
    RandomCovariance random(GetParam());
    const RandomMeasurement c(random, 0.3);
    auto beyond = c.innovation();
    beyond.residual *= 1e3;
    for (const Method method : kMethods) {
        if (method == Method::combined) {  // which blames the prediction itself, before that
            continue;
        }
        Any corrector;
        corrector.method = method;
        corrector.gate.patience = 3;
        ASSERT_TRUE(corrector.gate.admits(nis(c.innovation()), kChannels));
        for (int i = 0; i < 100; ++i) {  // isolated ones never
            corrector.correct(c.P, beyond);
            corrector.correct(c.P, beyond);
            EXPECT_FALSE(corrector.out_of_patience());
            corrector.correct(c.P, c.innovation());
        }
        for (int i = 1; i <= 10; ++i) {
            corrector.correct(c.P, beyond);
            EXPECT_EQ(corrector.out_of_patience(), i >= 3);
        }
        Any restored;
        restored.gate.patience = 3;
        SavedState::restore(restored, SavedState::of(corrector));
        EXPECT_TRUE(restored.out_of_patience());
        corrector.correct(c.P, c.innovation());
        EXPECT_FALSE(corrector.out_of_patience());
        corrector.gate.patience = 0;
        for (int i = 1; i <= 10; ++i) {
            corrector.correct(c.P, beyond);
            EXPECT_FALSE(corrector.out_of_patience());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AnyCorrector, testing::Values(91U, 9191U));

}  // namespace
}  // namespace truenorth
