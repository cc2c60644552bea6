// The invariant model in an AlignmentFilter: any heading, and the coarse stage.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "components/alignment_filter.hpp"
#include "contract/invalid_parameter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using alignment_filter::ErrorModel;
using alignment_filter::Parameters;
using alignment_filter::Predictor;
using alignment_filter::Status;
using Eigen::Vector3d;
using Trial = Session<AlignmentFilter>;

struct FedFilter : Fed<AlignmentFilter> {
    FedFilter() {
        filter.parameters.error_model = ErrorModel::invariant;
        filter.parameters.predictor = Predictor::linearised;
    }
};

// Errors drawn from normal distributions.
class Draws {
  public:
    explicit Draws(unsigned seed) : generator_(seed) {}
    Vector3d operator()(double sigma) {
        return sigma * Vector3d::NullaryExpr([&] { return normal_(generator_); });
    }
    double angle() { return std::uniform_real_distribution<>(0.0, 2.0 * std::numbers::pi)(generator_); }

  private:
    std::mt19937 generator_;
    std::normal_distribution<double> normal_;
};

TEST(AlignmentFilterInvariant, FindsTheSameFromAnyHeadingInTheCoarseStage) {
    const auto heading = [](double error) {
        FedFilter fed;
        Draws draw(1);
        Trial run{.heading_error = error};
        run.fix_noise = [&](int) { return draw(0.1); };
        run.seconds(fed, 200.0);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * fed.filter.outputs.heading_sigma);
        EXPECT_LT(fed.filter.outputs.heading_sigma, 0.6 * kDegree);
        return fed.filter.outputs.nav.heading;
    };
    const double first = heading(0.0);
    EXPECT_EQ(heading(90.0 * kDegree), first);
    EXPECT_EQ(heading(180.0 * kDegree), first);
}

TEST(AlignmentFilterInvariant, ErrsAsItsSigmaSays) {
    // 40 runs: the sum of squared normalised errors is chi-square, of the heading with 40 degrees of freedom,
    // in [16.9, 76.1] with 99.9 % confidence, of the tilts with 80, in [44.8, 128.2]; in the coarse stage
    // (60 s), just after and long after it.
    Draws draw(2026);
    std::array<double, 3> sums{};
    std::array<double, 3> tilts{};
    for (int n = 0; n < 40; ++n) {
        Trial run;
        run.table.heading = draw.angle();
        run.table.gyro_bias = draw(2.4240684e-7);
        run.table.accelerometer_bias = draw(9.80665e-3);
        run.fix_noise = [&](int) { return draw(0.1); };
        FedFilter fed;
        fed.filter.parameters.gate.enabled = false;
        // The sensors have no white noise: what the filter believes of it must be small.
        fed.filter.parameters.process.angle_random_walk = 1e-8;
        fed.filter.parameters.process.velocity_random_walk = 1e-6;
        run.start(fed);
        int begin = 0;
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const int end = std::array{60, 110, 300}[i] * kRate;
            run.advance(fed, begin, end);
            const auto& outputs = fed.filter.outputs;
            sums[i] += std::pow(heading_error_of(fed, run.table) / outputs.heading_sigma, 2);
            const double tilt =
                std::hypot(outputs.nav.roll - run.table.roll, outputs.nav.pitch - run.table.pitch);
            tilts[i] += std::pow(tilt / outputs.misalignment_sigma.head<2>().mean(), 2);
            begin = end;
        }
    }
    for (const double sum : sums) {
        EXPECT_GT(sum, 16.9);
        EXPECT_LT(sum, 76.1);
    }
    for (const double sum : tilts) {
        EXPECT_GT(sum, 44.8);
        EXPECT_LT(sum, 128.2);
    }
}

