#include "filter/gnss_input.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace truenorth {
namespace {

using Verdict = GnssInput::Verdict;

constexpr GnssInput::Moment kTen{.now = 10.0, .offset = 0.0, .slack = 0.0};

GnssFix fix_at(double time) {
    return {.time = time,
            .position = {.latitude = 0.5, .longitude = 2.0, .height = 100.0},
            .velocity = {1.0 + 1e-3 * time, 2.0, 0.0}};  // no two alike
}

TEST(GnssInput, AcceptsAPlausibleFixOnce) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(0, fix_at(0.0), kTen), Verdict::stale);
    EXPECT_EQ(gnss.read(1, fix_at(9.0), kTen), Verdict::accepted);
    EXPECT_EQ(gnss.read(1, fix_at(9.0), kTen), Verdict::stale);
    EXPECT_EQ(gnss.read(2, fix_at(10.0), kTen), Verdict::accepted);
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Components of position and velocity, east, north, up.
std::array<double*, 6> components_of(GnssFix& fix) {
    return {&fix.position.longitude, &fix.position.latitude, &fix.position.height,
            &fix.velocity.x(),       &fix.velocity.y(),      &fix.velocity.z()};
}

TEST(GnssInput, RejectsEveryValueThatIsInfiniteAndATimeThatIsNone) {
    for (std::size_t i = 0; i < 6; ++i) {
        GnssFix fix = fix_at(1.0);
        *components_of(fix)[i] = kInfinite;
        GnssInput gnss;
        EXPECT_EQ(gnss.read(1, fix, kTen), Verdict::not_finite) << i;
    }
    for (const double bad : {kNan, kInfinite}) {
        GnssInput gnss;
        EXPECT_EQ(gnss.read(1, fix_at(bad), kTen), Verdict::not_finite);
    }
}

TEST(GnssInput, TakesWhatIsNoNumberForNotMeasured) {
    for (std::size_t i = 0; i < 6; ++i) {
        GnssFix fix = fix_at(1.0);
        *components_of(fix)[i] = kNan;
        GnssInput gnss;
        EXPECT_EQ(gnss.read(1, fix, kTen), Verdict::accepted) << i;
        GnssFix::Mask expected = GnssFix::Mask::Constant(true);
        expected(static_cast<Eigen::Index>(i)) = false;
        EXPECT_TRUE((fix.measured() == expected).all()) << i;
        GnssFix other = fix_at(2.0);
        GnssFix filled = fix.filled_from(other.position, other.velocity);
        EXPECT_TRUE(filled.complete());
        EXPECT_EQ(*components_of(filled)[i], *components_of(other)[i]);
    }
    GnssFix nothing = fix_at(1.0);
    for (double* component : components_of(nothing)) {
        *component = kNan;
    }
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, nothing, kTen), Verdict::empty);
}

TEST(GnssInput, RejectsSigmasThatAreNone) {
    const auto verdict = [](double sigma, double height) {
        GnssFix fix = fix_at(1.0);
        fix.sigma(2) = sigma;
        fix.position.height = height;
        GnssInput gnss;
        return gnss.read(1, fix, kTen);
    };
    EXPECT_EQ(verdict(0.0, 1.0), Verdict::accepted);
    EXPECT_EQ(verdict(3.0, 1.0), Verdict::accepted);
    EXPECT_EQ(verdict(-3.0, 1.0), Verdict::impossible);
    EXPECT_EQ(verdict(kNan, 1.0), Verdict::not_finite);
    EXPECT_EQ(verdict(kInfinite, 1.0), Verdict::not_finite);
    EXPECT_EQ(verdict(kNan, kNan), Verdict::accepted);  // of what is not measured
}

TEST(GnssInput, AReceiverThatHangsIsFoundWhateverItMeasures) {
    GnssFix fix = fix_at(1.0);
    fix.position.height = kNan;
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, fix, kTen), Verdict::accepted);
    fix.time = 2.0;
    EXPECT_EQ(gnss.read(2, fix, kTen), Verdict::frozen);
}

