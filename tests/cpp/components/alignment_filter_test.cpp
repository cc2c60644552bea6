#include "components/alignment_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "contract/invalid_parameter.hpp"
#include "filter/filter_outputs.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using alignment_filter::Corrector;
using alignment_filter::Outputs;
using alignment_filter::Parameters;
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
        // The east gyro bias limits it to eps / (w_ie cos L): 13.5' at 32 deg; 15' is the bound over
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

TEST(AlignmentFilterVelocity, HoldsBetweenTwoFixesOfAMechanisationThatKeepsItsTilt) {
    // Without feedback the mechanisation gains g sin(5 deg) = 0.85 m/s from one fix to the next.
    for (const auto model :
         {alignment_filter::ErrorModel::large_azimuth, alignment_filter::ErrorModel::euler_platform}) {
        FedFilter fed;
        fed.filter.parameters.error_model = model;
        fed.filter.parameters.feedback = false;
        fed.filter.parameters.prior.tilt_sigma = 5.0 * kDegree;
        double largest = 0.0;
        Trial run{.table = {.roll = 0.0, .pitch = 0.0}, .heading_error = 0.0};
        run.after_step = [&](const FedFilter& filter, int k) {
            if (k > 60 * kRate) {
                const Outputs& outputs = filter.filter.outputs;
                const Eigen::Array2d sigma = outputs.velocity_sigma.head<2>();
                largest =
                    std::max(largest, (outputs.nav.velocity.head<2>().array() / sigma).abs().maxCoeff());
            }
        };
        run.start(fed);
        fed.initial().roll += 5.0 * kDegree;
        fed.filter.initialise(0.0);
        run.advance(fed, 0, 90 * kRate);
        EXPECT_LT(largest, 3.0);
    }
}

TEST(AlignmentFilterCovariance, IsThatOfTheOutputsWithAndWithoutFeedback) {
    // Without feedback the estimator's covariance is that of the angles of the open-loop mechanisation, whose
    // tilts lie along axes that are 10 degrees off: a sixth of their sigmas.
    std::array<FedFilter, 2> fed;
    for (std::size_t i = 0; i < 2; ++i) {
        fed[i].filter.parameters.feedback = i == 0;
        Trial().seconds(fed[i], 120.0);
    }
    const auto& expected = fed[0].filter.outputs;
    const auto& outputs = fed[1].filter.outputs;
    const auto scale = expected.covariance.diagonal().cwiseSqrt().cwiseInverse().eval();
    const auto difference = (outputs.covariance - expected.covariance).eval();
    EXPECT_LT((scale.asDiagonal() * difference * scale.asDiagonal()).cwiseAbs().maxCoeff(), 0.05);
    const Eigen::Matrix3d C_bn =
        dcm({.roll = outputs.nav.roll, .pitch = outputs.nav.pitch, .heading = outputs.nav.heading});
    const Eigen::Matrix3d attitude = outputs.covariance.topLeftCorner<3, 3>();
    EXPECT_NEAR(outputs.heading_sigma, heading_sigma(attitude, Eigen::Quaterniond(C_bn)), 1e-12);
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

TEST(AlignmentFilterCovariance, ToHandOverIsThatOfTheOutputsAndThePriorWhereThereIsNoState) {
    FedFilter fed;
    const Trial run;
    run.seconds(fed, 60.0);
    const Outputs& outputs = fed.filter.outputs;
    const auto& P = outputs.covariance;
    Eigen::Matrix<double, 12, 1> sigma;
    sigma << outputs.misalignment_sigma, outputs.velocity_sigma, outputs.gyro_bias_sigma,
        outputs.accelerometer_bias_sigma;
    sigma(5) = fed.filter.parameters.prior.velocity_sigma;  // the vertical velocity is no state
    for (int i = 0; i < 12; ++i) {
        EXPECT_NEAR(std::sqrt(P(i, i)) / sigma(i), 1.0, 1e-12) << i;
        EXPECT_EQ(i == 5 || i == 11, P.row(i).cwiseAbs().sum() == P(i, i))
            << i;  // nothing is correlated with it
    }
    EXPECT_EQ(P, P.transpose());
    // On a level base a tilt about north looks like an accelerometer bias to the right or forward.
    EXPECT_GT((P.block<3, 3>(0, 9).cwiseAbs().maxCoeff()), 0.5 * sigma(0) * sigma(9));
}

}  // namespace
}  // namespace truenorth
