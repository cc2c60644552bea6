#include "components/alignment_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "components/invalid_parameter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using alignment_filter::Corrector;
using alignment_filter::Outputs;
using alignment_filter::Parameters;
using alignment_filter::RobustScaling;
using alignment_filter::Status;
using Eigen::Vector3d;

using FedFilter = Fed<AlignmentFilter>;
using Trial = Session<AlignmentFilter>;

TEST(AlignmentFilterHeading, IsFoundFromTenDegreesWithinThreeSigma) {
    for (const double sign : {1.0, -1.0}) {
        FedFilter fed;
        const Trial run{.heading_error = sign * 10.0 * kDegree};
        run.seconds(fed, 600.0);
        const double sigma = fed.filter.outputs.heading_sigma;
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * sigma);
        // The east gyro bias limits it to eps / (w_ie cos L): 13.5' at 32 deg; science.md has 15' over
        // 300-600 s.
        const double limit = 2.4240684e-7 / (7.292115e-5 * std::cos(0.56));
        EXPECT_GT(sigma, 0.97 * limit);
        EXPECT_LT(sigma, 1.2 * limit);
    }
}

TEST(AlignmentFilterHeading, ErrsAsItsSigmaSays) {
    // 40 runs with errors drawn from the prior: the sum of squared normalised heading errors is chi-square
    // with 40 degrees of freedom, in [16.9, 76.1] with 99.9 % confidence (0.05 % on either side).
    for (const unsigned seed : {1U, 2026U}) {
        std::mt19937 generator(seed);
        std::normal_distribution<double> normal;
        const auto draw = [&](double sigma) {
            return Vector3d(sigma * Vector3d::NullaryExpr([&] { return normal(generator); }));
        };
        double sum = 0.0;
        for (int n = 0; n < 40; ++n) {
            Trial run{.heading_error = 10.0 * kDegree * normal(generator)};
            run.table.gyro_bias = draw(2.4240684e-7);
            run.table.accelerometer_bias = draw(9.80665e-3);
            run.table.accelerometer_bias.z() = 0.0;
            run.fix_noise = [&](int) { return draw(0.1); };
            FedFilter fed;
            fed.filter.parameters.gate.enabled = false;
            // The sensors have no white noise: what the filter believes of it must be small.
            fed.filter.parameters.process.angle_random_walk = 1e-8;
            fed.filter.parameters.process.velocity_random_walk = 1e-6;
            run.seconds(fed, 300.0);
            const double normalised = heading_error_of(fed, run.table) / fed.filter.outputs.heading_sigma;
            sum += normalised * normalised;
        }
        EXPECT_GT(sum, 16.9);
        EXPECT_LT(sum, 76.1);
    }
}

TEST(AlignmentFilterHeading, FindsTheSameInEveryWayOfComputing) {
    // Predictors, discretisations and intervals differ in what they neglect; none of it may weigh a tenth of
    // sigma.
    const auto result = [](const std::function<void(Parameters&)>& change) {
        FedFilter fed;
        change(fed.filter.parameters);
        const Trial run;
        run.seconds(fed, 300.0);
        return std::pair{heading_error_of(fed, run.table), fed.filter.outputs.heading_sigma};
    };
    const auto [error, sigma] = result([](Parameters&) {});
    const std::vector<std::function<void(Parameters&)>> ways{
        [](Parameters& p) { p.predictor = alignment_filter::Predictor::linearised; },
        [](Parameters& p) { p.discretisation = alignment_filter::Discretisation::euler; },
        [](Parameters& p) { p.filter.interval = 0.1; },
        [](Parameters& p) { p.unscented.alpha = 0.1; },
        [](Parameters& p) { p.feedback = false; },
        [](Parameters& p) {
            p.corrector = Corrector::h_infinity;
            p.robust.gamma = 1e6;
        },
    };
    for (std::size_t i = 0; i < ways.size(); ++i) {
        const auto [other_error, other_sigma] = result(ways[i]);
        EXPECT_LT(std::abs(other_error - error), 0.1 * sigma) << i;
        EXPECT_NEAR(other_sigma / sigma, 1.0, 0.03) << i;
    }
}