TEST(GnssInput, RejectsPlacesAndSpeedsThatAreImpossible) {
    const auto verdict = [](double latitude, double longitude, double height, double speed) {
        GnssInput gnss;
        return gnss.read(1,
                         {.time = 1.0,
                          .position = {.latitude = latitude, .longitude = longitude, .height = height},
                          .velocity = {speed, 0.0, 0.0}},
                         kTen);
    };
    EXPECT_EQ(verdict(1.5708, 0.0, 0.0, 0.0), Verdict::impossible);  // the pole
    EXPECT_EQ(verdict(-2.0, 0.0, 0.0, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, 7.0, 0.0, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, -118.0, 0.0, 0.0), Verdict::impossible);  // degrees
    EXPECT_EQ(verdict(0.0, 0.0, -16e3, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, 0.0, 101e3, 0.0), Verdict::impossible);
    EXPECT_EQ(verdict(0.0, 0.0, 0.0, 10001.0), Verdict::impossible);
    EXPECT_EQ(verdict(-1.5, 6.2, 12e3, 900.0), Verdict::accepted);
}

TEST(GnssInput, RejectsTimeThatDoesNotAdvance) {
    GnssInput gnss;
    gnss.read(1, fix_at(5.0), kTen);
    GnssFix again = fix_at(5.0);
    again.velocity.y() += 1.0;
    EXPECT_EQ(gnss.read(2, again, kTen), Verdict::backwards);
    EXPECT_EQ(gnss.read(3, fix_at(4.0), kTen), Verdict::backwards);
    EXPECT_EQ(gnss.read(4, fix_at(5.1), kTen), Verdict::accepted);
}

TEST(GnssInput, RejectsAFixFromTheFuture) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, fix_at(10.2), kTen), Verdict::future);
    EXPECT_EQ(gnss.read(2, fix_at(10.1 + 1e-9), kTen), Verdict::accepted);  // the clocks' rounding
    EXPECT_EQ(gnss.disagreements(), 1);
}

TEST(GnssInput, LetsAFixWaitThatIsALittleYoungerThanTheImuData) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, fix_at(10.03), {.now = 10.0, .offset = 0.0, .slack = 0.05}), Verdict::accepted);
    EXPECT_DOUBLE_EQ(gnss.valid_at(), 10.03);
    EXPECT_EQ(gnss.read(2, fix_at(10.08), {.now = 10.0, .offset = 0.0, .slack = 0.05}), Verdict::accepted);
    EXPECT_EQ(gnss.read(3, fix_at(10.2), {.now = 10.0, .offset = 0.0, .slack = 0.05}), Verdict::future);
}

TEST(GnssInput, ARejectedFixDoesNotHoldBackTheNext) {
    GnssInput gnss;
    EXPECT_EQ(gnss.read(1, fix_at(1e6), kTen), Verdict::future);
    EXPECT_EQ(gnss.read(2, fix_at(9.0), kTen), Verdict::accepted);
}

TEST(GnssInput, RejectsAReceiverThatHangsButNotOneThatStands) {
    GnssInput gnss;
    GnssFix fix = fix_at(1.0);
    EXPECT_EQ(gnss.read(1, fix, kTen), Verdict::accepted);
    fix.time = 2.0;
    EXPECT_EQ(gnss.read(2, fix, kTen), Verdict::frozen);
    fix.time = 3.0;
    fix.velocity.x() += 1e-9;
    EXPECT_EQ(gnss.read(3, fix, kTen), Verdict::accepted);

    GnssInput standing;
    for (int k = 1; k <= 3; ++k) {
        GnssFix resting = fix_at(k);
        resting.velocity.setZero();
        EXPECT_EQ(standing.read(k, resting, kTen), Verdict::accepted);
    }
}

// A fix a second, 0.2 s late, from a receiver whose clock is off by `offset(second)`; how many are accepted
// of those from `from` on, and the last time of validity.
template <class Offset, class ImuOffset>
std::pair<int, double> accepted(GnssInput& gnss, int from, int to, Offset offset, ImuOffset imu_offset) {
    int count = 0;
    for (int second = from; second <= to; ++second) {
        GnssFix fix = fix_at(second - 0.2 + offset(second));
        fix.velocity.x() += second;  // no two alike
        const auto verdict =
            gnss.read(second, fix, {.now = 1.0 * second, .offset = imu_offset(second), .slack = 0.01});
        count += verdict == Verdict::accepted ? 1 : 0;
    }
    return {count, gnss.valid_at()};
}

