// The velocity of a model without biases lags because of them: by as much as its sigma says.
#include <gtest/gtest.h>

#include "components/alignment_filter.hpp"
#include "components/session.hpp"

namespace truenorth {
namespace {

using Filter = AlignmentFilter;
using Parameters = decltype(Filter::parameters);

constexpr double kGyro = 5e-7;           // [rad/s]
constexpr double kAccelerometer = 6e-4;  // [m/s2]

struct End {
    Eigen::Vector3d velocity;
    Eigen::Vector3d sigma;
};

// Ten minutes on a level table that points north, with sensors that are off by what was told of them.
End after_alignment(bool feedback, double told) {
    Fed<Filter> fed;
    Parameters& p = fed.filter.parameters;
    p.error_model = decltype(p.error_model)::euler_platform;
    p.corrector = decltype(p.corrector)::standard;
    p.velocity_form = decltype(p.velocity_form)::vertical_force;
    p.feedback = feedback;
    p.gate.enabled = false;
    p.prior.heading_sigma = 1.0 * kDegree;
    p.prior.gyro_bias_sigma = told * kGyro;
    p.prior.accelerometer_bias_sigma = told * kAccelerometer;
    p.measurement.velocity_sigma = 0.05;
    p.process.angle_random_walk = 3e-6;
    p.process.velocity_random_walk = 5e-4;
    Session<Filter> run;
    run.table = {.roll = 0.0, .pitch = 0.0, .heading = 0.0};
    run.table.gyro_bias = {0.0, kGyro, 0.0};
    run.table.accelerometer_bias = {0.0, 0.0, kAccelerometer};
    run.heading_error = 0.0;
    run.seconds(fed, 600.0);
    return {fed.filter.outputs.nav.velocity, fed.filter.outputs.velocity_sigma};
}

TEST(VelocityLag, IsWhatTheSigmaSays) {
    for (const bool feedback : {true, false}) {
        const End end = after_alignment(feedback, 1.0);
        const End untold = after_alignment(feedback, 1e-9);
        const Eigen::Vector3d lag = (end.sigma.cwiseAbs2() - untold.sigma.cwiseAbs2()).cwiseSqrt();
        EXPECT_GT(lag.z(), 2.0 * untold.sigma.z());
        EXPECT_NEAR(end.velocity.z() / lag.z(), 1.0, 0.1) << feedback;
        EXPECT_NEAR(std::abs(end.velocity.x()) / lag.x(), 1.0, 0.1) << feedback;
        EXPECT_LT(std::abs(end.velocity.y()), 0.1 * lag.y()) << feedback;
    }
}

}  // namespace
}  // namespace truenorth
