#include "components/navigation_filter.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "contract/invalid_parameter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;
using navigation_filter::Corrector;
using navigation_filter::ErrorModel;
using navigation_filter::Outputs;
using navigation_filter::Parameters;
using navigation_filter::Status;
using Filter = Fed<NavigationFilter>;
using Trial = Session<NavigationFilter>;

constexpr std::array kModels{ErrorModel::loose, ErrorModel::full_state, ErrorModel::tight};

Vector3d position_error(const Outputs& outputs, const earth::Position& true_position) {
    return earth::displacement(true_position,
                               {outputs.nav.latitude, outputs.nav.longitude, outputs.nav.height});
}

class NavigationFilterModel : public testing::TestWithParam<ErrorModel> {
  protected:
    static void choose(Filter& fed) { fed.filter.parameters.error_model = GetParam(); }
};

TEST_P(NavigationFilterModel, ErrsAsItsSigmasSay) {
    // Starts drawn from the prior, fixes without noise but believed to have some: squared normalised errors
    // after one minute cannot be larger on average than 1. 20 runs of 3 velocities, 3 positions; their sum is
    // at most a chi-square with 120 degrees of freedom, below 177.6 with 99.95 % confidence.
    std::mt19937 generator(7);
    std::normal_distribution<double> normal;
    const auto draw = [&](double sigma) {
        return Vector3d(sigma * Vector3d::NullaryExpr([&] { return normal(generator); }));
    };
    double sum = 0.0;
    for (int n = 0; n < 20; ++n) {
        Filter fed;
        choose(fed);
        Trial run{.heading_error = 0.05 * normal(generator)};
        run.table.gyro_bias = draw(2.4e-7);
        if (GetParam() != ErrorModel::full_state) {  // it knows no biases
            run.table.accelerometer_bias = draw(9.8e-4);
        }
        run.fix_noise = [&](int) { return draw(0.1); };
        fed.filter.parameters.prior.heading_sigma = 0.05;
        run.start(fed);
        fed.initial().velocity = draw(0.5);
        const earth::Position moved = earth::displaced(run.table.position, draw(10.0));
        fed.initial().latitude = moved.latitude;
        fed.initial().longitude = moved.longitude;
        fed.initial().height = moved.height;
        fed.filter.initialise(0.0);
        run.advance(fed, 0, 60 * kRate);
        const Outputs& outputs = fed.filter.outputs;
        EXPECT_GE(outputs.used_fixes, 58);
        const Vector3d p = position_error(outputs, run.table.position);
        sum += p.cwiseQuotient(outputs.position_sigma).squaredNorm() +
               outputs.nav.velocity.cwiseQuotient(outputs.velocity_sigma).squaredNorm();
        EXPECT_LT(outputs.position_sigma.maxCoeff(), 5.0);
        EXPECT_LT(outputs.velocity_sigma.maxCoeff(), 0.1);
    }
    EXPECT_LT(sum, 177.6);
    EXPECT_GT(sum, 1.0);  // or nothing was compared
}

TEST_P(NavigationFilterModel, IsToldNothingNewByALateFix) {
    // A fix 0.3 s late, lever arm, turning: the same estimate as with prompt fixes, up to what the process
    // noise of 0.3 s weighs.
    Trial prompt_run{.heading_error = 0.02, .lever_arm = {1.0, -2.0, 0.5}};
    prompt_run.table.rate = 0.1;
    Trial late_run = prompt_run;
    late_run.latency = 15;
    std::array<Filter, 2> fed;
    for (int i = 0; i < 2; ++i) {
        choose(fed[i]);
        fed[i].filter.parameters.gnss.lever_arm = prompt_run.lever_arm;
        (i == 0 ? prompt_run : late_run).seconds(fed[i], 60.9);
    }
    const Outputs& prompt = fed[0].filter.outputs;
    const Outputs& late = fed[1].filter.outputs;
    EXPECT_EQ(late.used_fixes, prompt.used_fixes);
    EXPECT_LT((late.nav.velocity - prompt.nav.velocity).cwiseQuotient(prompt.velocity_sigma).norm(), 0.3);
    EXPECT_LT(
        (position_error(late, prompt_run.table.position) - position_error(prompt, prompt_run.table.position))
            .cwiseQuotient(prompt.position_sigma)
            .norm(),
        0.3);
    EXPECT_LT(std::abs(late.nav.heading - prompt.nav.heading), 0.3 * prompt.heading_sigma);
    EXPECT_NEAR(late.heading_sigma / prompt.heading_sigma, 1.0, 0.05);
}

TEST_P(NavigationFilterModel, ContinuesBitByBitFromASavedState) {
    const Trial run;
    Filter whole;
    choose(whole);
    whole.filter.parameters.corrector = Corrector::variational_bayes;
    run.start(whole);
    run.advance(whole, 0, 510);  // between two fixes
    std::stringstream stream;
    {
        cereal::BinaryOutputArchive archive(stream);
        archive(whole.filter);
    }
    Filter restored;
    {
        cereal::BinaryInputArchive archive(stream);
        archive(restored.filter);
    }
    EXPECT_EQ(bytes(restored.filter.outputs), bytes(whole.filter.outputs));
    run.advance(whole, 510, 1500);
    run.advance(restored, 510, 1500);
    EXPECT_EQ(bytes(restored.filter.outputs), bytes(whole.filter.outputs));
}

