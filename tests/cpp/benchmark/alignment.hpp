// The alignment that benchmarks time: the 10-state filter on a swaying ship under way, a fix a second.
#pragma once

#include <numbers>

#include "filter/large_azimuth_adapter.hpp"

namespace truenorth::benchmark {

inline constexpr double kDegree = std::numbers::pi / 180.0;
inline constexpr earth::Position kPosition{32.0 * kDegree, 2.0, 0.0};

inline Estimator<LargeAzimuth> alignment(const Predictor& predictor, Discretisation discretisation) {
    Estimator<LargeAzimuth> filter;
    filter.predictor = predictor;
    filter.model.discretisation = discretisation;
    filter.model.noise = {1.5e-6, 4.9e-4, 0.1};
    LargeAzimuth::State sigma;
    sigma << 0.5, 0.5, 0.5 * kDegree, 0.5 * kDegree, 10.0 * kDegree, 9.8e-3, 9.8e-3, 2.4e-7, 2.4e-7, 2.4e-7;
    filter.covariance = sigma.cwiseAbs2().asDiagonal();
    return filter;
}

// 100 samples of 10 ms.
inline IntervalAverage average() {
    Mechanisation mechanisation;
    mechanisation.state.velocity << 0.0, 10.0, 0.0;
    mechanisation.state.position.latitude = kPosition.latitude;
    IntervalAverage sum;
    for (int k = 0; k < 100; ++k) {
        const NavigationState before = mechanisation.state;
        mechanisation.advance({0.01, {1e-3, -5e-4, 2e-4}, {0.01, 0.02, 0.098}});
        sum.add(before, mechanisation, 0.01);
    }
    return sum;
}

}  // namespace truenorth::benchmark
