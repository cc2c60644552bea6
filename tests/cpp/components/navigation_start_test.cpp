// How a NavigationFilter is started: from its inputs at once, or by an alignment that is handed over.
#include <gtest/gtest.h>

#include "components/alignment_filter.hpp"
#include "components/navigation_filter.hpp"
#include "contract/invalid_parameter.hpp"
#include "session.hpp"

namespace truenorth {
namespace {

using Eigen::Vector3d;
using navigation_filter::Inputs;
using navigation_filter::Parameters;
using navigation_filter::Status;
using Filter = Fed<NavigationFilter>;
using Trial = Session<NavigationFilter>;

constexpr int kTurning = 200;  // samples until the hand-over

// Passes what an alignment has found, valid at the time of its last sample.
void hand_over(const AlignmentFilter& alignment, Inputs& inputs) {
    const auto& nav = alignment.outputs.nav;
    auto& initial = inputs.initial;
    initial.valid = true;
    initial.time = nav.time;
    initial.roll = nav.roll;
    initial.pitch = nav.pitch;
    initial.heading = nav.heading;
    initial.velocity = nav.velocity;
    initial.latitude = nav.latitude;
    initial.longitude = nav.longitude;
    initial.height = nav.height;
    initial.gyro_bias = alignment.outputs.gyro_bias;
    initial.accelerometer_bias = alignment.outputs.accelerometer_bias;
    initial.covariance = alignment.outputs.covariance;
}

TEST(NavigationFilterStart, WaitsUntilItIsToldWhere) {
    Filter fed;
    fed.filter.inputs.initial.valid = false;
    const Trial run;
    run.seconds(fed, 5.0);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    EXPECT_EQ(fed.filter.outputs.used_fixes, 0);
    EXPECT_EQ(fed.filter.outputs.rejected_fixes, 0);
    EXPECT_EQ(fed.filter.outputs.nav.latitude, 0.0);

    fed.filter.inputs.initial.valid = true;
    run.advance(fed, 5 * kRate, 8 * kRate);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
    EXPECT_EQ(fed.filter.outputs.used_fixes, 3);
    EXPECT_EQ(fed.log.with("navigation starts at 5.02 s"), 1);
}

TEST(NavigationFilterStart, CarriesAnAttitudeOnFromItsTimeUnderEveryMaster) {
    // On a table that turns at 0.5 rad/s an attitude a sample old is wrong by 0.01 rad; handed over a step
    // late or not, the start must be right.
    Trial run{.heading_error = 0.0};
    run.table.rate = 0.5;
    for (const bool late : {false, true}) {
        Filter fed;
        fed.filter.inputs.initial.valid = false;
        run.start(fed);
        run.advance(fed, 0, kTurning - 1);
        const int valid_at = late ? kTurning - 1 : kTurning;
        auto& initial = fed.initial();
        initial.valid = true;
        initial.time = static_cast<double>(valid_at) / kRate;
        initial.heading = run.table.heading_at(initial.time);
        run.advance(fed, kTurning - 1, kTurning);
        EXPECT_EQ(fed.log.with("navigation starts at"), 1);
        EXPECT_LT(std::abs(heading_error_of(fed, run.table)), 1e-9) << late;
    }
}

TEST(NavigationFilterStart, RefusesWhatIsOldOrImpossibleAndGoesOnWaiting) {
    Filter fed;
    fed.filter.inputs.initial.valid = false;
    const Trial run;
    run.seconds(fed, 4.0);
    auto& initial = fed.initial();
    initial.valid = true;
    initial.time = 3.0;
    run.advance(fed, 200, 203);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    EXPECT_EQ(fed.log.with("hand-over refused: initial.time = 3: must be that of the last IMU sample"), 1);
    initial.valid = false;
    run.advance(fed, 203, 204);
    initial.valid = true;
    initial.time = -1.0;
    initial.latitude = kNaN;
    run.advance(fed, 204, 207);
    EXPECT_EQ(fed.log.with("hand-over refused: initial.latitude"), 1);
    EXPECT_EQ(fed.filter.outputs.status, Status::waiting);
    initial.latitude = run.table.position.latitude;
    run.advance(fed, 207, 300);
    EXPECT_EQ(fed.filter.outputs.status, Status::aligning);
}

TEST(NavigationFilterStart, TakesOverWhatAnAlignmentKnows) {
    // Both filters see the same signals; the alignment is handed over after 300 s.
    Turntable table;
    table.gyro_bias = {1e-7, -2e-7, 3e-7};
    table.accelerometer_bias = {2e-3, -1e-3, 0.0};
    Fed<AlignmentFilter> alignment;
    const Session<AlignmentFilter> aligning{.table = table};
    aligning.seconds(alignment, 300.0);
    const auto& before = alignment.filter.outputs;

    for (const auto model : {navigation_filter::ErrorModel::loose, navigation_filter::ErrorModel::tight}) {
        Filter fed;
        fed.filter.parameters.error_model = model;
        fed.filter.inputs.initial.valid = false;
        const Trial run{.table = table};
        run.start(fed);
        fed.filter.initialise(300.0 - 1.0 / kRate);
        hand_over(alignment.filter, fed.filter.inputs);
        fed.put_sample(300.0, table.increment(300.0 - 1.0 / kRate, 300.0));
        fed.step();
        const auto& after = fed.filter.outputs;
        EXPECT_EQ(after.nav.time, 300.0);
        EXPECT_NEAR(after.nav.heading, before.nav.heading, 1e-12);
        EXPECT_EQ(after.gyro_bias, before.gyro_bias);
        EXPECT_EQ(after.accelerometer_bias, before.accelerometer_bias);
        EXPECT_NEAR(after.heading_sigma / before.heading_sigma, 1.0, 1e-9);
        EXPECT_NEAR(after.misalignment_sigma.x() / before.misalignment_sigma.x(), 1.0, 1e-9);
        EXPECT_NEAR(after.gyro_bias_sigma.z() / before.gyro_bias_sigma.z(), 1.0, 1e-9);
        EXPECT_NEAR(after.velocity_sigma.x() / before.velocity_sigma.x(), 1.0, 1e-9);
        EXPECT_NEAR(after.velocity_sigma.z(), 0.5, 1e-9);  // not a state of the alignment: its prior

        // The heading stays as good as it was, and tilt with the accelerometer bias as correlated as it was:
        // a start from the diagonal would let the first fixes pull them apart.
        run.advance(fed, 300 * kRate, 330 * kRate);
        EXPECT_LT(std::abs(heading_error_of(fed, table)), 3.0 * before.heading_sigma);
        EXPECT_LT(fed.filter.outputs.heading_sigma, 1.01 * before.heading_sigma);
        EXPECT_GE(fed.filter.outputs.used_fixes, 30);
    }
}

TEST(NavigationFilterStart, DoesNotForgetForTheTimeThatItWaited) {
    // With rate_invariant an H-infinity update forgets for the time since the last, or since the start.
    const auto sigma_after = [](int waited) {
        Filter fed;
        fed.filter.parameters.corrector = navigation_filter::Corrector::h_infinity;
        fed.filter.inputs.initial.valid = false;
        const Trial run;
        run.seconds(fed, waited);
        fed.filter.inputs.initial.valid = true;
        run.advance(fed, waited * kRate, (waited + 1) * kRate);
        EXPECT_EQ(fed.filter.outputs.used_fixes, 1);
        return fed.filter.outputs.heading_sigma;
    };
    EXPECT_NEAR(sigma_after(100) / sigma_after(2), 1.0, 1e-6);
}

struct BadStart {
    const char* name;
    std::function<void(Inputs&)> spoil;
};

class NavigationFilterBadStart : public testing::TestWithParam<BadStart> {};

TEST_P(NavigationFilterBadStart, IsRefusedByNameInInitialisation) {
    Lines log;
    NavigationFilter filter(log);
    filter.initialise(0.0);
    GetParam().spoil(filter.inputs);
    try {
        filter.initialise(0.0);
        FAIL() << GetParam().name << " was accepted";
    } catch (const InvalidParameter& error) {
        EXPECT_NE(std::string(error.what()).find(GetParam().name), std::string::npos) << error.what();
    }
    filter.inputs.initial.valid = false;  // what is not used is not looked at
    EXPECT_NO_THROW(filter.initialise(0.0));
}

INSTANTIATE_TEST_SUITE_P(
    OneByOne, NavigationFilterBadStart,
    testing::Values(BadStart{"initial.latitude", [](Inputs& i) { i.initial.latitude = 1.58; }},
                    BadStart{"initial.heading", [](Inputs& i) { i.initial.heading = kNaN; }},
                    BadStart{"initial.velocity[2]", [](Inputs& i) { i.initial.velocity.y() = 1e6; }},
                    BadStart{"initial.gyro_bias[3]", [](Inputs& i) { i.initial.gyro_bias.z() = 1.0; }},
                    BadStart{"initial.height", [](Inputs& i) { i.initial.height = 1e7; }},
                    BadStart{"initial.covariance", [](Inputs& i) { i.initial.covariance(3, 3) = 1.0; }},
                    BadStart{"initial.covariance",
                             [](Inputs& i) {
                                 i.initial.covariance.setIdentity();
                                 i.initial.covariance(0, 1) = 0.5;
                             }},
                    BadStart{"initial.covariance", [](Inputs& i) { i.initial.covariance(0, 0) = kNaN; }}));

struct BadParameter {
    const char* name;
    std::function<void(Parameters&)> spoil;
};

class NavigationFilterParameters : public testing::TestWithParam<BadParameter> {};

TEST_P(NavigationFilterParameters, ThatBreakARuleAreRefusedByName) {
    Lines log;
    NavigationFilter filter(log);
    GetParam().spoil(filter.parameters);
    try {
        filter.initialise(0.0);
        FAIL() << GetParam().name << " was accepted";
    } catch (const InvalidParameter& error) {
        EXPECT_NE(std::string(error.what()).find(GetParam().name), std::string::npos) << error.what();
    }
}

INSTANTIATE_TEST_SUITE_P(
    OneByOne, NavigationFilterParameters,
    testing::Values(
        BadParameter{"measurement.height_sigma", [](Parameters& p) { p.measurement.height_sigma = 0.0; }},
        BadParameter{"process.gyro_markov_time", [](Parameters& p) { p.process.gyro_markov_time = 0.0; }},
        BadParameter{"igg.k1", [](Parameters& p) { p.igg.k1 = p.igg.k0; }},
        BadParameter{"discretisation",
                     [](Parameters& p) {
                         p.error_model = navigation_filter::ErrorModel::full_state;
                         p.discretisation = navigation_filter::Discretisation::euler;
                     }},
        BadParameter{"error_model",
                     [](Parameters& p) { p.error_model = static_cast<navigation_filter::ErrorModel>(7); }}));

}  // namespace
}  // namespace truenorth
