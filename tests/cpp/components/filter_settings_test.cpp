#include "components/filter_settings.hpp"

#include <gtest/gtest.h>

#include "AlignmentFilter/variables.hpp"

namespace truenorth {
namespace {

TEST(FilterSettings, GiveTheGuardOfIggTheAdaptiveFactorOfTheParameters) {
    alignment_filter::Parameters parameters;
    parameters.adaptive.threshold = 12.0;
    parameters.adaptive.form = alignment_filter::AdaptiveForm::printed;
    Corrector<2, 2> corrector;
    configure_corrector(corrector, Vector<2>(0.1, 0.0), parameters);
    EXPECT_EQ(corrector.igg.guard.threshold, 12.0);
    EXPECT_EQ(corrector.igg.guard.form, AdaptiveFactor<2>::Form::printed);
}

TEST(FilterSettings, LimitTheAdaptiveFactorWhereTheStateHasAPrior) {
    Corrector<2, 2> corrector;
    configure_corrector(corrector, Vector<2>(0.1, 0.0), alignment_filter::Parameters());
    for (const auto& factor : {corrector.adaptive_factor, corrector.igg.guard}) {
        EXPECT_EQ(factor.widest(0), 100.0);
        EXPECT_TRUE(std::isinf(factor.widest(1)));
    }
}

}  // namespace
}  // namespace truenorth
