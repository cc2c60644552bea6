#include "plant/gnss_fault.hpp"

#include <gtest/gtest.h>

#include "inertial/earth.hpp"

namespace truenorth::plant {
namespace {

using Kind = GnssFault::Kind;

constexpr double kPeriod = 0.01;  // of the IMU samples

// Of second t: another place, velocity and pseudorange every time.
Fix fix(double t) {
    Fix fix{
        .time = t,
        .position = {.latitude = 0.9 + 1e-6 * t, .longitude = -1.2, .height = 35.0 + t},
        .velocity = {1.0 + t, 2.0, 3.0},
    };
    fix.channels[0] = {.satellite = 7, .pseudorange = 2e7 + t, .range_rate = -500.0 + t};
    return fix;
}

void expect_equal(const Fix& one, const Fix& other) {
    EXPECT_EQ(one.time, other.time);
    EXPECT_EQ(one.position.latitude, other.position.latitude);
    EXPECT_EQ(one.position.longitude, other.position.longitude);
    EXPECT_EQ(one.position.height, other.position.height);
    EXPECT_EQ(one.velocity, other.velocity);
    EXPECT_EQ(one.channels[0].satellite, other.channels[0].satellite);
    EXPECT_EQ(one.channels[0].pseudorange, other.channels[0].pseudorange);
    EXPECT_EQ(one.channels[0].range_rate, other.channels[0].range_rate);
}

// `kind` from 10 s on, for 5 s.
GnssFault fault(Kind kind, double size, int axis = 0) {
    return {{.kind = kind, .begin = 10.0, .duration = 5.0, .size = size, .axis = axis}, kPeriod};
}

class FaultOfAnyKind : public testing::TestWithParam<Kind> {};

TEST_P(FaultOfAnyKind, ChangesNothingBeforeAndAfter) {
    const GnssFault fault_of_kind = fault(GetParam(), 2.0);
    Fix before;
    for (const double t : {0.0, 9.0, 9.99, 15.0, 16.0, 1000.0}) {
        EXPECT_FALSE(fault_of_kind.silences(t));
        expect_equal(fault_of_kind.shown(fix(t)), fix(t));
        expect_equal(fault_of_kind.reported(fix(t), before), fix(t));
        EXPECT_EQ(fault_of_kind.latency(t), 0.0);
    }
}

TEST_P(FaultOfAnyKind, WithoutADurationStays) {
    const GnssFault lasting({.kind = GetParam(), .begin = 10.0, .size = 2.0}, kPeriod);
    Fix before = fix(9.0);
    for (const double t : {10.0, 15.0, 1e6}) {
        const Fix shown = lasting.shown(fix(t));
        const Fix reported = lasting.reported(shown, before);
        const bool moved = earth::displacement(fix(t).position, reported.position).norm() > 0.0;
        const bool changed = lasting.silences(t) || moved || reported.velocity != fix(t).velocity ||
                             reported.time != t || lasting.latency(t) > 0.0;
        EXPECT_EQ(changed, GetParam() != Kind::none) << t;
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, FaultOfAnyKind,
                         testing::Values(Kind::none, Kind::silence, Kind::frozen, Kind::position_jump,
                                         Kind::drift, Kind::velocity_sign, Kind::time_offset, Kind::latency));

TEST(GnssFault, SilenceAndLatencyConcernFixesByTheirTimeOfValidity) {
    EXPECT_TRUE(fault(Kind::silence, 0.0).silences(10.0));
    EXPECT_TRUE(fault(Kind::silence, 0.0).silences(14.99));
    EXPECT_EQ(fault(Kind::latency, 2.0).latency(10.0), 2.0);
    EXPECT_FALSE(fault(Kind::latency, 2.0).silences(10.0));
}

// 0.1 + 0.2 is not 0.3 in floating point.
TEST(GnssFault, TheEdgesAreThoseThatWereMeant) {
    const GnssFault silence({.kind = Kind::silence, .begin = 0.1, .duration = 0.2}, kPeriod);
    EXPECT_TRUE(silence.silences(0.1));
    EXPECT_TRUE(silence.silences(0.29));
    EXPECT_FALSE(silence.silences(0.3));
}

TEST(GnssFault, AFrozenFixHasANewTimeAlone) {
    const GnssFault frozen = fault(Kind::frozen, 0.0);
    Fix before;
    (void)frozen.reported(fix(8.0), before);
    (void)frozen.reported(fix(9.0), before);
    for (const double t : {10.0, 11.0, 14.0}) {
        Fix expected = fix(9.0);
        expected.time = t;
        expect_equal(frozen.reported(fix(t), before), expected);
    }
}

TEST(GnssFault, AJumpDisplacesTheAntennaAndADriftMovesIt) {
    for (int axis = 0; axis <= 3; ++axis) {
        const Eigen::Vector3d along =
            axis == 0 ? Eigen::Vector3d::Ones().eval() : Eigen::Vector3d::Unit(axis - 1).eval();
        const Fix jumped = fault(Kind::position_jump, 50.0, axis).shown(fix(12.0));
        EXPECT_LT((earth::displacement(fix(12.0).position, jumped.position) - 50.0 * along).norm(), 1e-6);
        EXPECT_EQ(jumped.velocity, fix(12.0).velocity);
        const Fix drifted = fault(Kind::drift, 0.5, axis).shown(fix(12.0));
        EXPECT_LT((earth::displacement(fix(12.0).position, drifted.position) - 2.0 * 0.5 * along).norm(),
                  1e-6);
        EXPECT_EQ(drifted.velocity, fix(12.0).velocity + 0.5 * along);
        EXPECT_EQ(drifted.time, 12.0);
    }
}

TEST(GnssFault, TheVelocityTurnsItsSign) {
    Fix before;
    EXPECT_EQ(fault(Kind::velocity_sign, 0.0).reported(fix(12.0), before).velocity,
              Eigen::Vector3d(-13.0, -2.0, -3.0));
    const Fix up = fault(Kind::velocity_sign, 0.0, 3).reported(fix(12.0), before);
    EXPECT_EQ(up.velocity, Eigen::Vector3d(13.0, 2.0, -3.0));
    EXPECT_EQ(up.channels[0].range_rate, fix(12.0).channels[0].range_rate);
}

TEST(GnssFault, ATimeOffsetConcernsTheStampAlone) {
    Fix before;
    Fix expected = fix(12.0);
    expected.time = 13.0;
    expect_equal(fault(Kind::time_offset, 1.0).reported(fix(12.0), before), expected);
}

}  // namespace
}  // namespace truenorth::plant
