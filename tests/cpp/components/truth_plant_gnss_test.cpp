// When fixes come, where the antenna is, what the channels measure.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "components/truth_plant.hpp"
#include "inertial/earth.hpp"
#include "inertial/ecef.hpp"
#include "truth_plant_fixture.hpp"

namespace truenorth {
namespace {

using truth_plant::Outputs;
using truth_plant::Parameters;

// From the start on; the first fix, valid at 1 s, appears with IMU sample number `sample`.
void run_to_first_fix(TruthPlant& plant, int sample) {
    plant.initialise(0.0);
    run(plant, 0, sample - 1);
    EXPECT_EQ(plant.outputs.gnss.sample, 0);
    run(plant, sample - 1, sample);
    EXPECT_EQ(plant.outputs.gnss.sample, 1);
    EXPECT_EQ(plant.outputs.gnss.time, 1.0);
}

TEST_F(TruthPlantTest, FixesComeEveryPeriodFromTheFirstOn) {
    make_perfect(plant_.parameters);
    run_to_first_fix(plant_, 100);
    EXPECT_EQ(plant_.outputs.gnss.latitude, plant_.outputs.truth.latitude);
    EXPECT_EQ(plant_.outputs.gnss.velocity, plant_.outputs.truth.velocity);
    run(plant_, 100, 350);
    EXPECT_EQ(plant_.outputs.gnss.sample, 3);
    EXPECT_EQ(plant_.outputs.gnss.time, 3.0);
}

TEST_F(TruthPlantTest, OfSeveralFixesInAStepTheLastIsPutOutAndAllAreCounted) {
    plant_.initialise(0.0);
    plant_.step(0.0, 3.5);
    EXPECT_EQ(plant_.outputs.gnss.sample, 3);
    EXPECT_EQ(plant_.outputs.gnss.time, 3.0);
    EXPECT_EQ(plant_.outputs.imu.sample, 1);
}

TEST_F(TruthPlantTest, ALateFixIsTheSameFix) {
    TruthPlant late(log_);
    late.parameters.gnss.latency = 0.123;  // appears with the first sample at or after 0.123 s
    run_to_first_fix(plant_, 100);
    run_to_first_fix(late, 113);
    EXPECT_EQ(late.outputs.gnss.latitude, plant_.outputs.gnss.latitude);
    EXPECT_EQ(late.outputs.gnss.velocity, plant_.outputs.gnss.velocity);
}

TEST_F(TruthPlantTest, MoreThanAPeriodOfLatencyKeepsFixesUnderWay) {
    plant_.parameters.gnss.rate = 10.0;
    plant_.parameters.gnss.latency = 3.1;  // the most that is allowed
    plant_.initialise(0.0);
    for (int k = 0; k < 1000; ++k) {
        run(plant_, k, k + 1);
        const int fixes = std::max(0, (k + 1 - 310) / 10);
        ASSERT_EQ(plant_.outputs.gnss.sample, fixes) << "after sample " << k + 1;
        ASSERT_EQ(plant_.outputs.gnss.time, fixes / 10.0);
    }
}

TEST_F(TruthPlantTest, AnOutageLosesFixesAndLeavesTheOthersAsTheyWere) {
    TruthPlant dark(log_);
    dark.parameters.gnss.outage.begin[0] = 3.0;
    dark.parameters.gnss.outage.end[0] = 6.0;
    plant_.initialise(0.0);
    dark.initialise(0.0);
    run(plant_, 0, 550);
    run(dark, 0, 550);
    EXPECT_EQ(plant_.outputs.gnss.sample, 5);
    EXPECT_EQ(dark.outputs.gnss.sample, 2);
    EXPECT_EQ(dark.outputs.gnss.time, 2.0);
    EXPECT_EQ(log_.lines, (std::vector<std::string>{"fix at 3 s lost: gnss.outage"}));  // one line a minute
    run(plant_, 550, 600);
    run(dark, 550, 600);
    EXPECT_EQ(dark.outputs.gnss.sample, 3);
    EXPECT_EQ(dark.outputs.gnss.velocity, plant_.outputs.gnss.velocity);
    EXPECT_EQ(dark.outputs.gnss.longitude, plant_.outputs.gnss.longitude);
}

// Of the truth or of a fix.
template <class Group>
earth::Position place(const Group& group) {
    return {.latitude = group.latitude, .longitude = group.longitude, .height = group.height};
}

TEST_F(TruthPlantTest, TheAntennaIsAtTheEndOfTheLeverArm) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.gnss.lever_arm = {0.0, 0.0, 20.0};
    parameters.motion.sway.amplitude = {0.1, 0.0, 0.0};
    plant_.initialise(0.0);
    run(plant_, 0, 100);
    const auto& truth = plant_.outputs.truth;
    const auto& gnss = plant_.outputs.gnss;
    const Eigen::Vector3d offset = earth::displacement(place(truth), place(gnss));
    EXPECT_LT((offset - 20.0 * Eigen::Vector3d(std::sin(truth.roll), 0.0, std::cos(truth.roll))).norm(),
              1e-6);
    const double omega = 2.0 * std::numbers::pi / 8.0;
    const double roll_rate = 0.1 * omega * std::cos(omega * 1.0 + 0.3);
    const Eigen::Vector3d swing =
        20.0 * roll_rate * Eigen::Vector3d(std::cos(truth.roll), 0.0, -std::sin(truth.roll));
    EXPECT_LT((gnss.velocity - truth.velocity - swing).norm(), 1e-4);  // the transport rate is 2e-6 rad/s
}

// ---------------------------------------------------------------- channels

int valid_channels(const Outputs& outputs) {
    return static_cast<int>(std::ranges::count(outputs.gnss.channel.valid, true));
}

TEST_F(TruthPlantTest, ChannelsComeWithTheFirstFix) {
    plant_.initialise(0.0);
    run(plant_, 0, 99);
    EXPECT_EQ(valid_channels(plant_.outputs), 0);
    run(plant_, 99, 100);
    EXPECT_GE(valid_channels(plant_.outputs), 4);
    const auto& channel = plant_.outputs.gnss.channel;
    for (std::size_t i = 0; i < channel.valid.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        EXPECT_EQ(channel.valid[i], channel.satellite[i] >= 1 && channel.satellite[i] <= 24);
        EXPECT_EQ(channel.valid[i], channel.pseudorange[row] > 19e6 && channel.pseudorange[row] < 26e6);
        EXPECT_EQ(channel.valid[i], std::abs(channel.satellite_position.row(row).norm() - 26560e3) < 1e-6);
    }
}

// Four satellites and more, without noise, place the antenna and tell the clock bias: least squares by
// Gauss-Newton in Earth-fixed axes, from the centre of the Earth.
TEST_F(TruthPlantTest, PseudorangesPlaceTheAntennaAndTellTheClockBias) {
    Parameters& parameters = plant_.parameters;
    make_perfect(parameters);
    parameters.gnss.latency = 0.2;
    parameters.gnss.lever_arm = {1.0, 2.0, 30.0};
    parameters.gnss.clock.bias = 1000.0;
    parameters.gnss.clock.drift = 10.0;
    plant_.initialise(0.0);
    run(plant_, 0, 520);
    const auto& gnss = plant_.outputs.gnss;
    Eigen::Vector4d solution = Eigen::Vector4d::Zero();  // antenna, clock bias
    for (int iteration = 0; iteration < 20; ++iteration) {
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Eigen::Vector4d right = Eigen::Vector4d::Zero();
        for (std::size_t i = 0; i < gnss.channel.valid.size(); ++i) {
            if (gnss.channel.valid[i]) {
                const auto row = static_cast<Eigen::Index>(i);
                const Eigen::Vector3d sight =
                    gnss.channel.satellite_position.row(row).transpose() - solution.head<3>();
                const Eigen::Vector4d gradient(-sight.x() / sight.norm(), -sight.y() / sight.norm(),
                                               -sight.z() / sight.norm(), 1.0);
                normal += gradient * gradient.transpose();
                right += gradient * (gnss.channel.pseudorange[row] - sight.norm() - solution[3]);
            }
        }
        solution += normal.inverse() * right;
    }
    EXPECT_EQ(gnss.time, 5.0);
    EXPECT_LT((solution.head<3>() - ecef::coordinates(place(gnss))).norm(), 1e-5);
    EXPECT_NEAR(solution[3], 1000.0 + 10.0 * 5.0, 1e-5);
}

TEST_F(TruthPlantTest, TheTrueClockRunsOnBetweenTheFixes) {
    plant_.parameters.gnss.clock.bias = 7.0;
    plant_.parameters.gnss.clock.drift = 2.0;
    plant_.initialise(3.0);
    const auto& truth = plant_.outputs.truth;
    EXPECT_EQ(truth.clock_bias, 7.0);
    for (int k = 0; k < 250; ++k) {
        plant_.step(3.0 + k / 100.0, 0.01);
        ASSERT_NEAR(truth.clock_bias, 7.0 + 2.0 * (k + 1) / 100.0, 1e-12);
        ASSERT_EQ(truth.clock_drift, 2.0);
    }
}

TEST_F(TruthPlantTest, FewSatellitesAreReceivedWhileALimitLasts) {
    plant_.parameters.gnss.satellite_limit = {.count = 3, .begin = 3.0, .end = 6.0};
    plant_.initialise(0.0);
    for (int second = 1; second <= 8; ++second) {
        run(plant_, 100 * (second - 1), 100 * second);
        const bool few = second >= 3 && second < 6;
        EXPECT_EQ(valid_channels(plant_.outputs) == 3, few) << "t = " << second;
        EXPECT_EQ(plant_.outputs.gnss.sample, second);
    }
}

}  // namespace
}  // namespace truenorth
