// Bad data, outliers and wrong starts of an AlignmentFilter.
#include <gtest/gtest.h>

#include <cmath>

#include "components/alignment_filter.hpp"
#include "contract/invalid_parameter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using alignment_filter::Outputs;
using Eigen::Vector3d;
using FedFilter = Fed<AlignmentFilter>;
using Trial = Session<AlignmentFilter>;

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
    --fed.filter.inputs.imu.sample;  // an old one
    fed.filter.inputs.imu.time = 20.4;
    --fed.filter.inputs.imu.sample;
    fed.step();
    fed.filter.inputs.imu.sample += 3;
    fed.put_sample(kNaN, good);
    fed.step();
    EXPECT_EQ(estimate(fed), before);
    EXPECT_EQ(fed.filter.outputs.rejected_samples, 4);
    EXPECT_EQ(fed.log.with("rejected"), 3);  // a line for each kind
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
                fix.velocity.x() = std::numeric_limits<double>::infinity();
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
    EXPECT_EQ(disturbed.log.with("rejected"), 4);  // a line for each kind, and in the next minute another
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
    // What was made up is doubted, and weighs a little.
    EXPECT_NEAR(disturbed.filter.outputs.nav.heading, clean.filter.outputs.nav.heading, 1e-7);
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
    EXPECT_TRUE(outputs.measurement_weight.isZero(0.0));
    EXPECT_EQ(outputs.rejected_fixes, 1);
    EXPECT_EQ(outputs.used_fixes, 99);
    EXPECT_EQ(fed.log.with("gate.threshold"), 1);

    FedFilter open;
    open.filter.parameters.gate.enabled = false;
    run.seconds(open, 100.0);
    EXPECT_EQ(open.filter.outputs.used_fixes, 100);
    EXPECT_EQ(open.filter.outputs.measurement_weight.head<3>(), Eigen::Vector3d(1.0, 1.0, 0.0));
    EXPECT_GT(open.filter.outputs.nav.velocity.x(), fed.filter.outputs.nav.velocity.x() + 0.1);
}

TEST(AlignmentFilterConsistency, IsContradictedByGrossErrorsUntilTheyAreOutOfTheWindow) {
    // Without a gate, 2 m/s in every third fix of a minute.
    Trial run;
    run.fix_noise = [](int second) {
        return Vector3d(second > 300 && second <= 360 && second % 3 == 0 ? 2.0 : 0.0, 0.0, 0.0);
    };
    using Status = alignment_filter::Status;
    FedFilter fed;
    fed.filter.parameters.gate.enabled = false;
    run.seconds(fed, 300.0);
    ASSERT_EQ(fed.filter.outputs.status, Status::converged);
    EXPECT_LT(fed.filter.outputs.nis_mean, 1.0);
    run.advance(fed, 300 * kRate, 360 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::inconsistent);
    EXPECT_GT(fed.filter.outputs.nis_mean, 10.0);
    EXPECT_FALSE(fed.filter.outputs.converged);
    EXPECT_EQ(fed.log.with("no longer converged"), 1);
    EXPECT_EQ(fed.log.with("the covariance is contradicted"), 1);
    run.advance(fed, 360 * kRate, 600 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::converged);

    FedFilter gated;
    run.seconds(gated, 360.0);
    EXPECT_EQ(gated.filter.outputs.status, Status::converged);

    // Smaller ones, each of which its covariance explains: only the limit of the window finds them.
    run.fix_noise = [](int second) {
        return Vector3d(second > 300 && second <= 360 && second % 3 == 0 ? 0.37 : 0.0, 0.0, 0.0);
    };
    FedFilter limited;
    limited.filter.parameters.gate.enabled = false;
    limited.filter.parameters.consistency.limit = 2.0;
    run.seconds(limited, 360.0);
    EXPECT_EQ(limited.filter.outputs.status, Status::inconsistent);
    FedFilter unlimited;
    unlimited.filter.parameters.gate.enabled = false;
    unlimited.filter.parameters.consistency.limit = 1e9;
    run.seconds(unlimited, 360.0);
    EXPECT_EQ(unlimited.filter.outputs.status, Status::converged);
}

TEST(AlignmentFilterGate, IsOpenedForAStartBeyondItsPrior) {
    // Heading wrong by 10 times, velocity by 20 times its prior sigma.
    for (const int patience : {20, 0}) {
        FedFilter fed;
        auto& parameters = fed.filter.parameters;
        parameters.corrector = decltype(parameters.corrector)::standard;
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

TEST(AlignmentFilterCombined, BlamesAStartBeyondItsPrior) {
    // As above, and heading alone by less.
    for (const double sigmas : {10.0, 5.0, 2.0}) {
        FedFilter fed;
        auto& parameters = fed.filter.parameters;
        const Trial run;
        run.start(fed);
        parameters.prior.heading_sigma = 10.0 / sigmas * kDegree;
        parameters.prior.velocity_sigma = 0.1;
        parameters.initial.velocity = {2.0, -2.0, 0.0};
        fed.filter.initialise(0.0);
        run.advance(fed, 0, 600 * kRate);
        const Outputs& outputs = fed.filter.outputs;
        EXPECT_EQ(fed.log.with("contradict the prediction"), 1);
        EXPECT_EQ(outputs.status, alignment_filter::Status::converged);
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

}  // namespace
}  // namespace truenorth
