#include "filter/recovery.hpp"

#include <gtest/gtest.h>

namespace truenorth {
namespace {

constexpr int kPatience = 20;

TEST(Recovery, IsNotUnderWayBeforeItHasClimbed) {
    Recovery recovery;
    recovery.start();
    EXPECT_FALSE(recovery.under_way(0.0));
    EXPECT_FALSE(recovery.open());
}

TEST(Recovery, ClimbsARungAtATimeAndNeverRunsOut) {
    Recovery recovery;
    recovery.start();
    EXPECT_EQ(recovery.climb(100.0, kPatience, true), 1);
    EXPECT_EQ(recovery.climb(120.0, kPatience, true), Recovery::kSensors);
    EXPECT_EQ(recovery.climb(140.0, kPatience, true), Recovery::kAttitude);
    EXPECT_EQ(recovery.climb(160.0, kPatience, true), Recovery::kRestart);
    for (int k = 0; k < 1000; ++k) {
        EXPECT_EQ(recovery.climb(180.0 + 20.0 * k, kPatience, true), Recovery::kLast);
        EXPECT_TRUE(recovery.open());
    }
}

TEST(Recovery, BlamesTheAttitudeAtOnceOfAFilterThatWasNeverSureOfIt) {
    Recovery recovery;
    recovery.start();
    EXPECT_EQ(recovery.climb(100.0, kPatience, false), 1);
    EXPECT_EQ(recovery.climb(120.0, kPatience, false), Recovery::kAttitude);
    EXPECT_TRUE(recovery.open());
}

TEST(Recovery, HoldsTheGateOpenForAWhileAndIsUnderWayMeanwhile) {
    Recovery recovery;
    recovery.start();
    recovery.climb(0.0, kPatience, true);
    EXPECT_FALSE(recovery.open());
    recovery.climb(10.0, kPatience, true);
    EXPECT_FALSE(recovery.open());
    recovery.climb(20.0, kPatience, true);
    int open = 0;
    for (; recovery.open(); ++open) {
        EXPECT_TRUE(recovery.under_way(1e6));
        recovery.pass(20.0);
    }
    EXPECT_EQ(open, kPatience);
    EXPECT_FALSE(recovery.under_way(1e6));
}

TEST(Recovery, HoldsTheGateOpenForLongerEachTimeButNotForEver) {
    Recovery recovery;
    recovery.start();
    int before = 0;
    for (int k = 0; k < 20; ++k) {
        recovery.climb(20.0 * k, kPatience, true);
        int open = 0;
        for (; recovery.open(); ++open) {
            recovery.pass(20.0 * k);
        }
        EXPECT_GE(open, before);
        EXPECT_LE(open, 32 * kPatience);
        before = open;
    }
    EXPECT_EQ(before, 32 * kPatience);
}

TEST(Recovery, IsOverWhenItHasBeenCalm) {
    Recovery recovery;
    recovery.start();
    recovery.climb(100.0, kPatience, true);
    EXPECT_TRUE(recovery.under_way(100.0 + 0.9 * Recovery::kCalm));
    EXPECT_FALSE(recovery.under_way(100.0 + 1.1 * Recovery::kCalm));
    EXPECT_EQ(recovery.climb(100.0 + 1.5 * Recovery::kCalm, kPatience, true), 2);
    EXPECT_EQ(recovery.climb(100.0 + 4.0 * Recovery::kCalm, kPatience, true), 1);
}

}  // namespace
}  // namespace truenorth
