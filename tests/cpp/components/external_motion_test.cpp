// A plant whose vehicle somebody else moves: fed with the truth of a plant that moves its own, it must
// measure the same.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "components/truth_plant.hpp"
#include "inertial/mechanisation.hpp"
#include "truth_plant_fixture.hpp"

namespace truenorth {
namespace {

using truth_plant::ImuFaultKind;
using truth_plant::MotionKind;
using truth_plant::Outputs;
using External = truth_plant::Inputs::External;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kArcsecond = std::numbers::pi / 180.0 / 3600.0;

External state(const Outputs& outputs) {
    const auto& truth = outputs.truth;
    External external;
    external.position = {truth.latitude, truth.longitude, truth.height};
    external.velocity = truth.velocity;
    external.attitude = {truth.roll, truth.pitch, truth.heading};
    return external;
}

// The derivatives that the truth does not show: those of the ship that the parameters declare.
void add_rates(External& external, const truth_plant::Parameters::Motion& motion, double time) {
    const plant::Ship ship{
        .course = motion.course,
        .speed = motion.speed,
        .sway = {.amplitude = motion.sway.amplitude,
                 .frequency = motion.sway.period.cwiseInverse(),
                 .phase = motion.sway.phase},
        .wave = {.amplitude = motion.wave.velocity,
                 .frequency = motion.wave.period.cwiseInverse(),
                 .phase = motion.wave.phase},
    };
    const plant::Kinematics now = ship.at(time);
    external.acceleration = now.acceleration;
    external.body_rate = now.omega_nb_b;
}

// Two plants with the same sensors: `source_` moves the ship, `plant_` is told.
class ExternalMotion : public TruthPlantTest {
  protected:
    Lines source_log_;
    TruthPlant source_{source_log_};
    bool with_rates_ = true;
    int now_ = 0;  // IMU periods

    void start() {
        plant_.parameters = source_.parameters;
        plant_.parameters.motion = {};
        plant_.parameters.motion.kind = MotionKind::external;
        source_.initialise(0.0);
        tell();
        plant_.initialise(0.0);
    }

    [[nodiscard]] double time(int periods) const { return periods / source_.parameters.imu.rate; }

    void tell() {
        plant_.inputs.external = state(source_.outputs);
        if (with_rates_) {
            add_rates(plant_.inputs.external, source_.parameters.motion, time(now_));
        }
    }

    // The vehicle is stepped before the plant, and stamps its state.
    void step_after(int periods) {
        run(source_, now_, now_ + periods, periods);
        now_ += periods;
        tell();
        plant_.inputs.external.time = time(now_);
        run(plant_, now_ - periods, now_, periods);
    }

    // All at once: the plant sees the state at the beginning of the step, without a stamp.
    void step_beside(int periods) {
        tell();
        run(plant_, now_, now_ + periods, periods);
        run(source_, now_, now_ + periods, periods);
        now_ += periods;
    }