TEST_P(NavigationFilterModel, RepeatsARunBitByBit) {
    Filter fed;
    choose(fed);
    const Trial run;
    run.seconds(fed, 20.0);
    const std::string first = bytes(fed.filter.outputs);
    fed.filter.inputs.imu = {};
    fed.filter.inputs.gnss = {};
    run.seconds(fed, 20.0);
    EXPECT_EQ(bytes(fed.filter.outputs), first);
}

TEST_P(NavigationFilterModel, RecoversFromAStartBeyondItsPrior) {
    for (const Corrector corrector : {Corrector::standard, Corrector::combined}) {
        Filter fed;
        choose(fed);
        fed.filter.parameters.corrector = corrector;
        const Trial run{.heading_error = 0.0};
        run.start(fed);
        fed.initial().velocity = {20.0, 0.0, 0.0};
        fed.initial().height += 500.0;
        fed.filter.initialise(0.0);
        run.advance(fed, 0, 120 * kRate);
        const Outputs& outputs = fed.filter.outputs;
        EXPECT_GE(fed.log.with("(gate.patience): the prediction is blamed") +
                      fed.log.with("contradict the prediction"),
                  1);
        EXPECT_GE(outputs.used_fixes, 80);
        EXPECT_LT(outputs.nav.velocity.norm(), 0.5);
        EXPECT_LT(position_error(outputs, run.table.position).norm(), 10.0);
    }
}

std::string name_of(const testing::TestParamInfo<ErrorModel>& info) {
    return info.param == ErrorModel::loose   ? "loose"
           : info.param == ErrorModel::tight ? "tight"
                                             : "full_state";
}

INSTANTIATE_TEST_SUITE_P(All, NavigationFilterModel, testing::ValuesIn(kModels), name_of);

TEST(NavigationFilterTight, FindsTheClock) {
    Filter fed;
    fed.filter.parameters.error_model = ErrorModel::tight;
    const Trial run{.heading_error = 0.0};
    run.seconds(fed, 60.0);
    const Outputs& outputs = fed.filter.outputs;
    EXPECT_NEAR(outputs.clock_bias, 120.0 + 0.7 * 60.0, 0.5);
    EXPECT_NEAR(outputs.clock_drift, 0.7, 0.05);
    EXPECT_GT(outputs.clock_bias_sigma, 0.1);
    EXPECT_LT(outputs.clock_bias_sigma, 5.0);
    EXPECT_EQ(outputs.nis_channels, 16);
}

TEST(NavigationFilterTight, LeavesOutChannelsThatAreAbsentOrBroken) {
    Filter fed;
    fed.filter.parameters.error_model = ErrorModel::tight;
    const Trial run{.heading_error = 0.0};
    run.seconds(fed, 20.0);
    fed.put_sample(20.02, run.table.increment(20.0, 20.02));
    fed.put_fix(run.table.fix(20.02));
    auto& channels = fed.filter.inputs.gnss.channel;
    channels.pseudorange(0) = kNaN;
    channels.satellite_position(1, 2) = std::numeric_limits<double>::infinity();
    channels.range_rate(2) = 1e9;
    channels.valid[3] = false;
    fed.step();
    const Outputs& outputs = fed.filter.outputs;
    EXPECT_EQ(outputs.rejected_channels, 3);
    EXPECT_EQ(outputs.nis_channels, 8);
    EXPECT_EQ(outputs.used_fixes, 21);
    for (int i = 0; i < 12; ++i) {
        const double weight = i >= 4 && i < 8 ? 1.0 : 0.0;
        EXPECT_EQ(outputs.measurement_weight(i), weight) << i;
        EXPECT_EQ(outputs.measurement_weight(12 + i), weight) << i;
        EXPECT_EQ(outputs.innovation_sigma(i) > 0.0, weight > 0.0) << i;
    }
    EXPECT_TRUE(outputs.innovation.allFinite());

    fed.put_sample(20.04, run.table.increment(20.02, 20.04));
    fed.put_fix(run.table.fix(20.04));
    channels.valid.fill(false);
    fed.step();
    EXPECT_EQ(outputs.used_fixes, 21);
    EXPECT_EQ(outputs.rejected_fixes, 1);
    EXPECT_EQ(fed.log.with("it measures nothing that the model can use"), 1);
}

TEST(NavigationFilterTight, ForgetsTheNoiseOfASatelliteThatLeavesItsChannel) {
    // Channel 1 learns a large noise; with another satellite it begins anew, with the others nothing happens.
    const auto learned = [](int satellite) {
        Filter fed;
        auto& parameters = fed.filter.parameters;
        parameters.error_model = ErrorModel::tight;
        parameters.corrector = Corrector::variational_bayes;
        parameters.gate.enabled = false;
        const Trial run{.heading_error = 0.0};
        run.start(fed);
        for (int k = 1; k <= 100; ++k) {
            fed.put_sample(k, run.table.increment(k - 1, k));
            fed.put_fix(run.table.fix(k));
            fed.filter.inputs.gnss.channel.pseudorange(0) += k % 2 == 0 ? 40.0 : -40.0;
            if (k == 100) {
                fed.filter.inputs.gnss.channel.satellite[0] = satellite;
            }
            fed.step();
        }
        return fed.filter.outputs.measurement_sigma_estimate;
    };
    const auto same = learned(1);
    const auto other = learned(30);
    EXPECT_GT(same(0), 30.0);
    EXPECT_LT(other(0), 0.8 * same(0));
    EXPECT_NEAR(other(1), same(1), 0.1 * same(1));
}

}  // namespace
}  // namespace truenorth