TEST(AlignmentFilterLatency, OfAFixCostsNoMoreThanTheVelocityThatWasGainedMeanwhile) {
    // A fix that is 0.3 s late is wrong by b = 0.3 s times the rate of the velocity error. Errors b_k of the
    // measurements move an estimate by at most sqrt(sum (b_k / sigma_R)^2) of its own sigma, whatever the
    // model.
    Trial run;
    double allowance = 0.0;
    Eigen::Vector2d corrected = Eigen::Vector2d::Zero();
    run.after_step = [&](FedFilter& fed, int k) {
        const Eigen::Vector2d velocity = fed.filter.outputs.nav.velocity.head<2>();
        if (k % kRate == kRate - 1) {  // just before a fix: what was gained since the last
            const double b = 0.3 * (velocity - corrected).norm() * kRate / (kRate - 1.0);
            allowance += std::pow(b / 0.1, 2);
        }
        if (k % kRate == 0) {
            corrected = velocity;
        }
    };
    FedFilter prompt;
    run.seconds(prompt, 120.9);
    EXPECT_LT(std::sqrt(allowance), 1.0);  // or the test could not fail

    Trial late_run;
    late_run.latency = 15;
    FedFilter late;
    late_run.seconds(late, 120.9);
    EXPECT_EQ(late.filter.outputs.used_fixes, prompt.filter.outputs.used_fixes);
    const double sigma = prompt.filter.outputs.heading_sigma;
    const double difference = late.filter.outputs.nav.heading - prompt.filter.outputs.nav.heading;
    EXPECT_LT(std::abs(difference), std::sqrt(allowance) * sigma);
    EXPECT_NEAR(late.filter.outputs.heading_sigma / sigma, 1.0, 0.01);
}

TEST(AlignmentFilterLatency, AFixOlderThanTheHistoryIsRejected) {
    FedFilter fed;
    const Trial run;
    run.seconds(fed, 20.5);
    const std::string before = estimate(fed);
    GnssFix old = run.table.fix(20.1);
    old.time = 10.0;  // newer than none of the fixes: time runs backwards
    fed.put_fix(old);
    fed.step();
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 1);
    EXPECT_EQ(estimate(fed), before);

    FedFilter first;
    run.start(first);
    for (int k = 1; k <= 10 * kRate; ++k) {
        first.put_sample(static_cast<double>(k) / kRate, run.table.increment(0.0, 1.0 / kRate));
        first.step();
    }
    first.put_fix(run.table.fix(1.0));
    first.step();
    EXPECT_EQ(first.filter.outputs.used_fixes, 0);
    EXPECT_EQ(first.log.with("older than the history"), 1);
}

TEST(AlignmentFilterLeverArm, OnATurntableMakesNoDifferenceWhenItIsKnown) {
    const Vector3d lever_arm(3.0, -5.0, 2.0);
    Trial with{.lever_arm = lever_arm};
    with.table.rate = 0.2;
    const Trial without{.table = with.table};
    FedFilter a;
    a.filter.parameters.gnss.lever_arm = lever_arm;
    with.seconds(a, 200.0);
    FedFilter b;
    without.seconds(b, 200.0);
    // The arm's velocity of 1.2 m/s tells the heading a little more; nothing may contradict the truth.
    EXPECT_EQ(a.filter.outputs.rejected_fixes, 0);
    EXPECT_LT(std::abs(heading_error_of(a, with.table)), 3.0 * a.filter.outputs.heading_sigma);
    EXPECT_LT(a.filter.outputs.heading_sigma, b.filter.outputs.heading_sigma * 1.001);
    EXPECT_LT(a.filter.outputs.nav.velocity.norm(), 0.02);
    EXPECT_LT(earth::displacement(with.table.position,
                                  {a.filter.outputs.nav.latitude, a.filter.outputs.nav.longitude,
                                   a.filter.outputs.nav.height})
                  .norm(),
              0.1);
}

TEST(AlignmentFilterLeverArm, ThatIsNotKnownShowsInTheInnovation) {
    Trial run{.heading_error = 0.0, .lever_arm = Vector3d(3.0, -5.0, 2.0)};
    run.table.rate = 0.2;
    FedFilter fed;
    fed.filter.parameters.prior.velocity_sigma = 0.01;
    run.seconds(fed, 1.0);
    EXPECT_NEAR(fed.filter.outputs.innovation.norm(), 0.2 * std::hypot(3.0, 5.0), 0.1);
}

