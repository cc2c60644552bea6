#include "filter/antenna_history.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace truenorth {
namespace {

using Eigen::Vector3d;

// Moves north-east so that latitude and velocity are linear in time.
AntennaState state_at(double time) {
    return {.time = time,
            .position = {.latitude = 0.5 + 1e-7 * time, .longitude = 1.0, .height = 2.0 * time},
            .velocity = {time, -time, 3.0}};
}

TEST(AntennaHistory, OfNothingHasNothing) { EXPECT_FALSE(AntennaHistory{}.at(0.0)); }

TEST(AntennaHistory, InterpolatesBetweenEntries) {
    AntennaHistory history;
    for (int k = 0; k <= 10; ++k) {
        history.push(state_at(0.1 * k));
    }
    for (const double time : {0.0, 0.05, 0.31, 0.7, 0.999, 1.0}) {
        const auto found = history.at(time);
        ASSERT_TRUE(found) << time;
        EXPECT_NEAR(found->time, time, 1e-12);
        EXPECT_LT((found->velocity - state_at(time).velocity).norm(), 1e-12);
        EXPECT_LT(earth::displacement(state_at(time).position, found->position).norm(), 1e-7);
    }
}

TEST(AntennaHistory, InterpolatesAcrossTheDateLine) {
    AntennaHistory history;
    history.push({.time = 0.0,
                  .position = {.latitude = 0.5, .longitude = std::numbers::pi - 1e-6, .height = 0.0},
                  .velocity = Vector3d::Zero()});
    history.push({.time = 1.0,
                  .position = {.latitude = 0.5, .longitude = -std::numbers::pi + 1e-6, .height = 0.0},
                  .velocity = Vector3d::Zero()});
    EXPECT_GT(std::abs(history.at(0.5)->position.longitude), std::numbers::pi - 1e-8);
}

TEST(AntennaHistory, DoesNotExtrapolate) {
    AntennaHistory history;
    history.push(state_at(1.0));
    history.push(state_at(2.0));
    EXPECT_FALSE(history.at(0.999));
    EXPECT_FALSE(history.at(2.001));
    EXPECT_TRUE(history.at(2.0 + 1e-9));  // rounding of a time stamp
}

TEST(AntennaHistory, KeepsItsCapacityOfEntries) {
    AntennaHistory history;
    const int count = static_cast<int>(AntennaHistory::kCapacity);
    for (int k = 0; k < 2 * count; ++k) {
        history.push(state_at(k));
    }
    EXPECT_FALSE(history.at(count - 0.5));
    ASSERT_TRUE(history.at(count + 0.5));
    EXPECT_NEAR(history.at(count + 0.5)->velocity.x(), count + 0.5, 1e-9);
}

TEST(AntennaHistory, AtOneKilohertzStillReachesBackSeconds) {
    AntennaHistory history;
    for (int k = 0; k <= 10000; ++k) {
        history.push(state_at(1e-3 * k));
    }
    for (const double time : {10.0, 9.9995, 9.993, 9.4321, 7.6}) {
        const auto found = history.at(time);
        ASSERT_TRUE(found) << time;
        EXPECT_LT((found->velocity - state_at(time).velocity).norm(), 1e-9) << time;
    }
}

TEST(AntennaHistory, AtOneHundredHertzKeepsEverySample) {
    AntennaHistory history;
    for (int k = 0; k <= 100; ++k) {
        AntennaState state = state_at(0.01 * k);
        state.velocity = Vector3d(k % 2, 0.0, 0.0);  // what interpolation over two samples would hide
        history.push(state);
    }
    for (int k = 0; k <= 100; ++k) {
        EXPECT_NEAR(history.at(0.01 * k)->velocity.x(), k % 2, 1e-6);
    }
}

TEST(AntennaHistory, ShiftMovesEveryEntry) {
    AntennaHistory history;
    for (int k = 0; k < 5; ++k) {
        history.push(state_at(k));
    }
    history.shift({1.0, 2.0, 3.0}, {10.0, 20.0, 30.0});
    for (const double time : {0.0, 1.5, 4.0}) {
        EXPECT_LT((history.at(time)->velocity - state_at(time).velocity - Vector3d(1.0, 2.0, 3.0)).norm(),
                  1e-12);
        const Vector3d moved = earth::displacement(state_at(time).position, history.at(time)->position);
        EXPECT_LT((moved - Vector3d(10.0, 20.0, 30.0)).norm(), 1e-3);
    }
}

TEST(AntennaHistory, TurnTurnsAttitudeAndLeverArmOfEveryEntry) {
    // A body that turns at 0.2 rad/s about up, antenna 5 m forward.
    const auto turning = [](double time) {
        AntennaState state = state_at(time);
        state.q_bn = Eigen::AngleAxisd(0.2 * time, Vector3d::UnitZ());
        state.omega_eb_b = {0.0, 0.0, 0.2};
        state.lever_velocity = state.q_bn * state.omega_eb_b.cross(Vector3d(0.0, 5.0, 0.0));
        state.velocity += state.lever_velocity;
        return state;
    };
    AntennaHistory history;
    for (int k = 0; k <= 10; ++k) {
        history.push(turning(0.1 * k));
    }
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.3, Vector3d(0.6, 0.0, 0.8)).toRotationMatrix();
    history.turn(R, {});
    for (const double time : {0.0, 0.3, 0.85, 1.0}) {
        const AntennaState before = turning(time);
        const auto after = history.at(time);
        ASSERT_TRUE(after);
        EXPECT_LT((after->q_bn.toRotationMatrix() - R * before.q_bn.toRotationMatrix()).norm(), 1e-12)
            << time;
        EXPECT_LT((after->omega_eb_b - before.omega_eb_b).norm(), 1e-12);
        // The lever velocity is interpolated along the chord.
        EXPECT_LT((after->lever_velocity - R * before.lever_velocity).norm(), 1e-4);
        EXPECT_LT((after->velocity - after->lever_velocity - before.velocity + before.lever_velocity).norm(),
                  1e-12);
    }
}

