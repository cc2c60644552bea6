#include "error_models/neighbours.hpp"

#include <gtest/gtest.h>

#include "error_models/random_values.hpp"

namespace truenorth {
namespace {

using navigation_error::Error;

ImuIncrement increment(RandomValues& random) {
    return {.dt = 0.02, .delta_angle = random.vector(0.02), .delta_velocity = random.vector(0.3)};
}

Neighbours::Deviations deviations(RandomValues& random, double angle) {
    Neighbours::Deviations columns;
    for (int i = 0; i < Neighbours::kLanes; ++i) {
        columns.col(i) << random.vector(angle), random.vector(0.5), random.vector(20.0);
    }
    return columns;
}

TEST(Neighbours, AreMechanisedLikeTheStateItself) {
    RandomValues random(1);
    for (const double angle : {1e-6, 1e-3, 1.0}) {  // the last one beyond series
        for (int n = 0; n < 20; ++n) {
            const NavigationState state = random.navigation_state();
            Mechanisation mechanisation(state);
            mechanisation.advance(increment(random));
            const ImuIncrement next = increment(random);
            const Neighbours::Deviations start = deviations(random, angle);
            const Neighbours neighbours(state, mechanisation, next);
            const Neighbours::Deviations end = neighbours.moved(start);
            const auto moved = [&](const NavigationState& from) {
                Mechanisation alone = mechanisation;
                alone.state = from;
                alone.advance(next);
                return alone.state;
            };
            for (int i = 0; i < Neighbours::kLanes; ++i) {
                const Error expected = navigation_error::local(
                    moved(state), moved(navigation_error::retract(state, Error(start.col(i)))));
                const Error off = end.col(i) - expected;
                EXPECT_LT(off.head<3>().norm(), 1e-14);
                EXPECT_LT(off.segment<3>(navigation_error::kVelocity).norm(), 1e-12);
                EXPECT_LT(off.tail<3>().norm(), 1e-8);  // the last bit of a latitude is 7e-10 m
            }
        }
    }
}

// Sigma points lie a thousandth of a sigma off: differences of whole latitudes and velocities would be noise.
TEST(Neighbours, MoveByTheirSmallDifferencesAlone) {
    RandomValues random(2);
    const NavigationState state = random.navigation_state();
    Mechanisation mechanisation(state);
    mechanisation.advance(increment(random));
    const Neighbours neighbours(state, mechanisation, increment(random));
    const Neighbours::Deviations start = 1e-3 * deviations(random, 1e-3);
    const Neighbours::Deviations end = neighbours.moved(start);
    const Neighbours::Deviations end_of_less = neighbours.moved(1e-3 * start);
    const Neighbours::Deviations off = 1e3 * end_of_less - end;
    EXPECT_LT(off.middleRows<3>(navigation_error::kVelocity).norm(), 1e-12);
    EXPECT_LT(off.bottomRows<3>().norm(), 1e-8);
}

}  // namespace
}  // namespace truenorth