// Be it the parameters or the fixes that say it, in the coarse stage as after it.
TEST(AlignmentFilterInvariant, BelievesWhatFixesSayOfThemselvesFromTheFirstOn) {
    const auto after = [](double seconds, bool told) {
        constexpr double kPlace = 4.0;
        constexpr double kSpeed = 0.3;
        FedFilter fed;
        Draws draw(7);
        Trial run{.heading_error = 90.0 * kDegree};
        run.fix_noise = [&](int) { return draw(kSpeed); };
        if (told) {
            fed.filter.inputs.gnss.fix_position_sigma.setConstant(kPlace);
            fed.filter.inputs.gnss.fix_velocity_sigma.setConstant(kSpeed);
        } else {
            fed.filter.parameters.measurement.position_sigma = kPlace;
            fed.filter.parameters.measurement.height_sigma = kPlace;
            fed.filter.parameters.measurement.velocity_sigma = kSpeed;
        }
        run.seconds(fed, seconds);
        return fed.filter.outputs;
    };
    for (const double seconds : {30.0, 200.0}) {
        const auto one = after(seconds, true);
        const auto other = after(seconds, false);
        EXPECT_EQ(one.status, other.status) << seconds;
        EXPECT_EQ(one.nav.heading, other.nav.heading) << seconds;
        EXPECT_EQ(one.heading_sigma, other.heading_sigma) << seconds;
        EXPECT_EQ(one.velocity_sigma, other.velocity_sigma) << seconds;
        EXPECT_EQ(one.position_sigma, other.position_sigma) << seconds;
    }
}

TEST(AlignmentFilterInvariant, SaysWhatStageItIsIn) {
    FedFilter fed;
    Draws draw(3);
    Trial run{.heading_error = 120.0 * kDegree};
    run.fix_noise = [&](int) { return draw(0.1); };
    run.seconds(fed, 0.5);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    run.advance(fed, kRate / 2, 50 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::coarse);
    EXPECT_EQ(fed.filter.outputs.used_fixes, 50);
    EXPECT_GT(fed.filter.outputs.heading_sigma, 3.0 * kDegree);
    run.advance(fed, 50 * kRate, 150 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
    EXPECT_EQ(fed.filter.outputs.used_fixes, 150);
    EXPECT_EQ(fed.log.with("coarse stage ends at"), 1);
    run.advance(fed, 150 * kRate, 300 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::converged);
}

// Gyros that are off by as much as the Earth turns, told truthfully.
struct CoarseGyros : FedFilter {
    static constexpr double kBias = 10.0 * kDegree / 3600.0;  // [rad/s]
    static constexpr double kAngleWalk = 1.75e-5;             // [rad/s^0.5]
    static constexpr double kVelocityWalk = 8.3e-4;           // [m/s^1.5]

    CoarseGyros() {
        filter.parameters.prior.gyro_bias_sigma = kBias;
        filter.parameters.process.angle_random_walk = kAngleWalk;
        filter.parameters.process.velocity_random_walk = kVelocityWalk;
    }
};

// At rest the heading cannot be known, and a filter that thinks so waits; an antenna that swings about the
// IMU shows it.
TEST(AlignmentFilterInvariant, WaitsForAMotionWhereGyrosAreTooCoarse) {
    for (const double heading : {0.7, 2.8, -1.9}) {
        CoarseGyros fed;
        Draws draw(7);
        Trial run;
        run.table.heading = heading;
        run.table.gyro_bias = draw(CoarseGyros::kBias);
        run.lever_arm = {1.0, 2.0, 0.5};
        fed.filter.parameters.gnss.lever_arm = run.lever_arm;
        run.fix_noise = [&](int) { return draw(0.1); };
        run.imu_noise = [&](ImuIncrement& increment) {
            increment.delta_angle += draw(CoarseGyros::kAngleWalk * std::sqrt(increment.dt));
            increment.delta_velocity += draw(CoarseGyros::kVelocityWalk * std::sqrt(increment.dt));
        };
        run.start(fed);
        run.advance(fed, 0, 600 * kRate);
        EXPECT_EQ(fed.filter.outputs.status, Status::coarse);
        EXPECT_EQ(fed.log.with("the heading cannot be told yet"), 1);
        EXPECT_GT(fed.filter.outputs.heading_sigma, 30.0 * kDegree);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * fed.filter.outputs.heading_sigma);
        EXPECT_EQ(fed.filter.outputs.rejected_fixes, 0);

        run.table.heading -= 600.0 * 0.3;  // where it is when it begins to turn
        run.table.rate = 0.3;
        run.advance(fed, 600 * kRate, 660 * kRate);
        EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
        EXPECT_EQ(fed.log.with("coarse stage ends at"), 1);
        EXPECT_LT(fed.filter.outputs.heading_sigma, 5.0 * kDegree);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * fed.filter.outputs.heading_sigma);
    }
}

