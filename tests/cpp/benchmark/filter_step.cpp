// Time of one predict + correct of the 10-state filter, for every predictor, discretisation and corrector.
//
// Prints the median over batches, so that a noisy machine disturbs it little, and the ratio to the first row.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <numbers>
#include <string>

#include "error_models/large_azimuth.hpp"
#include "estimation/estimator.hpp"
#include "estimation/h_infinity.hpp"

namespace {

using truenorth::Discretisation;
using truenorth::Estimator;
using truenorth::HInfinity;
using truenorth::IntervalAverage;
using truenorth::LargeAzimuth;
using truenorth::Linearised;
using truenorth::Predictor;
using truenorth::Standard;
using truenorth::Unscented;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kStepsPerBatch = 2000;
constexpr int kBatches = 51;

Estimator<LargeAzimuth> estimator(const Predictor& predictor, Discretisation discretisation) {
    Estimator<LargeAzimuth> filter;
    filter.predictor = predictor;
    filter.model.discretisation = discretisation;
    filter.model.noise = {1.5e-6, 4.9e-4, 0.1};
    LargeAzimuth::State sigma;
    sigma << 0.5, 0.5, 0.5 * kDegree, 0.5 * kDegree, 10.0 * kDegree, 9.8e-3, 9.8e-3, 2.4e-7, 2.4e-7, 2.4e-7;
    filter.covariance = sigma.cwiseAbs2().asDiagonal();
    filter.state.setZero();
    return filter;
}

// A swaying ship under way: 100 samples of 10 ms, averaged.
IntervalAverage average() {
    truenorth::Mechanisation mechanisation;
    mechanisation.state.velocity << 0.0, 10.0, 0.0;
    mechanisation.state.position.latitude = 32.0 * kDegree;
    IntervalAverage sum;
    for (int k = 0; k < 100; ++k) {
        const truenorth::NavigationState before = mechanisation.state;
        mechanisation.advance({0.01, {1e-3, -5e-4, 2e-4}, {0.01, 0.02, 0.098}});
        sum.add(before, mechanisation, 0.01);
    }
    return sum;
}

template <class Corrector>
double microseconds(Estimator<LargeAzimuth> filter, const Corrector& corrector) {
    const IntervalAverage interval_average = average();
    const truenorth::earth::Position position{32.0 * kDegree, 2.0, 0.0};
    std::array<double, kBatches> times{};
    for (double& time : times) {
        const auto start = std::chrono::steady_clock::now();
        for (int k = 0; k < kStepsPerBatch; ++k) {
            filter.predict(LargeAzimuth::Interval(interval_average, position, filter.state));
            const auto innovation = filter.innovate({{0.01, -0.02}, {0.0, 0.0, 0.0}});
            filter.apply(corrector.correct(filter.covariance, innovation));
        }
        const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;
        time = elapsed.count() / kStepsPerBatch;
    }
    std::nth_element(times.begin(), times.begin() + kBatches / 2, times.end());
    return times[kBatches / 2];
}

}  // namespace

int main() {
    const Predictor unscented = Unscented();
    const Predictor linearised = Linearised();
    HInfinity<LargeAzimuth::kStates> robust;
    robust.scale.setConstant(1e-3);

    struct Row {
        const char* name;
        double time;
    };
    const Standard standard;
    const std::array rows{
        Row{"UKF, Euler, 21 points", microseconds(estimator(unscented, Discretisation::euler), standard)},
        Row{"UKF, Runge-Kutta, 21 points",
            microseconds(estimator(unscented, Discretisation::runge_kutta), standard)},
        Row{"EKF, Euler", microseconds(estimator(linearised, Discretisation::euler), standard)},
        Row{"EKF, Runge-Kutta", microseconds(estimator(linearised, Discretisation::runge_kutta), standard)},
        Row{"Robust UKF, Runge-Kutta",
            microseconds(estimator(unscented, Discretisation::runge_kutta), robust)},
    };
    std::printf("Predict + correct of the 10-state filter (aim for the first row: at most 2 us)\n\n");
    std::printf("| filter                       | us per step | ratio |\n");
    std::printf("|------------------------------|------------:|------:|\n");
    for (const Row& row : rows) {
        std::printf("| %-28s | %11.2f | %5.2f |\n", row.name, row.time, row.time / rows[0].time);
    }
    return 0;
}