TEST(AlignmentFilterBadData, OfTheImuLeavesTheEstimateAndIsCountedAndLogged) {
    FedFilter fed;
    const Trial run;
    run.seconds(fed, 20.5);
    const std::string before = estimate(fed);
    const ImuIncrement good = run.table.increment(0.0, 0.02);
    ImuIncrement bad = good;
    bad.delta_angle.y() = kNaN;
    fed.put_sample(20.52, bad);
    fed.step();
    EXPECT_EQ(estimate(fed), before);
    bad = good;
    bad.delta_velocity.x() = 1e6;
    fed.put_sample(20.52, bad);
    fed.step();
    fed.put_sample(20.4, good);
    fed.step();
    fed.put_sample(kNaN, good);
    fed.step();
    EXPECT_EQ(estimate(fed), before);
    EXPECT_EQ(fed.filter.outputs.rejected_samples, 4);
    EXPECT_EQ(fed.log.with("IMU sample"), 4);
    EXPECT_EQ(fed.log.with("rejected"), 4);
}

TEST(AlignmentFilterBadData, OfTheReceiverChangesNothingAtAll) {
    FedFilter clean;
    FedFilter disturbed;
    Trial run;
    run.seconds(clean, 60.0);
    int sent = 0;
    run.after_step = [&](FedFilter& fed, int k) {
        if (k % kRate != kRate / 2) {
            return;
        }
        GnssFix fix = run.table.fix(static_cast<double>(k) / kRate);
        switch (sent++ % 5) {
            case 0:
                fix.velocity.x() = kNaN;
                break;
            case 1:
                fix.position.latitude = 2.0;
                break;
            case 2:
                fix.time += 1.0;
                break;
            case 3:
                fix.time -= 1.0;
                break;
            default:
                fix.time = kNaN;
                break;
        }
        fed.put_fix(fix);
        fed.step();
    };
    run.seconds(disturbed, 60.0);
    EXPECT_EQ(sent, 60);
    EXPECT_EQ(disturbed.filter.outputs.rejected_fixes, sent);
    EXPECT_EQ(disturbed.log.with("rejected"), sent);
    EXPECT_EQ(estimate(disturbed), estimate(clean));
}

TEST(AlignmentFilterBadData, OfOneSampleIsBridged) {
    FedFilter clean;
    FedFilter disturbed;
    const Trial run;
    run.seconds(clean, 60.0);
    run.start(disturbed);
    for (int k = 1; k <= 60 * kRate; ++k) {
        ImuIncrement increment =
            run.table.increment(static_cast<double>(k - 1) / kRate, static_cast<double>(k) / kRate);
        if (k == 1010) {
            increment.delta_angle.x() = kNaN;
        }
        disturbed.put_sample(static_cast<double>(k) / kRate, increment);
        if (k % kRate == 0) {
            disturbed.put_fix(run.table.fix(static_cast<double>(k) / kRate));
        }
        disturbed.step();
    }
    EXPECT_EQ(disturbed.filter.outputs.rejected_samples, 1);
    EXPECT_EQ(disturbed.filter.outputs.missed_samples, 0);
    EXPECT_NEAR(disturbed.filter.outputs.nav.heading, clean.filter.outputs.nav.heading, 1e-9);
    EXPECT_LT((disturbed.filter.outputs.nav.velocity - clean.filter.outputs.nav.velocity).norm(), 1e-7);
}

TEST(AlignmentFilterBadData, AStepWithoutNewDataChangesNothing) {
    FedFilter fed;
    const Trial run;
    run.seconds(fed, 20.5);
    const std::string before = bytes(fed.filter.outputs);
    for (int i = 0; i < 10; ++i) {
        fed.step();
    }
    EXPECT_EQ(bytes(fed.filter.outputs), before);
}

