// Time of one predict + correct of the 10-state filter, linearised and unscented, in both discretisations and
// with the robust corrector, and of the invariant filter; of one predict of the full nonlinear model, which
// does it at every IMU sample.
//
// Prints the fastest batch, so that a noisy machine disturbs it little, and the ratio to the first row.
#include <array>
#include <cstdio>

#include "benchmark/alignment.hpp"
#include "benchmark/batches.hpp"
#include "filter/full_state_adapter.hpp"
#include "filter/invariant_adapter.hpp"

namespace {

using truenorth::Discretisation;
using truenorth::Estimator;
using truenorth::FullState;
using truenorth::HInfinity;
using truenorth::Invariant;
using truenorth::LargeAzimuth;
using truenorth::Linearised;
using truenorth::Predictor;
using truenorth::Standard;
using truenorth::Unscented;
namespace benchmark = truenorth::benchmark;

// Predict + correct of the 10-state filter.
template <class Corrector>
auto step_of(const Estimator<LargeAzimuth>& start, const Corrector& corrector) {
    return [corrector, filter = start, average = benchmark::average()]() mutable {
        filter.predict(LargeAzimuth::Interval(average, benchmark::kPosition, filter.state));
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
    start.position = benchmark::kPosition;
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

// Predict of the full nonlinear model, at 100 Hz.
auto step_of_full_state(const Predictor& predictor) {
    Estimator<FullState> filter;
    filter.predictor = predictor;
    filter.model.noise = {.angle_random_walk = 1.5e-6,
                          .velocity_random_walk = 4.9e-4,
                          .position_sigma = Eigen::Vector3d::Constant(5.0),
                          .velocity_sigma = Eigen::Vector3d::Constant(0.1)};
    filter.state.velocity << 0.0, 10.0, 0.0;
    filter.state.position = benchmark::kPosition;
    filter.covariance.diagonal() << Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(0.01),
        Eigen::Vector3d::Constant(25.0);
    return [filter, mechanisation = truenorth::Mechanisation(filter.state)]() mutable {
        const truenorth::ImuIncrement increment{0.01, {1e-3, -5e-4, 2e-4}, {0.01, 0.02, 0.098}};
        filter.predict({.mechanisation = mechanisation, .increment = increment});
        mechanisation.advance(increment);
        mechanisation.state = filter.state;
    };
}

}  // namespace

int main() {
    const Predictor unscented = Unscented();
    const Predictor linearised = Linearised();
    const Standard standard;
    HInfinity<LargeAzimuth::kStates> robust;
    robust.scale.setConstant(1e-3);

    constexpr auto euler = Discretisation::euler;
    constexpr auto runge_kutta = Discretisation::runge_kutta;
    const auto of = [](const Predictor& predictor, Discretisation discretisation, const auto& corrector) {
        return benchmark::batch(step_of(benchmark::alignment(predictor, discretisation), corrector));
    };
    const std::array names{
        "UKF, Euler, 21 points",    "UKF, Runge-Kutta, 21 points", "EKF, Euler",
        "EKF, Runge-Kutta",         "Robust UKF, Runge-Kutta",     "Invariant EKF, 15 states",
        "Invariant UKF, 15 states", "Invariant EKF, 21 states",    "Full state EKF, predict",
        "Full state UKF, predict"};
    const std::vector<double> times = benchmark::microseconds(
        {of(unscented, euler, standard), of(unscented, runge_kutta, standard),
         of(linearised, euler, standard), of(linearised, runge_kutta, standard),
         of(unscented, runge_kutta, robust), benchmark::batch(step_of_invariant<false>(linearised)),
         benchmark::batch(step_of_invariant<false>(unscented)),
         benchmark::batch(step_of_invariant<true>(linearised)),
         benchmark::batch(step_of_full_state(linearised)), benchmark::batch(step_of_full_state(unscented))});
    std::printf("Predict + correct; the 10-state filter if nothing is said\n\n");
    std::printf("| filter                       | us per step | ratio |\n");
    std::printf("|------------------------------|------------:|------:|\n");
    for (std::size_t i = 0; i < names.size(); ++i) {
        std::printf("| %-28s | %11.2f | %5.2f |\n", names[i], times[i], times[i] / times[0]);
    }
    return 0;
}