TEST(GnssInput, GoesOnWhenItsClockWasSet) {
    for (const double step : {3600.0, 18.0, 1.0, -5.0, -3600.0}) {
        GnssInput gnss;
        const auto offset = [step](int second) { return second >= 100 ? step : 0.0; };
        const auto none = [](int) { return 0.0; };
        accepted(gnss, 1, 99, offset, none);
        const auto [count, valid_at] = accepted(gnss, 100, 120, offset, none);
        EXPECT_EQ(count, 19) << step;  // three agree before they are believed, and the third is one of them
        EXPECT_NEAR(valid_at, 119.8, 1e-9) << step;
        EXPECT_EQ(gnss.disagreements(), 3) << step;
    }
}

TEST(GnssInput, BelievesAClockThatIsAheadFromTheBeginning) {
    for (const double ahead : {0.04, 0.3, 18.0, 3600.0}) {
        GnssInput gnss;
        const auto offset = [ahead](int) { return 0.2 + ahead; };  // as read, without latency
        const auto none = [](int) { return 0.0; };
        const auto [count, valid_at] = accepted(gnss, 1, 20, offset, none);
        const bool waits = ahead < StampClock::kAhead;
        EXPECT_EQ(count, waits ? 20 : 18) << ahead;  // the third is the first of those that are believed
        EXPECT_NEAR(valid_at, waits ? 20.0 + ahead : 20.0, 1e-9) << ahead;
        EXPECT_EQ(gnss.disagreements(), waits ? 0 : 3) << ahead;
    }
}

TEST(GnssInput, BelievesAClockThatIsBehindFromTheBeginning) {
    for (const double behind : {18.0, 3600.0, 1e6}) {
        GnssInput gnss;
        const auto offset = [behind](int) { return 0.2 - behind; };  // as read, without latency
        const auto none = [](int) { return 0.0; };
        const auto [count, valid_at] = accepted(gnss, 1, 20, offset, none);
        EXPECT_EQ(count, 18) << behind;
        EXPECT_NEAR(valid_at, 20.0, 1e-6) << behind;
        EXPECT_EQ(gnss.disagreements(), 3) << behind;
    }
}

// The filter remembers the last 2.5 s. What comes from before is of no use, be the link slow or the clock
// wrong; after a minute it is the clock.
TEST(GnssInput, GoesOnWhenItsStampsAreFromBeforeAllThatIsRemembered) {
    GnssInput gnss;
    const auto read = [&](int second, double behind) {
        GnssFix fix = fix_at(second - 0.2 - behind);
        fix.velocity.x() += second;  // no two alike
        return gnss.read(second, fix, {.now = 1.0 * second, .slack = 0.01, .oldest = second - 2.5});
    };
    for (int second = 1; second < 100; ++second) {
        ASSERT_EQ(read(second, 0.0), Verdict::accepted);
    }
    for (int second = 105; second < 165; ++second) {
        ASSERT_NE(read(second, 5.0), Verdict::accepted) << second;
    }
    for (int second = 165; second < 200; ++second) {
        ASSERT_EQ(read(second, 5.0), Verdict::accepted) << second;
        EXPECT_NEAR(gnss.valid_at(), second - 0.2, 1e-9);
    }
    for (int second = 200; second < 202; ++second) {  // and back
        ASSERT_EQ(read(second, 0.0), Verdict::future);
    }
    EXPECT_EQ(read(202, 0.0), Verdict::accepted);
    EXPECT_NEAR(gnss.valid_at(), 201.8, 1e-9);
}

TEST(GnssInput, ClocksThatRunApartAreFollowed) {
    GnssInput gnss;
    int refused = 0;
    for (int second = 1; second <= 86400; ++second) {
        GnssFix fix = fix_at(second * (1.0 - 2e-4) - 0.2);
        refused += gnss.read(second, fix, {.now = 1.0 * second, .oldest = second - 2.5}) == Verdict::accepted
                       ? 0
                       : 1;
    }
    EXPECT_LT(refused, 86400 / 100);  // a minute each time that 2.3 s have run up
    EXPECT_GT(gnss.valid_at(), 86400.0 - 2.5 - 0.2);
}

// As receivers put out that have no fix.
TEST(GnssInput, ASigmaWithoutBoundsIsNoMeasurement) {
    for (const double place : {4.3e6, 1e160}) {
        GnssFix fix = fix_at(1.0);
        fix.sigma << place, place, place, 1e4, 1e4, 1e4;
        GnssInput gnss;
        EXPECT_EQ(gnss.read(1, fix, kTen), Verdict::empty);
        fix.sigma.tail<3>().setConstant(0.1);
        EXPECT_EQ(gnss.read(2, fix, kTen), Verdict::accepted);
        EXPECT_EQ(fix.measured().count(), 3);
        EXPECT_EQ(fix.filled_from({.latitude = 0.1, .longitude = 0.2, .height = 3.0}, {}).position.height,
                  3.0);
    }
}

