// A fault disturbs what it is meant to disturb while it lasts, and nothing else.
#include <gtest/gtest.h>

#include <cereal/archives/binary.hpp>
#include <cmath>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "components/truth_plant.hpp"
#include "inertial/earth.hpp"
#include "truth_plant_fixture.hpp"

namespace truenorth {
namespace {

using truth_plant::GnssFaultKind;
using truth_plant::ImuFaultKind;
using truth_plant::Outputs;
using truth_plant::Parameters;

// Of the IMU or of the receiver, from 2 s to 4 s.
struct Fault {
    ImuFaultKind imu = ImuFaultKind::none;
    GnssFaultKind gnss = GnssFaultKind::none;
    double size = 0.0;
    int axis = 0;
    double duration = 2.0;

    void switch_on(Parameters& parameters) const {
        parameters.fault.imu = {.kind = imu, .begin = 2.0, .duration = duration, .size = size, .axis = axis};
        parameters.fault.gnss = {
            .kind = gnss, .begin = 2.0, .duration = duration, .size = size, .axis = axis % 4};
    }
};

void PrintTo(const Fault& fault, std::ostream* stream) {
    *stream << "IMU kind " << static_cast<int>(fault.imu) << ", GNSS kind " << static_cast<int>(fault.gnss)
            << ", duration " << fault.duration;
}

const std::vector<Fault>& every_fault() {
    static const std::vector<Fault> faults{
        {.imu = ImuFaultKind::silence},
        {.imu = ImuFaultKind::not_a_number, .axis = 3},
        {.imu = ImuFaultKind::spike, .size = 0.3, .axis = 1},
        {.imu = ImuFaultKind::stuck, .axis = 4},
        {.imu = ImuFaultKind::zeros},
        {.imu = ImuFaultKind::bias_step, .size = 1e-3, .axis = 6},
        {.imu = ImuFaultKind::scale_step, .size = 0.1, .axis = 2},
        {.imu = ImuFaultKind::count_jump, .size = 10.0},
        {.imu = ImuFaultKind::clock_step, .size = 1.0},
        {.imu = ImuFaultKind::clock_drift, .size = 1e-3},
        {.imu = ImuFaultKind::repeated},
        {.imu = ImuFaultKind::reordered},
        {.imu = ImuFaultKind::not_a_number, .duration = 0.0},
        {.imu = ImuFaultKind::spike, .size = 0.3, .duration = 0.0},
        {.imu = ImuFaultKind::count_jump, .size = 10.0, .duration = 0.0},
        {.imu = ImuFaultKind::repeated, .duration = 0.0},
        {.imu = ImuFaultKind::reordered, .duration = 0.0},
        {.gnss = GnssFaultKind::silence},
        {.gnss = GnssFaultKind::frozen},
        {.gnss = GnssFaultKind::position_jump, .size = 50.0, .axis = 1},
        {.gnss = GnssFaultKind::drift, .size = 0.5},
        {.gnss = GnssFaultKind::velocity_sign, .axis = 2},
        {.gnss = GnssFaultKind::time_offset, .size = 1.0},
        {.gnss = GnssFaultKind::latency, .size = 0.7},
    };
    return faults;
}

class FaultyPlant : public TruthPlantTest, public testing::WithParamInterface<Fault> {
  protected:
    FaultyPlant() {
        switch_everything_on(plant_.parameters);
        switch_everything_on(sound_.parameters);
        GetParam().switch_on(plant_.parameters);
    }

    // Both plants, one IMU period from sample k on.
    void advance(int k) {
        run(plant_, k, k + 1);
        run(sound_, k, k + 1);
    }

