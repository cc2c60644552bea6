// Steps and parameters that the plant refuses, and what it says then.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include "components/truth_plant.hpp"
#include "contract/invalid_parameter.hpp"
#include "truth_plant_fixture.hpp"

namespace truenorth {
namespace {

using truth_plant::GnssFaultKind;
using truth_plant::ImuFaultKind;
using truth_plant::MotionKind;
using truth_plant::Parameters;

std::string refusal(const std::function<void()>& action) {
    try {
        action();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST_F(TruthPlantTest, RefusesStepsThatAreNoWholeNumberOfImuPeriods) {
    plant_.initialise(0.0);
    EXPECT_EQ(
        refusal([&] { plant_.step(0.0, 0.015); }),
        "communication step of 0.015 s: must be a whole number of IMU periods of 0.01 s (imu.rate = 100)");
    EXPECT_THROW(plant_.step(0.0, -0.01), std::invalid_argument);
    EXPECT_THROW(plant_.step(0.0, std::nan("")), std::invalid_argument);
    EXPECT_EQ(plant_.outputs.imu.sample, 0);
}

TEST_F(TruthPlantTest, RefusesStepsFromAnotherTime) {
    plant_.initialise(2.0);
    plant_.step(2.0, 0.01);
    EXPECT_EQ(refusal([&] { plant_.step(2.0, 0.01); }),
              "communication step from 2 s: must begin at 2.01 s, where the last one ended");
}

TEST_F(TruthPlantTest, AcceptsTimesThatAMasterSummedUp) {
    plant_.initialise(0.0);
    double time = 0.0;
    for (int k = 0; k < 100000; ++k) {
        plant_.step(time, 0.01);
        time += 0.01;
    }
    EXPECT_EQ(plant_.outputs.imu.time, 1000.0);
}

// Rounding makes each of these steps 2e-8 s too long.
TEST_F(TruthPlantTest, AcceptsTimesThatAMasterSummedUpFromAnEpoch) {
    plant_.parameters.imu.rate = 400.0;
    plant_.initialise(1.4e9);
    double time = 1.4e9;
    for (int k = 0; k < 60 * 400; ++k) {
        plant_.step(time, 0.0025);
        time += 0.0025;
    }
    EXPECT_EQ(plant_.outputs.imu.time, 1.4e9 + 60.0);
    EXPECT_THROW(plant_.step(time + 0.0025, 0.0025), std::invalid_argument);
    EXPECT_THROW(plant_.step(time - 0.0025, 0.0025), std::invalid_argument);
    EXPECT_NO_THROW(plant_.step(time, 0.0025));
}

// No refused step: the motion was under way, and the run ends there.
TEST_F(TruthPlantTest, BreaksDownAtAPole) {
    plant_.parameters.motion.latitude = 1.57;
    plant_.parameters.motion.course = std::numbers::pi;
    plant_.initialise(0.0);
    EXPECT_NO_THROW(plant_.step(0.0, 1.0));
    plant_.parameters.motion.course = 0.0;
    plant_.initialise(0.0);
    EXPECT_THROW(plant_.step(0.0, 1.0), std::runtime_error);
    plant_.initialise(0.0);
    const std::string reason = refusal([&] { plant_.step(0.0, 1.0); });
    EXPECT_TRUE(reason.starts_with("the motion has come to latitude 1.57000")) << reason;
    EXPECT_TRUE(
        reason.ends_with(" rad at 0.01 s: must stay within 1.57 rad, the local-level frame excludes "
                         "the poles"))
        << reason;
}

struct Refusal {
    std::function<void(Parameters&)> change;
    std::string sentence;
};

class RefusedParameter : public TruthPlantTest, public testing::WithParamInterface<Refusal> {};

TEST_P(RefusedParameter, IsNamedWithItsValueAndTheRule) {
    GetParam().change(plant_.parameters);
    EXPECT_THROW(plant_.initialise(0.0), InvalidParameter);
    EXPECT_EQ(refusal([&] { plant_.initialise(0.0); }), GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, RefusedParameter,
    testing::Values(
        Refusal{[](Parameters& p) { p.imu.rate = 0.0; }, "imu.rate = 0: must be greater than 0"},
        Refusal{[](Parameters& p) { p.motion.latitude = 1.6; },
                "motion.latitude = 1.6: must be at most 1.57"},
        Refusal{[](Parameters& p) { p.gnss.rate = 3.0; },
                "gnss.rate = 3: must be imu.rate (100) divided by a whole number"},
        Refusal{[](Parameters& p) {
                    p.imu.rate = 0.5;
                    p.motion.sway.period.setConstant(100.0);
                },
                "gnss.rate = 1: must be imu.rate (0.5) divided by a whole number"},
        Refusal{[](Parameters& p) { p.gnss.latency = 40.0; },
                "gnss.latency = 40: must be at most 31 periods of gnss.rate (31)"},
        Refusal{[](Parameters& p) {
                    p.gnss.latency = 1.0;
                    p.fault.gnss = {.kind = GnssFaultKind::latency, .size = 30.5};
                },
                "fault.gnss.size = 30.5: must be from 0 to 31 periods of gnss.rate less gnss.latency (30) "
                "where fault.gnss.kind is latency"},
        Refusal{[](Parameters& p) { p.fault.gnss = {.kind = GnssFaultKind::latency, .size = -1.0}; },
                "fault.gnss.size = -1: must be from 0 to 31 periods of gnss.rate less gnss.latency (31) "
                "where fault.gnss.kind is latency"},
        Refusal{[](Parameters& p) { p.fault.gnss.kind = GnssFaultKind::drift; },
                "fault.gnss.size = 0: must be other than 0 for a fault.gnss.kind that has a size"},
        Refusal{[](Parameters& p) { p.fault.imu.kind = ImuFaultKind::clock_step; },
                "fault.imu.size = 0: must be other than 0 for a fault.imu.kind that has a size"},
        Refusal{[](Parameters& p) { p.fault.imu = {.kind = ImuFaultKind::count_jump, .size = 0.5}; },
                "fault.imu.size = 0.5: must be a whole number of 32 bits where fault.imu.kind is count_jump"},
        Refusal{[](Parameters& p) { p.fault.imu = {.kind = ImuFaultKind::count_jump, .size = 3e9}; },
                "fault.imu.size = 3e+09: must be a whole number of 32 bits where fault.imu.kind is "
                "count_jump"},
        Refusal{[](Parameters& p) { p.fault.imu.axis = 7; }, "fault.imu.axis = 7: must be at most 6"},
        Refusal{[](Parameters& p) { p.fault.gnss.axis = -1; }, "fault.gnss.axis = -1: must be at least 0"},
        Refusal{[](Parameters& p) { p.fault.gnss.duration = -1.0; },
                "fault.gnss.duration = -1: must be at least 0"},
        Refusal{[](Parameters& p) { p.gnss.outage.begin[2] = 5.0; },
                "gnss.outage.end[3] = 0: must be at least gnss.outage.begin[3] (5)"},
        Refusal{[](Parameters& p) { p.gnss.noise_scale.step.end = 1.0; },
                "gnss.noise_scale.step.end = 1: must be at least gnss.noise_scale.step.begin (600)"},
        Refusal{[](Parameters& p) { p.gnss.noise_scale.sine.end = 1.0; },
                "gnss.noise_scale.sine.end = 1: must be at least gnss.noise_scale.sine.begin (2400)"},
        Refusal{[](Parameters& p) { p.gnss.outlier_epoch.largest = 5.0; },
                "gnss.outlier_epoch.largest = 5: must be at least gnss.outlier_epoch.least (10)"},
        Refusal{[](Parameters& p) { p.gnss.satellite_limit.begin = 5.0; },
                "gnss.satellite_limit.end = 0: must be at least gnss.satellite_limit.begin (5)"},
        Refusal{[](Parameters& p) { p.gnss.satellite_limit.count = 13; },
                "gnss.satellite_limit.count = 13: must be at most 12"},
        Refusal{[](Parameters& p) {
                    p.motion.kind = MotionKind::flight;
                    p.motion.segment.duration[3] = 2.0;
                    p.motion.segment.acceleration[3] = -5.5;
                },
                "motion.segment.acceleration[4] = -5.5: must be at least what stops the aircraft (-5)"},
        Refusal{[](Parameters& p) {
                    p.motion.kind = MotionKind::flight;
                    p.motion.speed = 100.0;
                    p.motion.segment.duration.head<2>().setConstant(2.0);
                    p.motion.segment.climb_angle[0] = 0.2;
                },
                "motion.segment.climb_angle[2] = 0: must be reached in more than motion.segment.duration[2] "
                "(2): the push-over would be weightless"},
        Refusal{[](Parameters& p) {
                    p.imu.rate = 10.0;
                    p.motion.sway.period[1] = 0.2;
                },
                "motion.sway.period[2] = 0.2: must be greater than two IMU periods (0.2)"},
        Refusal{[](Parameters& p) {
                    p.imu.rate = 10.0;
                    p.motion.wave.velocity[2] = 1.0;
                    p.motion.wave.period[2] = 0.1;
                },
                "motion.wave.period[3] = 0.1: must be greater than two IMU periods (0.2)"},
        Refusal{[](Parameters& p) {
                    p.motion.kind = MotionKind::parked_vehicle;
                    p.motion.vibration.frequency[0] = 50.0;
                },
                "motion.vibration.frequency[1] = 50: must be less than half of imu.rate (50)"}));

TEST_F(TruthPlantTest, AnAircraftMayStopAndStandStill) {
    Parameters& parameters = plant_.parameters;
    parameters.motion.kind = MotionKind::flight;
    parameters.motion.speed = 10.0;
    parameters.motion.segment.duration.head<3>().setConstant(30.0);
    parameters.motion.segment.acceleration.head<2>() = Eigen::Vector2d(3.1, -(10.0 + 93.0) / 30.0);
    plant_.initialise(0.0);
    EXPECT_NO_THROW(run(plant_, 0, 10000, 100));
    EXPECT_LT(plant_.outputs.truth.velocity.norm(), 1e-12);
}

TEST_F(TruthPlantTest, OscillationsThatAreOffMayHaveAnyPeriod) {
    plant_.parameters.imu.rate = 1.0;
    plant_.parameters.motion.sway.amplitude.setZero();
    plant_.parameters.motion.sway.period.setConstant(0.1);
    EXPECT_NO_THROW(plant_.initialise(0.0));
}

}  // namespace
}  // namespace truenorth