// Fixes that jump away, none of which any heading explains: refused, and if they stay, the stage begins anew.
TEST(AlignmentFilterInvariant, FindsBackFromFixesThatNoHeadingExplains) {
    CoarseGyros fed;
    Draws draw(8);
    Trial run;
    run.table.gyro_bias = draw(CoarseGyros::kBias);
    run.fix_noise = [&](int) { return draw(0.1); };
    run.start(fed);
    run.advance(fed, 0, 300 * kRate);
    ASSERT_EQ(fed.log.with("the heading cannot be told yet"), 1);
    run.fix_noise = [&](int) { return Vector3d(Vector3d(40.0, 0.0, 0.0) + draw(0.1)); };
    run.advance(fed, 300 * kRate, 305 * kRate);
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 5);
    EXPECT_EQ(fed.filter.outputs.status, Status::coarse);
    run.fix_noise = [&](int) { return draw(0.1); };
    run.advance(fed, 305 * kRate, 310 * kRate);
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 5);
    run.table.position.height += 2000.0;
    run.advance(fed, 310 * kRate, 500 * kRate);
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 15);
    EXPECT_EQ(fed.log.with("the heading cannot be told yet"), 2);
    EXPECT_NEAR(fed.filter.outputs.nav.height, run.table.position.height, 5.0);
}

TEST(AlignmentFilterInvariant, NeedsNoCoarseStageFromAKnownSector) {
    for (const auto predictor : {Predictor::linearised, Predictor::unscented, Predictor::augmented}) {
        FedFilter fed;
        fed.filter.parameters.coarse.enabled = false;
        fed.filter.parameters.predictor = predictor;
        fed.filter.parameters.prior.heading_sigma = 60.0 * kDegree;
        fed.filter.parameters.prior.tilt_sigma = 1.0 * kDegree;
        const Trial run{.heading_error = 60.0 * kDegree};
        run.seconds(fed, 300.0);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * fed.filter.outputs.heading_sigma);
        EXPECT_LT(fed.filter.outputs.heading_sigma, 0.4 * kDegree);
        EXPECT_EQ(fed.filter.outputs.status, Status::converged);
        EXPECT_EQ(fed.filter.outputs.nis_channels, 6);
    }
}

TEST(AlignmentFilterInvariant, ComparesALateFixWithTheMomentItWasValid) {
    // Turning, with the antenna off the axis: 0.3 s late is 0.15 rad and 0.75 m.
    Trial run;
    run.table.rate = 0.5;
    run.lever_arm = {2.0, 3.0, 1.0};
    const auto heading_error = [&](int latency) {
        run.latency = latency;
        FedFilter fed;
        fed.filter.parameters.gnss.lever_arm = run.lever_arm;
        run.seconds(fed, 150.9);
        EXPECT_EQ(fed.filter.outputs.rejected_fixes, 0);
        return std::pair{heading_error_of(fed, run.table), fed.filter.outputs.heading_sigma};
    };
    const auto [prompt, sigma] = heading_error(0);
    const auto [late, late_sigma] = heading_error(15);
    EXPECT_LT(std::abs(prompt), 0.1 * sigma);
    EXPECT_LT(std::abs(late), 0.1 * late_sigma);
    EXPECT_NEAR(late_sigma / sigma, 1.0, 0.02);
}

