// How the states of a model make the errors of the navigation state: a correction by d moves the best state
// by J d.
#include <gtest/gtest.h>

#include "error_models/navigation_error.hpp"
#include "error_models/random_values.hpp"
#include "filter/euler_platform_adapter.hpp"
#include "filter/full_state_adapter.hpp"
#include "filter/invariant_engine.hpp"
#include "filter/large_azimuth_adapter.hpp"
#include "filter/loose_adapter.hpp"
#include "filter/tight_adapter.hpp"

namespace truenorth {
namespace {

template <class E>
class NavigationErrors : public testing::Test {};

using Engines = testing::Types<NavigationEngine<LargeAzimuth>, NavigationEngine<EulerPlatform>,
                               NavigationEngine<Loose>, NavigationEngine<Tight>, StateEngine<FullState>,
                               InvariantEngine<false>, InvariantEngine<true>>;
TYPED_TEST_SUITE(NavigationErrors, Engines);

TYPED_TEST(NavigationErrors, AreWhatACorrectionMovesTheBestStateBy) {
    RandomValues random(1);
    for (int n = 0; n < 20; ++n) {
        TypeParam engine;
        engine.start({.state = random.navigation_state()});
        const auto J = engine.navigation_errors();
        typename TypeParam::Correction correction{};
        for (int i = 0; i < TypeParam::kStates; ++i) {
            correction.deviation(i) = 1e-6 * random.vector(1.0).x();
        }
        correction.covariance.setIdentity();
        const NavigationState before = engine.best();
        const Eigen::Vector3d gyro_before = engine.gyro_bias();
        ASSERT_TRUE(engine.apply(correction).finite);
        const truenorth::Vector<9> moved = navigation_error::local(engine.best(), before);
        const truenorth::Vector<aiding::kErrors> expected = J * correction.deviation;
        EXPECT_LT((moved.template head<6>() - expected.template head<6>()).norm(), 1e-9);
        EXPECT_LT((moved.template tail<3>() - expected.template segment<3>(aiding::kPosition)).norm(), 1e-7);
        if (!std::is_same_v<TypeParam, NavigationEngine<Tight>>) {  // its process is no part of gyro_bias
            EXPECT_LT((engine.gyro_bias() - gyro_before - expected.template segment<3>(aiding::kGyro)).norm(),
                      3e-12);  // second order: the group turns what it moves
        }
    }
}

}  // namespace
}  // namespace truenorth
