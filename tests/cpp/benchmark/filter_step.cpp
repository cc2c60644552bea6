// Time of one predict + correct of the 10-state filter, linearised and unscented, in both discretisations and
// with the robust corrector, and of the invariant filter.
//
// Prints the median over batches, so that a noisy machine disturbs it little, and the ratio to the first row.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <numbers>
#include <string>

#include "filter/invariant_adapter.hpp"
#include "filter/large_azimuth_adapter.hpp"

namespace {

using truenorth::Discretisation;
using truenorth::Estimator;
using truenorth::HInfinity;
using truenorth::IntervalAverage;
using truenorth::Invariant;
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

// Predict + correct of the 10-state filter.
template <class Corrector>
auto step_of(Estimator<LargeAzimuth> filter, const Corrector& corrector) {
    const truenorth::earth::Position position{32.0 * kDegree, 2.0, 0.0};
    return [=, interval_average = average()]() mutable {
        filter.predict(LargeAzimuth::Interval(interval_average, position, filter.state));
        const auto innovation = filter.innovate({{0.01, -0.02}, {0.0, 0.0, 0.0}});
        filter.apply(corrector.correct(filter.covariance, innovation));
    };
}

// Predict + correct of the invariant filter, on the same motion.
template <bool coloured>
auto step_of_invariant(const Predictor& predictor) {
    using Model = Invariant<coloured>;
    Estimator<Model> filter;
    filter.predictor = predictor;
    filter.model.noise = {.angle_random_walk = 1.5e-6,
                          .velocity_random_walk = 4.9e-4,
                          .gyro_random_walk = 0.0,
                          .accelerometer_random_walk = 0.0,
                          .gyro = {.sigma = 4.8e-7, .correlation_time = 100.0},
                          .accelerometer = {.sigma = 2.9e-3, .correlation_time = 100.0},
                          .position_sigma = Eigen::Vector3d::Constant(5.0),
                          .velocity_sigma = Eigen::Vector3d::Constant(0.1)};
    truenorth::NavigationState start;
    start.velocity << 0.0, 10.0, 0.0;
    start.position.latitude = 32.0 * kDegree;
    filter.state = Model::State::of(start);
    filter.covariance.setZero();
    filter.covariance.diagonal() << Eigen::Vector3d::Constant(0.01), Eigen::Vector3d::Constant(0.25),
        Eigen::Vector3d::Constant(25.0), truenorth::Vector<Model::kSensors>::Constant(1e-6);
    truenorth::Preintegration interval;
    truenorth::ImuIncrement before;
    for (int k = 0; k < 100; ++k) {
        const truenorth::ImuIncrement increment{0.01, {1e-3, -5e-4, 2e-4}, {0.01, 0.02, 0.098}};
        interval = interval * truenorth::Preintegration::of(before, increment);
        before = increment;
    }
    return [=]() mutable {
        filter.predict(interval);
        // The vehicle is where it is predicted, so that it never leaves the Earth.
        const auto here = filter.state.navigation();
        const auto fix =
            Model::Fix::of(here.position, here.velocity, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
        filter.apply(Standard().correct(filter.covariance, filter.innovate(fix)));
    };
}

template <class Step>
double microseconds(Step step) {
    std::array<double, kBatches> times{};
    for (double& time : times) {
        const auto start = std::chrono::steady_clock::now();
        for (int k = 0; k < kStepsPerBatch; ++k) {
            step();
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
    const auto time = [&](const Predictor& predictor, Discretisation discretisation, const auto& corrector) {
        return microseconds(step_of(estimator(predictor, discretisation), corrector));
    };
    const std::array rows{
        Row{"UKF, Euler, 21 points", time(unscented, Discretisation::euler, standard)},
        Row{"UKF, Runge-Kutta, 21 points", time(unscented, Discretisation::runge_kutta, standard)},
        Row{"EKF, Euler", time(linearised, Discretisation::euler, standard)},
        Row{"EKF, Runge-Kutta", time(linearised, Discretisation::runge_kutta, standard)},
        Row{"Robust UKF, Runge-Kutta", time(unscented, Discretisation::runge_kutta, robust)},
        Row{"Invariant EKF, 15 states", microseconds(step_of_invariant<false>(linearised))},
        Row{"Invariant UKF, 15 states", microseconds(step_of_invariant<false>(unscented))},
        Row{"Invariant EKF, 21 states", microseconds(step_of_invariant<true>(linearised))},
    };
    std::printf("Predict + correct; the 10-state filter if nothing is said\n\n");
    std::printf("| filter                       | us per step | ratio |\n");
    std::printf("|------------------------------|------------:|------:|\n");
    for (const Row& row : rows) {
        std::printf("| %-28s | %11.2f | %5.2f |\n", row.name, row.time, row.time / rows[0].time);
    }
    return 0;
}