TEST(AlignmentFilterInvariant, ContinuesBitForBitFromEveryStage) {
    Draws draw(4);
    Trial run{.heading_error = 2.0};
    run.fix_noise = [](int second) {
        return Vector3d(0.1 * std::sin(second), 0.1 * std::cos(3 * second), 0.0);
    };
    for (const int middle : {1010, 6000}) {
        FedFilter fed;
        run.start(fed);
        run.advance(fed, 0, middle);
        std::stringstream stored;
        cereal::BinaryOutputArchive{stored}(fed.filter);
        FedFilter other;
        cereal::BinaryInputArchive{stored}(other.filter);
        run.advance(fed, middle, middle + 1500);
        run.advance(other, middle, middle + 1500);
        EXPECT_EQ(bytes(other.filter.outputs), bytes(fed.filter.outputs)) << middle;
    }
}

TEST(AlignmentFilterInvariant, ContinuesBitForBitWhileItWeighsHeadings) {
    Trial run;
    run.table.gyro_bias = Vector3d::Constant(CoarseGyros::kBias);
    run.fix_noise = [](int second) {
        return Vector3d(0.1 * std::sin(second), 0.1 * std::cos(3 * second), 0.0);
    };
    CoarseGyros fed;
    run.start(fed);
    run.advance(fed, 0, 10010);
    ASSERT_EQ(fed.log.with("the heading cannot be told yet"), 1);
    std::stringstream stored;
    cereal::BinaryOutputArchive{stored}(fed.filter);
    CoarseGyros other;
    cereal::BinaryInputArchive{stored}(other.filter);
    run.advance(fed, 10010, 11500);
    run.advance(other, 10010, 11500);
    EXPECT_EQ(bytes(other.filter.outputs), bytes(fed.filter.outputs));
}

TEST(AlignmentFilterInvariant, BeginsAgainAfterAGapThatCannotBeBridged) {
    FedFilter fed;
    Draws draw(5);
    Trial run{.heading_error = 2.0};
    run.fix_noise = [&](int) { return draw(0.05); };
    run.seconds(fed, 150.0);
    ASSERT_NE(fed.filter.outputs.status, Status::coarse);
    run.table.heading += 1.0;  // turned meanwhile
    run.advance(fed, 200 * kRate, 250 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::coarse);
    run.advance(fed, 250 * kRate, 350 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
    EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * fed.filter.outputs.heading_sigma);
}

TEST(AlignmentFilterInvariant, WithGaussMarkovProcessesThatAreNoneIsWithoutThem) {
    const auto outputs = [](double sigma) {
        FedFilter fed;
        fed.filter.parameters.process.gyro_markov_sigma = sigma * 4.8e-7;
        fed.filter.parameters.process.accelerometer_markov_sigma = sigma * 2.9e-3;
        const Trial run;
        run.seconds(fed, 200.0);
        return fed.filter.outputs;
    };
    const auto without = outputs(0.0);
    const auto tiny = outputs(1e-4);
    const auto strong = outputs(1.0);
    EXPECT_NEAR(tiny.nav.heading, without.nav.heading, 1e-4 * without.heading_sigma);
    EXPECT_NEAR(tiny.heading_sigma / without.heading_sigma, 1.0, 1e-4);
    EXPECT_GT(strong.heading_sigma, 1.5 * without.heading_sigma);
}

TEST(AlignmentFilterInvariant, RefusesWhatItCannotDo) {
    const auto refusal = [](const std::function<void(Parameters&)>& spoil) -> std::string {
        FedFilter fed;
        spoil(fed.filter.parameters);
        try {
            fed.filter.initialise(0.0);
        } catch (const InvalidParameter& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refusal([](Parameters&) {}), "");
    EXPECT_TRUE(refusal([](Parameters& p) { p.feedback = false; }).starts_with("feedback = "));
    EXPECT_TRUE(refusal([](Parameters& p) {
                    p.discretisation = alignment_filter::Discretisation::euler;
                }).starts_with("discretisation = "));
    EXPECT_TRUE(refusal([](Parameters& p) {
                    p.robust.states = alignment_filter::RobustStates::heading;
                }).starts_with("robust.states = "));
    EXPECT_TRUE(refusal([](Parameters& p) {
                    p.process.gyro_markov_sigma = 1e-7;
                }).starts_with("process.accelerometer_markov_sigma = "));
}

}  // namespace
}  // namespace truenorth
