#include "filter/change.hpp"

#include "inertial/earth.hpp"

namespace truenorth {

NavigationState Change::of(const NavigationState& before) const {
    return {.q_bn = (Eigen::Quaterniond(rotation) * before.q_bn).normalized(),
            .velocity = before.velocity + velocity,
            .position = earth::displaced(before.position, displacement)};
}

Change Change::between(const NavigationState& before, const NavigationState& after) {
    return {.rotation = (after.q_bn * before.q_bn.conjugate()).toRotationMatrix(),
            .velocity = after.velocity - before.velocity,
            .displacement = earth::displacement(before.position, after.position)};
}

}  // namespace truenorth