// On a vehicle that moves, as the filter says; one that is parked may have the same place for hours.
TEST(GnssInput, FindsAReceiverThatHangsAndMeasuresNoVelocity) {
    for (const double unmeasured : {kNan, 0.0}) {
        GnssInput gnss;
        GnssFix fix = fix_at(1.0);
        fix.velocity.setConstant(unmeasured);
        fix.sigma.tail<3>().setConstant(1e4);  // nothing is known of it, number or none
        const auto read = [&](int sample, double speed) {
            fix.time = 0.1 * sample;
            return gnss.read(sample, fix, kTen, speed);
        };
        EXPECT_EQ(read(1, 5.0), Verdict::accepted);
        EXPECT_EQ(read(2, 5.0), Verdict::frozen);
        EXPECT_EQ(read(3, 0.1), Verdict::accepted);
        EXPECT_EQ(read(4, 0.1), Verdict::accepted);
        fix.position.height += 0.01;
        EXPECT_EQ(read(5, 5.0), Verdict::accepted);
        EXPECT_EQ(read(6, 5.0), Verdict::frozen);
    }
}

// The latency of a network, 0.1 to 0.4 s.
TEST(GnssInput, GoesOnWhenItsStampsAreForgottenAndTheLinkJitters) {
    GnssInput gnss;
    const auto read = [&](int k, double behind) {
        const double now = 0.2 * k;
        GnssFix fix = fix_at(now - 0.1 - 0.3 * (0.5 + 0.5 * std::sin(7.0 * k)) - behind);
        fix.velocity.x() += k;  // no two alike
        return gnss.read(k, fix, {.now = now, .slack = 0.01, .oldest = now - 2.5});
    };
    for (int k = 1; k < 500; ++k) {
        read(k, 0.0);
    }
    int accepted = 0;
    for (int k = 530; k < 2000; ++k) {
        accepted += read(k, 5.0) == Verdict::accepted ? 1 : 0;
    }
    EXPECT_GT(accepted, 800);
    EXPECT_NEAR(gnss.valid_at(), 0.2 * 1999.0 - 0.3, 0.6);
}

TEST(GnssInput, WaitsForMeasurementsThatComeLaterThanBefore) {
    GnssInput gnss;
    const auto none = [](int) { return 0.0; };
    accepted(gnss, 1, 99, none, none);
    EXPECT_EQ(gnss.read(100, fix_at(99.9), {.now = 105.0, .slack = 0.01}), Verdict::accepted);
    EXPECT_NEAR(gnss.valid_at(), 99.9, 1e-9);  // 5 s late, and no clock that was set
    EXPECT_EQ(gnss.disagreements(), 0);
}

TEST(GnssInput, LosesNothingWhenItsClockIsSetTogetherWithTheImus) {
    for (const double step : {1.0, -1.0, 3600.0}) {
        GnssInput gnss;
        const auto offset = [step](int second) { return second >= 100 ? step : 0.0; };
        accepted(gnss, 1, 99, offset, offset);
        const auto [count, valid_at] = accepted(gnss, 100, 120, offset, offset);
        EXPECT_EQ(count, 21) << step;
        EXPECT_NEAR(valid_at, 119.8, 1e-9) << step;
    }
}

TEST(GnssInput, DoesNotTakeTheStepOfAnImuClockForItsOwn) {
    GnssInput gnss;
    const auto none = [](int) { return 0.0; };
    const auto imu = [](int second) { return second >= 100 ? 1.0 : 0.0; };
    accepted(gnss, 1, 99, none, imu);
    const auto [count, valid_at] = accepted(gnss, 100, 120, none, imu);
    EXPECT_EQ(count, 21);
    EXPECT_NEAR(valid_at, 119.8, 1e-9);
}

TEST(GnssInput, StartForgetsEverything) {
    GnssInput gnss;
    gnss.read(1, fix_at(5.0), kTen);
    gnss.start();
    EXPECT_EQ(gnss.read(1, fix_at(1.0), kTen), Verdict::accepted);
}

}  // namespace
}  // namespace truenorth