TEST(AlignmentFilterGate, RejectsAnOutlierAndSaysSo) {
    Trial run;
    run.fix_noise = [](int second) { return Vector3d(second == 100 ? 5.0 : 0.0, 0.0, 0.0); };
    FedFilter fed;
    run.seconds(fed, 100.0);
    const Outputs& outputs = fed.filter.outputs;
    EXPECT_GT(outputs.nis, 16.0);
    EXPECT_EQ(outputs.measurement_weight, Eigen::Vector3d::Zero());
    EXPECT_EQ(outputs.rejected_fixes, 1);
    EXPECT_EQ(outputs.used_fixes, 99);
    EXPECT_EQ(fed.log.with("gate.threshold"), 1);

    FedFilter open;
    open.filter.parameters.gate.enabled = false;
    run.seconds(open, 100.0);
    EXPECT_EQ(open.filter.outputs.used_fixes, 100);
    EXPECT_EQ(open.filter.outputs.measurement_weight, Eigen::Vector3d(1.0, 1.0, 0.0));
    EXPECT_GT(open.filter.outputs.nav.velocity.x(), fed.filter.outputs.nav.velocity.x() + 0.1);
}

TEST(AlignmentFilterGate, IsOpenedForAStartBeyondItsPrior) {
    // Heading wrong by 10 times, velocity by 20 times its prior sigma.
    for (const int patience : {20, 0}) {
        FedFilter fed;
        auto& parameters = fed.filter.parameters;
        parameters.gate.patience = patience;
        parameters.prior.heading_sigma = 1.0 * kDegree;
        parameters.prior.velocity_sigma = 0.1;
        const Trial run;
        run.start(fed);
        parameters.initial.velocity = {2.0, -2.0, 0.0};
        fed.filter.initialise(0.0);
        run.advance(fed, 0, 600 * kRate);
        const Outputs& outputs = fed.filter.outputs;
        if (patience == 0) {  // locked out
            EXPECT_LT(outputs.used_fixes, 10);
            EXPECT_EQ(fed.log.with("gate.patience"), 0);
            continue;
        }
        EXPECT_GE(fed.log.with("(gate.patience): the prediction is blamed"), 1);
        EXPECT_GE(outputs.used_fixes, 500);
        EXPECT_LT(outputs.nav.velocity.norm(), 0.1);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 0.1 * kDegree);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 3.0 * outputs.heading_sigma);
    }
}

TEST(AlignmentFilterStart, FarFromTheFirstFixIsQuestioned) {
    for (const double distance : {9e3, 11e3}) {
        FedFilter fed;
        const Trial run;
        run.start(fed);
        fed.filter.parameters.initial.latitude += distance / 6371e3;
        fed.filter.initialise(0.0);
        run.advance(fed, 0, 3 * kRate);
        EXPECT_EQ(fed.log.with("11 km from where the filter is: are initial.latitude"),
                  distance > 1e4 ? 1 : 0);
    }
}

TEST(AlignmentFilterInterval, LongerThanASecondIsWarnedOfOnce) {
    for (const double step : {1.0, 2.0}) {
        FedFilter fed;
        const Trial run;
        run.start(fed);
        for (int k = 1; k <= 5; ++k) {
            fed.put_sample(k * step, run.table.increment((k - 1) * step, k * step));
            fed.step();
        }
        EXPECT_EQ(fed.log.with("imu.time = 2 s covers 2 s"), step > 1.0 ? 1 : 0);
        EXPECT_EQ(fed.log.with("covers"), step > 1.0 ? 1 : 0);
    }
}

TEST(AlignmentFilterReset, RepeatsARunBitByBit) {
    FedFilter fed;
    const Trial run;
    run.seconds(fed, 30.0);
    const std::string first = bytes(fed.filter.outputs);
    fed.filter.inputs = {};
    run.seconds(fed, 30.0);
    EXPECT_EQ(bytes(fed.filter.outputs), first);
}

TEST(AlignmentFilterSerialised, ContinuesBitByBit) {
    for (const bool feedback : {true, false}) {
        const Trial run;
        FedFilter whole;
        whole.filter.parameters.feedback = feedback;
        whole.filter.parameters.corrector = Corrector::h_infinity;
        run.start(whole);
        run.advance(whole, 0, 1010);  // between two fixes
        std::stringstream stream;
        {
            cereal::BinaryOutputArchive archive(stream);
            archive(whole.filter);
        }
        FedFilter restored;
        {
            cereal::BinaryInputArchive archive(stream);
            archive(restored.filter);
        }
        EXPECT_EQ(bytes(restored.filter.outputs), bytes(whole.filter.outputs));
        run.advance(whole, 1010, 3000);
        run.advance(restored, 1010, 3000);
        EXPECT_EQ(bytes(restored.filter.outputs), bytes(whole.filter.outputs));
    }
}

