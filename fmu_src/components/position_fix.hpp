// What the models share that measure position and velocity of the GNSS antenna.
#pragma once

#include "components/adapter.hpp"

namespace truenorth {

struct PositionFix {
    // The elements of the output `innovation` where velocities begin; positions stand before them.
    static constexpr int kVelocitySlot = 12;

    static int slot(int measurement) {
        return measurement < 3 ? measurement : kVelocitySlot + measurement - 3;
    }

    // Sigmas of a fix that the parameters state, east, north, up [m], [m/s].
    template <class Parameters>
    static Eigen::Vector3d position_sigma(const Parameters& p) {
        const auto& measurement = p.measurement;
        return {measurement.position_sigma, measurement.position_sigma, measurement.height_sigma};
    }
    template <class Parameters>
    static Eigen::Vector3d velocity_sigma(const Parameters& p) {
        return Eigen::Vector3d::Constant(p.measurement.velocity_sigma);
    }
};

}  // namespace truenorth
