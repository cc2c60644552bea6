// What a correction, or a new start, did to the mechanisation.
#pragma once

#include "inertial/mechanisation.hpp"

namespace truenorth {

struct Change {
    bool finite = true;  // false: the estimate is not, and cannot be used any more
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // of the computed attitude
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // [m/s]
    Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  // [m]

    // A state to which this has happened.
    [[nodiscard]] NavigationState of(const NavigationState& before) const;

    // From one state to another.
    static Change between(const NavigationState& before, const NavigationState& after);
};

}  // namespace truenorth