// What it holds must be what it would hold had every entry been changed at every correction: also of entries
// that corrections lie between, and of those that a faster IMU has replaced.
TEST(AntennaHistory, CorrectionsBetweenEntriesConcernTheOlderOnesAlone) {
    for (const double dt : {0.1, 0.004}) {
        AntennaHistory history;
        std::vector<AntennaState> kept;
        for (int k = 0; k <= 20; ++k) {
            AntennaState state = state_at(dt * k);
            state.lever_velocity = Vector3d(0.3, 0.01 * k, -0.2);
            state.q_bn = Eigen::AngleAxisd(0.05 * k, Vector3d(0.6, 0.0, 0.8));
            history.push(state);
            kept.push_back(state);
            if (k % 3 == 0) {
                const Eigen::Quaterniond R(Eigen::AngleAxisd(0.1 + 0.01 * k, Vector3d(0.0, 0.8, 0.6)));
                const Vector3d dv(0.1, 0.02 * k, -0.3);
                const Vector3d dp(3.0, -2.0, 0.1 * k);
                history.turn(R.toRotationMatrix(), {});
                history.shift(dv, dp);
                for (AntennaState& entry : kept) {
                    const Vector3d lever_velocity = R * entry.lever_velocity;
                    entry.velocity += lever_velocity - entry.lever_velocity + dv;
                    entry.lever_velocity = lever_velocity;
                    entry.q_bn = R * entry.q_bn;
                    entry.position = earth::displaced(entry.position, dp);
                }
            }
        }
        int found = 0;
        for (const AntennaState& entry : kept) {
            const auto there = history.at(entry.time);
            ASSERT_TRUE(there) << entry.time;
            if ((there->q_bn.coeffs() - entry.q_bn.coeffs()).norm() > 1e-3) {
                continue;  // replaced by a later sample: interpolated
            }
            ++found;
            EXPECT_LT((there->velocity - entry.velocity).norm(), 1e-12) << entry.time;
            EXPECT_LT((there->lever_velocity - entry.lever_velocity).norm(), 1e-12) << entry.time;
            EXPECT_LT((there->q_bn.coeffs() - entry.q_bn.coeffs()).norm(), 1e-12) << entry.time;
            EXPECT_LT(earth::displacement(entry.position, there->position).norm(), 1e-4) << entry.time;
        }
        EXPECT_GE(found, dt > AntennaHistory::kSpacing ? 21 : 7);
    }
}

}  // namespace
}  // namespace truenorth
