// Parameters of an AlignmentFilter: what they do, and which are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "components/alignment_filter.hpp"
#include "contract/invalid_parameter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using alignment_filter::Corrector;
using alignment_filter::ErrorModel;
using alignment_filter::Parameters;
using alignment_filter::RobustScaling;
using alignment_filter::Status;
using FedFilter = Fed<AlignmentFilter>;
using Trial = Session<AlignmentFilter>;

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
            for (const double gamma : {1e-6, 0.1, 2.0, 1e100}) {
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
                         p.velocity_form = alignment_filter::VelocityForm::computed_force;
                     }},
        BadParameter{"velocity_form",
                     [](Parameters& p) {
                         p.error_model = alignment_filter::ErrorModel::invariant;
                         p.velocity_form = alignment_filter::VelocityForm::printed;
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

TEST(AlignmentFilterParameters, WithoutEffectInTheModelAreTold) {
    for (const auto model : {ErrorModel::large_azimuth, ErrorModel::invariant}) {
        Fed<AlignmentFilter> fed;
        Parameters& p = fed.filter.parameters;
        p.error_model = model;
        p.process.gyro_markov_sigma = 1e-7;
        p.process.accelerometer_markov_sigma = 1e-3;
        fed.start(Turntable{}, 0.0);
        const int told = model == ErrorModel::invariant ? 0 : 1;
        EXPECT_EQ(fed.log.with("process.gyro_markov_sigma = 1e-07 has no effect"), told);
        EXPECT_EQ(fed.log.with("process.accelerometer_markov_sigma = 0.001 has no effect"), told);
    }
}

}  // namespace
}  // namespace truenorth
