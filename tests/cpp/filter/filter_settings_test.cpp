#include "filter/filter_settings.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "AlignmentFilter/variables.hpp"
#include "filter/large_azimuth_adapter.hpp"
#include "filter/navigation_engine.hpp"

namespace truenorth {
namespace {

TEST(FilterSettings, GiveTheGuardOfIggTheAdaptiveFactorOfTheParameters) {
    alignment_filter::Parameters parameters;
    parameters.adaptive.threshold = 12.0;
    parameters.adaptive.form = alignment_filter::AdaptiveForm::printed;
    Corrector<2, 2> corrector;
    corrector.configure(parameters);
    EXPECT_EQ(corrector.igg.guard.threshold, 12.0);
    EXPECT_EQ(corrector.igg.guard.form, AdaptiveFactor<2>::Form::printed);
}

TEST(FilterSettings, LimitTheAdaptiveFactorBeyondPriorAndFix) {
    alignment_filter::Parameters parameters;
    parameters.prior.heading_sigma = 0.1;
    parameters.prior.velocity_sigma = 1e-3;
    parameters.measurement.velocity_sigma = 0.5;
    NavigationEngine<LargeAzimuth> engine;
    configure(engine, parameters);
    for (const auto& factor : {engine.corrector.adaptive_factor, engine.corrector.igg.guard}) {
        EXPECT_DOUBLE_EQ(factor.widest(LargeAzimuth::kPhiUp), 0.3);
        EXPECT_DOUBLE_EQ(factor.widest(LargeAzimuth::kPhiEast), 0.1);
        EXPECT_DOUBLE_EQ(factor.widest(LargeAzimuth::kGyroX), 10.0 * parameters.prior.gyro_bias_sigma);
        EXPECT_DOUBLE_EQ(factor.widest(LargeAzimuth::kVelocityNorth), 5e3);
    }
}

// Where a model has its positions, of a model that has some.
struct WithPosition {
    static constexpr Block position{.first = 0, .count = 3};
};

TEST(FilterSettings, StartVariationalBayesWithTheVariancesOfTheParameters) {
    alignment_filter::Parameters parameters;
    parameters.variational_bayes.a = 2.0;
    parameters.variational_bayes.position_sigma = 3.0;
    parameters.variational_bayes.velocity_sigma = 0.5;
    NavigationEngine<LargeAzimuth> engine;  // measures velocities alone
    configure(engine, parameters);
    EXPECT_EQ(engine.corrector.variational_bayes.a, 2.0);
    EXPECT_EQ(engine.corrector.variational_bayes.start_variance, Vector<2>(0.25, 0.25));
    Vector<6> expected;
    expected << 9.0, 9.0, 9.0, 0.25, 0.25, 0.25;
    EXPECT_EQ((starting_variance_of<WithPosition, 6>(parameters)), expected);
}

}  // namespace
}  // namespace truenorth
