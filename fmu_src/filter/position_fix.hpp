// What the models share that measure position and velocity of the GNSS antenna.
#pragma once

#include "filter/adapter.hpp"

namespace truenorth {

struct PositionFix {
    // Which element of an output such as `innovation` is a measurement. NavigationFilter leaves room for
    // pseudoranges, then range rates; AlignmentFilter, whose other models measure velocity alone, begins with
    // that.
    template <class Output>
    static int slot(int measurement, const Output& /*output*/) {
        constexpr int velocity = Output::SizeAtCompileTime > 6 ? 12 : 0;
        constexpr int position = velocity > 0 ? 0 : 3;
        return measurement < 3 ? position + measurement : velocity + measurement - 3;
    }

    // Which component of a GnssFix a measurement is.
    static constexpr int component(int measurement) { return measurement; }

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