TEST(AlignmentFilterStatus, GoesFromWaitingOverAligningToConvergedAndCoasting) {
    FedFilter fed;
    fed.filter.parameters.convergence.heading_sigma = 1.0 * kDegree;
    fed.filter.parameters.convergence.hold_time = 20.0;
    Trial run;
    double below = kNaN;
    double converged = kNaN;
    run.after_step = [&](FedFilter& f, int) {
        const Outputs& outputs = f.filter.outputs;
        if (std::isnan(below) && outputs.heading_sigma < 1.0 * kDegree) {
            below = outputs.nav.time;
        }
        if (std::isnan(converged) && outputs.converged) {
            converged = outputs.nav.time;
        }
    };
    run.start(fed);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    run.advance(fed, 0, kRate - 1);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    run.advance(fed, kRate - 1, kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
    run.advance(fed, kRate, 400 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::converged);
    EXPECT_NEAR(converged - below, 20.0, 0.021);
    EXPECT_EQ(fed.log.with("converged at"), 1);

    const auto without_fixes = [&](int from, int to) {
        for (int k = from + 1; k <= to; ++k) {
            fed.put_sample(static_cast<double>(k) / kRate, run.table.increment(0.0, 1.0 / kRate));
            fed.step();
        }
    };
    without_fixes(400 * kRate, 405 * kRate - 1);
    EXPECT_EQ(fed.filter.outputs.status, Status::converged);
    EXPECT_TRUE(fed.filter.outputs.converged);
    without_fixes(405 * kRate - 1, 405 * kRate + 1);  // coasting.delay = 5 s
    EXPECT_EQ(fed.filter.outputs.status, Status::coasting);
    EXPECT_FALSE(fed.filter.outputs.converged);
    EXPECT_EQ(fed.log.with("no longer converged at"), 1);
    // The hold time begins again with the first fix.
    run.advance(fed, 405 * kRate + 1, 406 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
    run.advance(fed, 406 * kRate, 426 * kRate - 1);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
    run.advance(fed, 426 * kRate - 1, 426 * kRate + 1);
    EXPECT_EQ(fed.filter.outputs.status, Status::converged);
}

TEST(AlignmentFilterRobust, SaysWhenItBacksOffFromAnInfeasibleGamma) {
    FedFilter fed;
    auto& parameters = fed.filter.parameters;
    parameters.corrector = Corrector::h_infinity;
    parameters.robust.scaling = RobustScaling::printed;
    parameters.robust.gamma = 0.1;  // gamma^2 = 0.01 below the heading variance of (10 deg)^2 = 0.03
    const Trial run;
    run.seconds(fed, 1.0);
    EXPECT_FALSE(fed.filter.outputs.robust.feasible);
    EXPECT_EQ(fed.filter.outputs.robust.gamma_effective, 0.0);  // no H-infinity term was applied
    EXPECT_EQ(fed.log.with("robust.gamma = 0.1 is infeasible"), 1);
    EXPECT_TRUE(std::isfinite(fed.filter.outputs.heading_sigma));
}

TEST(AlignmentFilterRobust, StaysFiniteUnderEveryScalingAndGamma) {
    for (const auto scaling :
         {RobustScaling::printed, RobustScaling::rate_invariant, RobustScaling::ceiling}) {
        for (const auto states :
             {alignment_filter::RobustStates::all, alignment_filter::RobustStates::heading}) {
            for (const double gamma : {1e-6, 0.1, 2.0, 1e200}) {
                FedFilter fed;
                auto& parameters = fed.filter.parameters;
                parameters.corrector = Corrector::h_infinity;
                parameters.robust.scaling = scaling;
                parameters.robust.states = states;
                parameters.robust.gamma = gamma;
                const Trial run;
                run.seconds(fed, 20.0);
                EXPECT_NE(fed.filter.outputs.status, Status::faulted) << gamma;
                EXPECT_TRUE(std::isfinite(fed.filter.outputs.nav.heading)) << gamma;
            }
        }
    }
}

struct BadParameter {
    const char* name;
    std::function<void(Parameters&)> spoil;
};

class AlignmentFilterParameters : public testing::TestWithParam<BadParameter> {};

TEST_P(AlignmentFilterParameters, ThatBreakARuleAreRefusedByName) {
    Lines log;
    AlignmentFilter filter(log);
    GetParam().spoil(filter.parameters);
    try {
        filter.initialise(0.0);
        FAIL() << GetParam().name << " was accepted";
    } catch (const InvalidParameter& error) {
        EXPECT_NE(std::string(error.what()).find(GetParam().name), std::string::npos) << error.what();
    }
}

INSTANTIATE_TEST_SUITE_P(
    OneByOne, AlignmentFilterParameters,
    testing::Values(
        BadParameter{"prior.heading_sigma", [](Parameters& p) { p.prior.heading_sigma = 0.0; }},
        BadParameter{"prior.tilt_sigma", [](Parameters& p) { p.prior.tilt_sigma = kNaN; }},
        BadParameter{"prior.velocity_sigma", [](Parameters& p) { p.prior.velocity_sigma = -1.0; }},
        BadParameter{"measurement.velocity_sigma", [](Parameters& p) { p.measurement.velocity_sigma = 0.0; }},
        BadParameter{"process.angle_random_walk", [](Parameters& p) { p.process.angle_random_walk = -1e-9; }},
        BadParameter{"robust.gamma", [](Parameters& p) { p.robust.gamma = 0.0; }},
        BadParameter{"robust.heading_sigma", [](Parameters& p) { p.robust.heading_sigma = 0.1 * kDegree; }},
        BadParameter{"igg.k1", [](Parameters& p) { p.igg.k1 = p.igg.k0; }},
        BadParameter{"velocity_form",
                     [](Parameters& p) {
                         p.error_model = alignment_filter::ErrorModel::euler_platform;
                         p.velocity_form = alignment_filter::VelocityForm::vertical_force;
                     }},
        BadParameter{"initial.velocity[2]",
                     [](Parameters& p) {
                         p.error_model = alignment_filter::ErrorModel::euler_platform_small;
                         p.initial.velocity.y() = 1.0;
                     }},
        BadParameter{"gnss.lever_arm[1]",
                     [](Parameters& p) {
                         p.error_model = alignment_filter::ErrorModel::euler_platform_large_azimuth;
                         p.gnss.lever_arm.x() = 1.0;
                     }},
        BadParameter{"unscented.alpha", [](Parameters& p) { p.unscented.alpha = 0.0; }},
        BadParameter{"filter.interval", [](Parameters& p) { p.filter.interval = 0.0; }},
        BadParameter{"initial.latitude", [](Parameters& p) { p.initial.latitude = 1.6; }},
        BadParameter{"initial.velocity[2]", [](Parameters& p) { p.initial.velocity.y() = kNaN; }},
        BadParameter{"gnss.lever_arm[3]", [](Parameters& p) { p.gnss.lever_arm.z() = 1e9; }},
        BadParameter{"coasting.delay", [](Parameters& p) { p.coasting.delay = -1.0; }},
        BadParameter{"predictor",
                     [](Parameters& p) { p.predictor = static_cast<alignment_filter::Predictor>(9); }},
        BadParameter{"corrector", [](Parameters& p) { p.corrector = static_cast<Corrector>(0); }}));

TEST(AlignmentFilterRetune, TakesATunableParameterOverBetweenSteps) {
    FedFilter fed;
    const Trial run;
    run.seconds(fed, 10.0);
    fed.filter.parameters.measurement.velocity_sigma = 10.0;
    fed.filter.retune();
    run.advance(fed, 10 * kRate, 11 * kRate);
    EXPECT_GT(fed.filter.outputs.innovation_sigma.head<2>().minCoeff(), 10.0);
    fed.filter.parameters.measurement.velocity_sigma = -1.0;
    EXPECT_THROW(fed.filter.retune(), InvalidParameter);
}

}  // namespace
}  // namespace truenorth