    void expect_same(const Outputs& expected, double angle = 1e-9, double velocity = 1e-9) {
        const Outputs& got = plant_.outputs;
        ASSERT_EQ(got.imu.sample, expected.imu.sample);
        ASSERT_EQ(got.imu.time, expected.imu.time);
        ASSERT_LT((got.imu.delta_angle - expected.imu.delta_angle).norm(), angle);
        ASSERT_LT((got.imu.delta_velocity - expected.imu.delta_velocity).norm(), velocity);
        ASSERT_EQ(got.gnss.sample, expected.gnss.sample);
        ASSERT_EQ(got.gnss.time, expected.gnss.time);
        ASSERT_NEAR(got.gnss.latitude, expected.gnss.latitude, 1e-14);
        ASSERT_NEAR(got.gnss.longitude, expected.gnss.longitude, 1e-14);
        ASSERT_NEAR(got.gnss.height, expected.gnss.height, 1e-7);
        ASSERT_LT((got.gnss.velocity - expected.gnss.velocity).norm(), 1e-7);
        ASSERT_EQ(got.truth.time, expected.truth.time);
        ASSERT_NEAR(got.truth.latitude, expected.truth.latitude, 1e-15);
        ASSERT_NEAR(got.truth.height, expected.truth.height, 1e-9);
        ASSERT_NEAR(wrap_angle(got.truth.heading - expected.truth.heading), 0.0, 1e-13);
        ASSERT_EQ(got.truth.gyro_bias, expected.truth.gyro_bias);
    }
};

TEST_F(ExternalMotion, FedWithTheTruthOfTheSwayingShipGivesItsIncrements) {
    for (const bool with_rates : {true, false}) {
        with_rates_ = with_rates;
        now_ = 0;
        start();
        if (!with_rates) {
            step_after(1);  // straight on, as no point before is known
            ASSERT_NO_FATAL_FAILURE(expect_same(source_.outputs, 1e-9, 1e-7));
        }
        while (now_ < 60 * 100) {
            step_after(1);
            ASSERT_NO_FATAL_FAILURE(expect_same(source_.outputs)) << "sample " << now_;
        }
        EXPECT_EQ(plant_.outputs.external.rejected, 0);
    }
}

TEST_F(ExternalMotion, WithoutAStampItMeasuresTheSameOneStepLater) {
    switch_everything_on(source_.parameters);
    source_.parameters.motion.turn = {};
    start();
    step_beside(1);
    EXPECT_EQ(plant_.outputs.imu.sample, 0);
    EXPECT_EQ(plant_.outputs.imu.time, 0.0);
    while (now_ < 10 * 100) {
        const Outputs before = source_.outputs;
        step_beside(1);
        ASSERT_NO_FATAL_FAILURE(expect_same(before, 2e-6, 2e-5)) << "sample " << now_;  // one count
    }
}

// A row of the table in docs/fmus.md: states and steps this many IMU periods apart, and by how much the
// increments of a step may be off; of the first one, which goes straight on where no rates are told.
struct Row {
    int periods;
    bool with_rates;
    double angle, velocity, first_angle, first_velocity;
};

class InterpolatesTheShipInWaves : public ExternalMotion, public testing::WithParamInterface<Row> {};

TEST_P(InterpolatesTheShipInWaves, WithinWhatThePageSays) {
    const auto& [periods, with_rates, angle, velocity, first_angle, first_velocity] = GetParam();
    make_perfect(source_.parameters);
    source_.parameters.motion.wave.velocity.setConstant(0.5);
    with_rates_ = with_rates;
    start();
    step_after(periods);
    ASSERT_NO_FATAL_FAILURE(expect_same(source_.outputs, first_angle, first_velocity));
    while (now_ < 60 * 100) {
        step_after(periods);
        ASSERT_NO_FATAL_FAILURE(expect_same(source_.outputs, angle, velocity)) << now_;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Rows, InterpolatesTheShipInWaves,
    testing::Values(Row{1, true, 1e-14, 1e-12, 1e-14, 1e-12},  // rounding
                    Row{1, false, 4e-12, 4e-10, 9e-10, 4e-8}, Row{10, true, 3e-10, 1e-8, 3e-10, 1e-8},
                    Row{10, false, 4e-8, 4e-6, 9e-7, 4e-5}, Row{50, true, 7e-7, 4e-5, 7e-7, 4e-5},
                    Row{50, false, 2e-5, 2e-3, 2e-4, 6e-3}, Row{100, true, 3e-5, 1e-3, 3e-5, 1e-3},
                    Row{100, false, 4e-4, 0.03, 8e-4, 0.05}));

// The plant at 100 Hz, the vehicle at 10 Hz: stepped first, it is ahead and the plant makes its samples in
// time; stepped later, or without stamps, its states come late and the samples of a period come together.
TEST_F(ExternalMotion, ASlowVehicleIsFollowedAtTheRateOfTheImu) {
    make_perfect(source_.parameters);
    start();
    TruthPlant fine(source_log_);
    fine.parameters = source_.parameters;
    fine.initialise(0.0);
    while (now_ < 1000) {
        run(source_, now_, now_ + 10, 10);
        now_ += 10;
        tell();
        plant_.inputs.external.time = time(now_);
        for (int k = now_ - 10; k < now_; ++k) {
            run(plant_, k, k + 1);
            run(fine, k, k + 1);
            ASSERT_EQ(plant_.outputs.imu.time, fine.outputs.imu.time);
            // The rate within a passage of 0.1 s is off by h^3 / 125 of the fourth derivatives of the angles,
            // 0.05, 0.02 and 0.1 rad/s4: 9e-9 rad in 10 ms, besides what the axes share.
            ASSERT_LT((plant_.outputs.imu.delta_angle - fine.outputs.imu.delta_angle).norm(), 2e-8);
            ASSERT_LT((plant_.outputs.imu.delta_velocity - fine.outputs.imu.delta_velocity).norm(), 1e-8);
        }
    }
    EXPECT_EQ(plant_.outputs.external.rejected, 0);
}

TEST_F(ExternalMotion, AStateThatIsHeldIsNotTakenForANewOne) {
    make_perfect(source_.parameters);
    start();
    int samples = 0;
    while (now_ < 1000) {
        const Outputs before = source_.outputs;
        tell();
        for (int k = now_; k < now_ + 10; ++k) {
            run(plant_, k, k + 1);
        }
        run(source_, now_, now_ + 10, 10);
        if (now_ > 0) {
            ASSERT_EQ(plant_.outputs.imu.sample, ++samples);
            ASSERT_EQ(plant_.outputs.imu.time, time(now_));
            ASSERT_LT((plant_.outputs.imu.delta_angle - before.imu.delta_angle).norm(), 1e-9);
        }
        now_ += 10;
    }
    EXPECT_EQ(plant_.outputs.external.rejected, 0);
}

TEST_F(ExternalMotion, ATurningStateThatIsHeldIsNotTakenForANewOne) {
    make_perfect(source_.parameters);
    source_.parameters.motion.speed = 0.0;
    source_.parameters.motion.wave.velocity.setZero();
    start();
    int samples = 0;
    while (now_ < 300) {
        tell();
        for (int k = now_; k < now_ + 10; ++k) {
            run(plant_, k, k + 1);
        }
        run(source_, now_, now_ + 10, 10);
        if (now_ > 0) {
            ASSERT_EQ(plant_.outputs.imu.sample, ++samples);
        }
        now_ += 10;
    }
}

// Stamps beside the grid of the IMU: no increment is lost or counted twice.
TEST_F(ExternalMotion, StatesMayLieBetweenTheSamples) {
    make_perfect(source_.parameters);
    source_.parameters.imu.rate = 1000.0;
    start();
    plant_.parameters.imu.rate = 100.0;
    tell();
    plant_.initialise(0.0);
    TruthPlant direct(source_log_);
    direct.parameters = source_.parameters;
    direct.parameters.imu.rate = 100.0;
    direct.initialise(0.0);
    Eigen::Vector3d turned = Eigen::Vector3d::Zero();
    Eigen::Vector3d expected = Eigen::Vector3d::Zero();
    for (int k = 0; k < 300; ++k) {
        run(source_, now_, now_ + (k % 2 == 0 ? 13 : 7), k % 2 == 0 ? 13 : 7);
        now_ += k % 2 == 0 ? 13 : 7;
        tell();
        plant_.inputs.external.time = time(now_);
        const int before = plant_.outputs.imu.sample;
        run(plant_, k, k + 1);
        if (plant_.outputs.imu.sample > before) {
            turned += plant_.outputs.imu.delta_angle;
        }
        run(direct, k, k + 1);
        expected += direct.outputs.imu.delta_angle;
        ASSERT_EQ(plant_.outputs.imu.time, direct.outputs.imu.time);
        ASSERT_LT((turned - expected).norm(), 1e-10);
    }
}

// What is put out as the truth is what the increments integrate to, however coarsely the states come.
TEST_F(ExternalMotion, TheMechanisationOfTheIncrementsFindsTheTruth) {
    make_perfect(source_.parameters);
    source_.parameters.motion.wave.velocity.setConstant(0.5);
    for (const bool with_rates : {true, false}) {
        with_rates_ = with_rates;
        now_ = 0;
        start();
        const auto& truth = plant_.outputs.truth;
        const auto attitude = [&] {
            return Eigen::Quaterniond(
                dcm({.roll = truth.roll, .pitch = truth.pitch, .heading = truth.heading}));
        };
        Mechanisation mechanisation(
            {.q_bn = attitude(),
             .velocity = truth.velocity,
             .position = {.latitude = truth.latitude, .longitude = truth.longitude, .height = truth.height}});
        double worst_attitude = 0.0;
        double worst_velocity = 0.0;
        while (now_ < 600 * 100) {
            if (now_ % 10 == 0) {
                run(source_, now_, now_ + 10, 10);
                now_ += 10;
                tell();
                plant_.inputs.external.time = time(now_);
                now_ -= 10;
            }
            run(plant_, now_, now_ + 1);
            ++now_;
            mechanisation.advance({.dt = 0.01,
                                   .delta_angle = plant_.outputs.imu.delta_angle,
                                   .delta_velocity = plant_.outputs.imu.delta_velocity});
            const auto off = rotation_vector(attitude().conjugate() * mechanisation.state.q_bn).norm();
            worst_attitude = std::max(worst_attitude, off);
            worst_velocity = std::max(worst_velocity, (mechanisation.state.velocity - truth.velocity).norm());
        }
        // Two samples compensate coning where the rate is smooth; without rates it leaps a little at a state.
        EXPECT_LT(worst_attitude, (with_rates ? 1e-3 : 2e-3) * kArcsecond);
        EXPECT_LT(worst_velocity, 1e-5);
    }
}

TEST_F(ExternalMotion, FaultsAndAidsAreThoseOfAnyMotion) {
    make_perfect(source_.parameters);
    source_.parameters.body_velocity.rate = 5.0;
    source_.parameters.heading_aid.rate = 2.0;
    source_.parameters.height_aid.rate = 1.0;
    source_.parameters.fault.imu = {.kind = ImuFaultKind::silence, .begin = 2.0, .duration = 1.0};
    source_.parameters.gnss.outage.begin[0] = 4.0;
    source_.parameters.gnss.outage.end[0] = 6.0;
    source_.parameters.gnss.lever_arm = {1.0, 2.0, 3.0};
    start();
    while (now_ < 1000) {
        step_after(1);
        ASSERT_NO_FATAL_FAILURE(expect_same(source_.outputs)) << now_;
        const auto& got = plant_.outputs;
        const auto& expected = source_.outputs;
        ASSERT_EQ(got.body_velocity.sample, expected.body_velocity.sample);
        ASSERT_LT((got.body_velocity.velocity - expected.body_velocity.velocity).norm(), 1e-12);
        ASSERT_NEAR(got.heading_aid.heading, expected.heading_aid.heading, 1e-12);
        ASSERT_NEAR(got.height_aid.height, expected.height_aid.height, 1e-9);
    }
    EXPECT_EQ(plant_.outputs.gnss.sample, 8);  // two of ten are lost
}

TEST_F(ExternalMotion, ARestoredPlantContinuesToTheBit) {
    with_rates_ = false;
    switch_everything_on(source_.parameters);
    start();
    while (now_ < 235) {
        step_after(5);
    }
    plant_.inputs.external.position[0] = 1.0;  // a leap that is doubted
    plant_.inputs.external.time = time(now_ + 1);
    run(plant_, now_, now_ + 5, 5);
    std::stringstream stream;
    cereal::BinaryOutputArchive{stream}(plant_);
    TruthPlant restored(log_);
    cereal::BinaryInputArchive{stream}(restored);
    now_ += 5;
    run(source_, now_ - 5, now_, 5);
    while (now_ < 600) {
        step_after(5);
        restored.inputs = plant_.inputs;
        run(restored, now_ - 5, now_, 5);
        ASSERT_EQ(bytes(restored.outputs), bytes(plant_.outputs)) << now_;
    }
    EXPECT_EQ(plant_.outputs.external.rejected, 1);
    EXPECT_EQ(plant_.outputs.imu.time, 6.0);
}

TEST_F(ExternalMotion, AVehicleThatIsNotThereIsWaitedFor) {
    make_perfect(plant_.parameters);
    plant_.parameters.motion.kind = MotionKind::external;
    plant_.parameters.motion.latitude = 0.5;
    plant_.parameters.motion.course = 1.0;
    plant_.initialise(0.0);
    EXPECT_EQ(plant_.outputs.truth.latitude, 0.5);
    EXPECT_NEAR(plant_.outputs.truth.heading, 1.0, 1e-15);
    run(plant_, 0, 10);
    EXPECT_EQ(plant_.outputs.imu.sample, 0);
    EXPECT_EQ(plant_.outputs.external.rejected, 10);
    EXPECT_EQ(log_.lines.front(),
              "state of the vehicle refused in the step to 0.01 s: external.position[1] = nan: must be from "
              "-1.57 to 1.57");
    EXPECT_EQ(log_.lines.size(), 1U);
    External& external = plant_.inputs.external;
    external.position = {0.6, 2.0, 50.0};
    external.velocity.setZero();
    external.attitude = {0.0, 0.0, -1.0};
    run(plant_, 10, 12);
    EXPECT_EQ(plant_.outputs.imu.sample, 2);  // and not 1: what was before is missing
    EXPECT_EQ(plant_.outputs.imu.time, 0.11);
    EXPECT_NEAR(plant_.outputs.truth.heading, 2.0 * std::numbers::pi - 1.0, 1e-15);
    EXPECT_NEAR(plant_.outputs.imu.delta_velocity.z(), 0.01 * earth::gravity(0.6, 50.0), 1e-12);
}

struct Spoilt {
    void (*spoil)(External&);
    std::string sentence;
};

class SpoiltState : public ExternalMotion, public testing::WithParamInterface<Spoilt> {};

TEST_P(SpoiltState, IsRefusedCountedAndToldAndTheNextOneGoesOn) {
    make_perfect(source_.parameters);
    start();
    for (int k = 0; k < 100; ++k) {
        step_after(1);
    }
    run(source_, now_, now_ + 1);
    tell();
    plant_.inputs.external.time = time(now_ + 1);
    GetParam().spoil(plant_.inputs.external);
    const std::string before = bytes(plant_.outputs);
    run(plant_, now_, now_ + 1);
    ++now_;
    EXPECT_EQ(plant_.outputs.external.rejected, 1);
    plant_.outputs.external.rejected = 0;
    EXPECT_EQ(bytes(plant_.outputs), before);
    EXPECT_EQ(log_.lines.back(),
              "state of the vehicle refused in the step to 1.01 s: " + GetParam().sentence);
    const Eigen::Vector3d missed = source_.outputs.imu.delta_velocity;
    step_after(1);
    EXPECT_EQ(plant_.outputs.imu.sample, 101);
    EXPECT_EQ(plant_.outputs.imu.time, 1.02);
    EXPECT_LT((plant_.outputs.imu.delta_velocity - source_.outputs.imu.delta_velocity - missed).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(
    Rules, SpoiltState,
    testing::Values(
        Spoilt{[](External& e) { e.velocity[1] = kNaN; },
               "external.velocity[2] = nan: must be from -10000 to 10000"},
        Spoilt{[](External& e) { e.position[0] = 32.0; },
               "external.position[1] = 32: must be from -1.57 to 1.57"},
        Spoilt{[](External& e) { e.position[2] = 1e6; },
               "external.position[3] = 1e+06: must be from -15000 to 1e+05"},
        Spoilt{[](External& e) { e.attitude[1] = 6.0; },
               "external.attitude[2] = 6: must be from -1.571 to 1.571"},
        Spoilt{[](External& e) { e.body_rate[2] = std::numeric_limits<double>::infinity(); },
               "external.body_rate[3] = inf: must be from -100 to 100"},
        Spoilt{[](External& e) { e.acceleration[0] = -2000.0; },
               "external.acceleration[1] = -2000: must be from -1000 to 1000"},
        Spoilt{[](External& e) { e.time = 0.5; },
               "external.time = 0.5: must be from 1 to 61.01 (later than the state before, a minute from the "
               "step)"},
        Spoilt{[](External& e) { e.time = 1.7e9; },
               "external.time = 1.7e+09: must be from 1 to 61.01 (later than the state before, a minute "
               "from the step)"},
        Spoilt{[](External& e) { e.velocity[2] = 20.0; },
               "change of external.velocity = 20: must be from 0 to 10 (1000 m/s2)"},
        Spoilt{[](External& e) { e.attitude[2] += 2.0; },
               "change of external.attitude = 2.0009: must be from 0 to 1 (100 rad/s)"}));

TEST_F(ExternalMotion, AVehicleThatIsPutElsewhereGoesOnFromThere) {
    make_perfect(source_.parameters);
    start();
    for (int k = 0; k < 100; ++k) {
        step_after(1);
    }
    source_.parameters.motion.latitude += 0.01;
    source_.initialise(time(now_));
    for (int k = 0; k < 2; ++k) {
        step_after(1);
    }
    EXPECT_EQ(plant_.outputs.external.rejected, 1);
    EXPECT_EQ(plant_.outputs.truth.latitude, source_.outputs.truth.latitude);
    EXPECT_EQ(plant_.outputs.imu.time, 1.02);
    EXPECT_EQ(plant_.outputs.imu.sample, 102);
    EXPECT_LT((plant_.outputs.imu.delta_angle - source_.outputs.imu.delta_angle).norm(), 1e-9);
}

TEST_F(ExternalMotion, TheFirstStateMayBeCorrectedBeforeTheVehicleMoves) {
    make_perfect(source_.parameters);
    start();
    plant_.inputs.external.position[0] += 0.01;
    plant_.inputs.external.attitude[2] = 1.0;
    plant_.initialise(0.0);
    for (int k = 0; k < 10; ++k) {
        step_beside(1);
    }
    EXPECT_EQ(plant_.outputs.external.rejected, 0);
    EXPECT_EQ(plant_.outputs.imu.sample, 9);
    EXPECT_LT(plant_.outputs.imu.delta_angle.norm(), 0.01);
}

TEST_F(ExternalMotion, InputsAreLookedAtInWholeStepsAlone) {
    start();
    step_after(1);
    const std::string before = bytes(plant_.outputs);
    plant_.inputs.external.position.setConstant(kNaN);
    plant_.step(time(now_), 0.0);
    EXPECT_EQ(bytes(plant_.outputs), before);
}

}  // namespace
}  // namespace truenorth