    TruthPlant sound_{log_};
};

INSTANTIATE_TEST_SUITE_P(EveryFault, FaultyPlant, testing::ValuesIn(every_fault()));

TEST_P(FaultyPlant, DiffersFromTheSoundOneInTheFaultySensorAlone) {
    plant_.initialise(0.0);
    sound_.initialise(0.0);
    bool seen = false;
    for (int k = 0; k < 600; ++k) {
        advance(k);
        const bool equal = bytes(plant_.outputs) == bytes(sound_.outputs);
        seen = seen || !equal;
        Outputs others = sound_.outputs;
        if (GetParam().imu != ImuFaultKind::none) {
            others.imu = plant_.outputs.imu;
        } else {
            others.gnss = plant_.outputs.gnss;
        }
        if (GetParam().imu == ImuFaultKind::bias_step) {
            others.truth.accelerometer_bias = plant_.outputs.truth.accelerometer_bias;
        }
        ASSERT_EQ(bytes(plant_.outputs), bytes(others)) << "sample " << k + 1;
        if (k + 1 < 200) {
            ASSERT_TRUE(equal) << "sample " << k + 1;
        }
    }
    EXPECT_TRUE(seen);
}

// Noise is drawn as if there had been no fault; the count and the clock of the IMU and the count of the fixes
// keep what has happened to them.
TEST_P(FaultyPlant, IsSoundAgainAfterwardsToTheBit) {
    plant_.initialise(0.0);
    sound_.initialise(0.0);
    for (int k = 0; k < 600; ++k) {
        advance(k);
        if (k < 500) {  // late fixes of the fault are still under way, or wait for one that is
            continue;
        }
        Outputs outputs = sound_.outputs;
        if (GetParam().imu == ImuFaultKind::count_jump) {
            const int jumps = GetParam().duration > 0.0 ? 200 : 1;
            outputs.imu.sample += 10 * jumps;
        }
        if (GetParam().imu == ImuFaultKind::clock_drift) {
            ASSERT_NEAR(plant_.outputs.imu.time - outputs.imu.time, 2e-3, 1e-12);
            outputs.imu.time = plant_.outputs.imu.time;
        }
        if (GetParam().gnss == GnssFaultKind::silence) {
            outputs.gnss.sample -= 20;
        }
        ASSERT_EQ(bytes(plant_.outputs), bytes(outputs)) << "sample " << k + 1;
    }
}

TEST_P(FaultyPlant, RestoredInTheMiddleItContinuesToTheBit) {
    for (const int middle : {199, 200, 201, 202, 237, 399, 400, 401, 450}) {
        plant_.initialise(0.0);
        run(plant_, 0, middle);
        std::stringstream stream;
        cereal::BinaryOutputArchive{stream}(plant_);
        TruthPlant restored(log_);
        cereal::BinaryInputArchive{stream}(restored);
        for (int k = middle; k < 600; ++k) {
            run(plant_, k, k + 1);
            run(restored, k, k + 1);
            ASSERT_EQ(bytes(restored.outputs), bytes(plant_.outputs)) << "sample " << k + 1;
        }
    }
}

TEST_F(TruthPlantTest, AFaultOfNoKindIsNone) {
    TruthPlant sound(log_);
    switch_everything_on(plant_.parameters);
    switch_everything_on(sound.parameters);
    Fault{.size = 1.0, .axis = 2}.switch_on(plant_.parameters);
    plant_.initialise(0.0);
    sound.initialise(0.0);
    for (int k = 0; k < 600; ++k) {
        run(plant_, k, k + 1);
        run(sound, k, k + 1);
        ASSERT_EQ(bytes(plant_.outputs), bytes(sound.outputs));
    }
}

// Increments of single periods, summed over ten, and those of a step of ten periods; the fault begins and
// ends within a step.
class FaultWithinAStep : public TruthPlantTest, public testing::WithParamInterface<Fault> {};

TEST_P(FaultWithinAStep, ActsOnEachImuPeriod) {
    TruthPlant fine(log_);
    switch_everything_on(fine.parameters);
    GetParam().switch_on(fine.parameters);
    fine.parameters.fault.imu.begin = 2.03;
    fine.parameters.fault.imu.duration = 0.94;
    plant_.parameters = fine.parameters;
    fine.initialise(0.0);
    plant_.initialise(0.0);
    for (int k = 0; k < 400; k += 10) {
        Eigen::Vector3d angle = Eigen::Vector3d::Zero();
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
        for (int i = k; i < k + 10; ++i) {
            run(fine, i, i + 1);
            angle += fine.outputs.imu.delta_angle;
            velocity += fine.outputs.imu.delta_velocity;
        }
        run(plant_, k, k + 10, 10);
        ASSERT_LT((plant_.outputs.imu.delta_angle - angle).norm(), 1e-14);
        ASSERT_LT((plant_.outputs.imu.delta_velocity - velocity).norm(), 1e-13);
        ASSERT_EQ(plant_.outputs.truth.gyro_bias, fine.outputs.truth.gyro_bias);
        ASSERT_EQ(plant_.outputs.truth.accelerometer_bias, fine.outputs.truth.accelerometer_bias);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, FaultWithinAStep,
                         testing::Values(Fault{.imu = ImuFaultKind::spike, .size = 0.3},
                                         Fault{.imu = ImuFaultKind::stuck}, Fault{.imu = ImuFaultKind::zeros},
                                         Fault{.imu = ImuFaultKind::bias_step, .size = 1e-3},
                                         Fault{.imu = ImuFaultKind::scale_step, .size = 0.1}));

TEST_F(TruthPlantTest, ABiasStepIsTrue) {
    make_perfect(plant_.parameters);
    Fault{.imu = ImuFaultKind::bias_step, .size = 1e-4, .axis = 2}.switch_on(plant_.parameters);
    plant_.initialise(0.0);
    const auto forward = [&](int from, int to) {
        run(plant_, from, to);
        EXPECT_EQ(plant_.outputs.truth.accelerometer_bias, Eigen::Vector3d::Zero());
        return plant_.outputs.truth.gyro_bias;
    };
    EXPECT_EQ(forward(0, 199), Eigen::Vector3d::Zero());
    EXPECT_EQ(forward(199, 200), Eigen::Vector3d(0.0, 1e-4, 0.0));
    EXPECT_EQ(forward(200, 400), Eigen::Vector3d::Zero());
}

// Both clocks at once, as a leap second or a receiver that finds its time.
TEST_F(TruthPlantTest, ClockStepAndTimeOffsetTogetherMoveBothStamps) {
    Fault{.imu = ImuFaultKind::clock_step, .gnss = GnssFaultKind::time_offset, .size = 1.0, .duration = 0.0}
        .switch_on(plant_.parameters);
    plant_.initialise(0.0);
    run(plant_, 0, 199);
    EXPECT_EQ(plant_.outputs.imu.time, 1.99);
    EXPECT_EQ(plant_.outputs.gnss.time, 1.0);
    run(plant_, 199, 200);
    EXPECT_EQ(plant_.outputs.imu.time, 3.0);
    EXPECT_EQ(plant_.outputs.gnss.time, 3.0);
    run(plant_, 200, 300);
    EXPECT_EQ(plant_.outputs.imu.time, 4.0);
    EXPECT_EQ(plant_.outputs.gnss.time, 4.0);
}

TEST_F(TruthPlantTest, AClockThatIsOffFromTheStartIsSoAtTheStart) {
    plant_.parameters.fault.imu = {.kind = ImuFaultKind::clock_step, .size = 1.0};
    plant_.initialise(5.0);
    EXPECT_EQ(plant_.outputs.imu.time, 6.0);
}

TEST_F(TruthPlantTest, ASilentReceiverSaysSo) {
    Fault{.gnss = GnssFaultKind::silence}.switch_on(plant_.parameters);
    plant_.initialise(0.0);
    run(plant_, 0, 450);
    EXPECT_EQ(log_.lines, (std::vector<std::string>{"fix at 2 s lost: fault.gnss.kind = silence"}));
    EXPECT_EQ(plant_.outputs.gnss.sample, 2);
    EXPECT_EQ(plant_.outputs.gnss.time, 4.0);
}

// The channels see the displaced antenna: each pseudorange changes by the jump along its line of sight.
TEST_F(TruthPlantTest, AJumpIsSeenByEveryChannel) {
    const Eigen::Vector3d jump(0.0, 0.0, 50.0);
    TruthPlant sound(log_);
    make_perfect(plant_.parameters);
    make_perfect(sound.parameters);
    plant_.parameters.fault.gnss = {
        .kind = GnssFaultKind::position_jump, .begin = 1.0, .size = jump.z(), .axis = 3};
    plant_.initialise(0.0);
    sound.initialise(0.0);
    run(plant_, 0, 100);
    run(sound, 0, 100);
    const auto& gnss = sound.outputs.gnss;
    const earth::Position antenna{
        .latitude = gnss.latitude, .longitude = gnss.longitude, .height = gnss.height};
    int channels = 0;
    for (Eigen::Index i = 0; i < gnss.channel.pseudorange.size(); ++i) {
        if (!gnss.channel.valid[static_cast<std::size_t>(i)]) {
            continue;
        }
        const Eigen::Vector3d satellite = gnss.channel.satellite_position.row(i);
        const Eigen::Vector3d sight = earth::C_en(antenna) * (satellite - earth::ecef(antenna)).normalized();
        EXPECT_NEAR(plant_.outputs.gnss.channel.pseudorange[i] - gnss.channel.pseudorange[i],
                    -jump.dot(sight), 1e-4);  // the curvature of a sphere of 20,000 km
        ++channels;
    }
    EXPECT_GE(channels, 4);
    EXPECT_NEAR(plant_.outputs.gnss.height - gnss.height, jump.z(), 1e-9);
}

TEST_F(TruthPlantTest, LateFixesComeInOrderAndAreThoseThatWereMeasured) {
    TruthPlant sound(log_);
    Fault{.gnss = GnssFaultKind::latency, .size = 1.5}.switch_on(plant_.parameters);
    plant_.initialise(0.0);
    sound.initialise(0.0);
    // Fixes of 2 s and 3 s appear at 3.5 s and 4.5 s; those of 4 s and 5 s come behind them.
    const auto time_at = [&](int from, int to) {
        run(plant_, from, to);
        return plant_.outputs.gnss.time;
    };
    EXPECT_EQ(time_at(0, 349), 1.0);
    EXPECT_EQ(time_at(349, 350), 2.0);
    EXPECT_EQ(plant_.outputs.gnss.sample, 2);
    run(sound, 0, 200);
    EXPECT_EQ(plant_.outputs.gnss.velocity, sound.outputs.gnss.velocity);
    EXPECT_EQ(time_at(350, 449), 2.0);
    EXPECT_EQ(time_at(449, 450), 4.0);
    EXPECT_EQ(plant_.outputs.gnss.sample, 4);
    EXPECT_EQ(time_at(450, 500), 5.0);
}

}  // namespace
}  // namespace truenorth
