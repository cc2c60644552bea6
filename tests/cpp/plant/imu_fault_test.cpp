#include "plant/imu_fault.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

namespace truenorth::plant {
namespace {

using Kind = ImuFault::Kind;
using Axes = ImuFault::Axes;

constexpr double kPeriod = 0.01;

// Of sample k: different on every axis and in every sample.
Axes increments(int k) { return k * (Axes() << 1e-3, 2e-3, 3e-3, 1e-2, 2e-2, 3e-2).finished(); }

Axes increments(const ImuOutput& output) {
    Axes six;
    six << output.delta_angle, output.delta_velocity;
    return six;
}

// What is seen after each of the samples 1 to `count`, an output each; sample 0 is the start.
std::vector<ImuOutput> outputs(const ImuFault::Settings& settings, int count) {
    const ImuFault fault(settings, kPeriod);
    ImuFault::State state;
    std::vector<ImuOutput> seen(1);
    for (int k = 1; k <= count; ++k) {
        ImuOutput fresh{.count = k, .time = k * kPeriod};
        fresh.delta_angle = increments(k).head<3>();
        fresh.delta_velocity = increments(k).tail<3>();
        fault.distort(state, fresh.time, fresh.delta_angle, fresh.delta_velocity);
        seen.push_back(fault.put_out(state, fresh).value_or(seen.back()));
    }
    return seen;
}

// The sample that each output is: its count, after a check that time and increments are of the same sample.
std::vector<int> order(const std::vector<ImuOutput>& seen) {
    std::vector<int> counts;
    for (const ImuOutput& output : seen) {
        const auto k = static_cast<int>(output.count);
        EXPECT_EQ(output.time, k * kPeriod);
        EXPECT_TRUE((increments(output) == increments(k)).all()) << "sample " << k;
        counts.push_back(k);
    }
    return counts;
}

TEST(ImuFault, NoneChangesNothing) {
    EXPECT_EQ(order(outputs({.size = 1.0}, 5)), (std::vector{0, 1, 2, 3, 4, 5}));
}

TEST(ImuFault, SilenceStandsStillAndTheCountGoesOn) {
    EXPECT_EQ(order(outputs({.kind = Kind::silence, .begin = 0.03, .duration = 0.03}, 7)),
              (std::vector{0, 1, 2, 2, 2, 2, 6, 7}));
    EXPECT_EQ(order(outputs({.kind = Kind::silence, .begin = 0.03}, 6)), (std::vector{0, 1, 2, 2, 2, 2, 2}));
}

TEST(ImuFault, AnOutputAfterASilenceLacksTheIncrementsOfIt) {
    const ImuFault fault({.kind = Kind::silence, .begin = 0.02, .duration = 0.02}, kPeriod);
    ImuFault::State state;
    Axes sum = Axes::Zero();
    for (int k = 1; k <= 5; ++k) {  // one step of five samples
        Eigen::Vector3d angle = increments(k).head<3>();
        Eigen::Vector3d velocity = increments(k).tail<3>();
        fault.distort(state, k * kPeriod, angle, velocity);
        sum.head<3>() += angle.array();
        sum.tail<3>() += velocity.array();
    }
    EXPECT_LT((sum - increments(1) - increments(4) - increments(5)).abs().maxCoeff(), 1e-16);
    EXPECT_TRUE(fault.put_out(state, {.count = 1, .time = 5 * kPeriod}).has_value());
}

TEST(ImuFault, RepeatedOutputsTakeThePlaceOfNewOnes) {
    EXPECT_EQ(order(outputs({.kind = Kind::repeated, .begin = 0.03, .duration = 0.04}, 8)),
              (std::vector{0, 1, 2, 2, 4, 4, 6, 7, 8}));
    EXPECT_EQ(order(outputs({.kind = Kind::repeated, .begin = 0.03}, 6)), (std::vector{0, 1, 2, 2, 4, 5, 6}));
}

TEST(ImuFault, ReorderedOutputsComeInSwappedPairs) {
    EXPECT_EQ(order(outputs({.kind = Kind::reordered, .begin = 0.03}, 7)),
              (std::vector{0, 1, 2, 2, 4, 3, 6, 7}));
    EXPECT_EQ(order(outputs({.kind = Kind::reordered, .begin = 0.03, .duration = 0.04}, 9)),
              (std::vector{0, 1, 2, 2, 4, 3, 6, 5, 8, 9}));
}

TEST(ImuFault, TheCountJumpsOnceOrAtEveryOutput) {
    const auto counts = [](const ImuFault::Settings& settings) {
        std::vector<int> counts;
        for (const ImuOutput& output : outputs(settings, 5)) {
            counts.push_back(static_cast<int>(output.count));
        }
        return counts;
    };
    EXPECT_EQ(counts({.kind = Kind::count_jump, .begin = 0.02, .size = 10}),
              (std::vector{0, 1, 12, 13, 14, 15}));
    EXPECT_EQ(counts({.kind = Kind::count_jump, .begin = 0.02, .duration = 0.03, .size = 9}),
              (std::vector{0, 1, 11, 21, 31, 32}));
    EXPECT_EQ(counts({.kind = Kind::count_jump, .begin = 0.02, .size = -2}), (std::vector{0, 1, 0, 1, 2, 3}));
}

TEST(ImuFault, TheClockStepsAndComesBack) {
    const auto seen = outputs({.kind = Kind::clock_step, .begin = 0.02, .duration = 0.02, .size = -0.5}, 5);
    for (int k = 1; k <= 5; ++k) {
        EXPECT_EQ(seen[static_cast<std::size_t>(k)].time, k * kPeriod + (k == 2 || k == 3 ? -0.5 : 0.0));
    }
}

TEST(ImuFault, ADriftingClockKeepsWhatItHasGained) {
    const ImuFault fault({.kind = Kind::clock_drift, .begin = 10.0, .duration = 20.0, .size = 1e-3}, kPeriod);
    EXPECT_EQ(fault.clock(9.0), 9.0);
    EXPECT_DOUBLE_EQ(fault.clock(15.0), 15.005);
    EXPECT_DOUBLE_EQ(fault.clock(30.0), 30.02);
    EXPECT_DOUBLE_EQ(fault.clock(1000.0), 1000.02);
    EXPECT_DOUBLE_EQ(
        ImuFault({.kind = Kind::clock_drift, .begin = 10.0, .size = 1e-3}, kPeriod).clock(1010.0), 1011.0);
}

struct Increment {
    ImuFault::Settings settings;
    // What sample k should be, of the axes that the fault concerns, while it lasts.
    double (*expected)(int k, Eigen::Index axis);
};

class FaultOfTheIncrements : public testing::TestWithParam<Increment> {
  protected:
    static constexpr double kSize = 0.25;
};

// From 0.03 s on, for 0.04 s, on all axes and on each alone.
TEST_P(FaultOfTheIncrements, ConcernsItsAxisWhileItLasts) {
    for (int axis = 0; axis <= 6; ++axis) {
        ImuFault::Settings settings = GetParam().settings;
        settings.begin = 0.03;
        settings.duration = 0.04;
        settings.axis = axis;
        const auto seen = outputs(settings, 9);
        for (int k = 1; k <= 9; ++k) {
            const ImuOutput& output = seen[static_cast<std::size_t>(k)];
            EXPECT_EQ(output.count, k);
            EXPECT_EQ(output.time, k * kPeriod);
            for (Eigen::Index i = 0; i < 6; ++i) {
                const bool concerned = k >= 3 && k < 7 && (axis == 0 || axis - 1 == i);
                const double expected = concerned ? GetParam().expected(k, i) : increments(k)[i];
                const double found = increments(output)[i];
                EXPECT_TRUE(std::isnan(expected) ? std::isnan(found) : std::abs(found - expected) < 1e-16)
                    << "sample " << k << ", axis " << i + 1 << ": " << found << ", not " << expected;
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FaultOfTheIncrements,
    testing::Values(Increment{{.kind = Kind::not_a_number}, [](int, Eigen::Index) { return std::nan(""); }},
                    Increment{{.kind = Kind::zeros}, [](int, Eigen::Index) { return 0.0; }},
                    Increment{{.kind = Kind::stuck}, [](int, Eigen::Index i) { return increments(2)[i]; }},
                    Increment{{.kind = Kind::spike, .size = 0.3},
                              [](int k, Eigen::Index i) { return increments(k)[i] + 0.3; }},
                    Increment{{.kind = Kind::bias_step, .size = 0.3},
                              [](int k, Eigen::Index i) { return increments(k)[i] + 0.3 * kPeriod; }},
                    Increment{{.kind = Kind::scale_step, .size = -0.2},
                              [](int k, Eigen::Index i) { return 0.8 * increments(k)[i]; }}));

// Without a duration what happens once happens to one sample, and a state does not end.
TEST(ImuFault, ADurationOfNoneIsOnceOrForEver) {
    const auto faulty = [](Kind kind) {
        std::vector<int> samples;
        const auto seen = outputs({.kind = kind, .begin = 0.025, .size = 0.5}, 6);
        for (int k = 1; k <= 6; ++k) {
            if (!(increments(seen[static_cast<std::size_t>(k)]) == increments(k)).all()) {
                samples.push_back(k);
            }
        }
        return samples;
    };
    for (const Kind kind : {Kind::not_a_number, Kind::spike}) {
        EXPECT_EQ(faulty(kind), std::vector{3});
    }
    for (const Kind kind : {Kind::stuck, Kind::zeros, Kind::bias_step, Kind::scale_step}) {
        EXPECT_EQ(faulty(kind), (std::vector{3, 4, 5, 6}));
    }
}

TEST(ImuFault, ThatBeganBeforeTheStartConcernsTheFirstSample) {
    const auto seen = outputs({.kind = Kind::spike, .begin = -5.0, .size = 1.0}, 2);
    EXPECT_TRUE((increments(seen[1]) == increments(1) + 1.0).all());
    EXPECT_TRUE((increments(seen[2]) == increments(2)).all());
}

TEST(ImuFault, TheBiasIsThatOfTheIncrements) {
    const ImuFault fault({.kind = Kind::bias_step, .begin = 1.0, .duration = 1.0, .size = 0.1, .axis = 5},
                         kPeriod);
    EXPECT_TRUE((fault.bias(0.99) == 0.0).all());
    EXPECT_TRUE((fault.bias(1.0) == (Axes() << 0.0, 0.0, 0.0, 0.0, 0.1, 0.0).finished()).all());
    EXPECT_TRUE((fault.bias(2.0) == 0.0).all());
    EXPECT_TRUE((ImuFault({.kind = Kind::spike, .size = 0.1}, kPeriod).bias(1.0) == 0.0).all());
}

}  // namespace
}  // namespace truenorth::plant
