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
    configure_corrector(corrector, parameters);
    EXPECT_EQ(corrector.igg.guard.threshold, 12.0);
    EXPECT_EQ(corrector.igg.guard.form, AdaptiveFactor::Form::printed);
}

}  // namespace
}  // namespace truenorth
