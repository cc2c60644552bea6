// Time of one predict + correct of the 10-state UKF, beside the same filter in other libraries:
//
//     make bench PEERS=FOLDER    a folder with clones of mherb/kalman as `kalman` and of sfwa/ukf as `ukf`
//
// All of them move the same 21 points by the rate of LargeAzimuth, with the same parameters of the unscented
// transformation. The peers' measurement has points too, with the lever arm in them; ours is linearised. Ours
// is timed as it is delivered: repair of the covariance, gate and corrector, hindsight. That it does the same
// work is shown without hindsight and gate, which no peer has.
//
// sfwa/ukf is written for Eigen 3.2; what it needs with 3.4 and C++20 is the headers that it does not
// include.
#include <array>
#include <cassert>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "benchmark/alignment.hpp"
#include "benchmark/batches.hpp"

// NOLINTBEGIN(llvm-include-order)
#define UKF_DOUBLE_PRECISION
#include <UKF/Core.h>
#include <UKF/Integrator.h>
#include <UKF/MeasurementVector.h>
#include <UKF/StateVector.h>

#include <kalman/MeasurementModel.hpp>
#include <kalman/SystemModel.hpp>
#include <kalman/UnscentedKalmanFilter.hpp>
// NOLINTEND(llvm-include-order)

namespace {

using truenorth::Discretisation;
using truenorth::LargeAzimuth;
using truenorth::Matrix;
using truenorth::Vector;
namespace benchmark = truenorth::benchmark;

constexpr int kStates = LargeAzimuth::kStates;
constexpr int kMeasurements = LargeAzimuth::kMeasurements;
constexpr truenorth::UnscentedParameters kPoints;

// What every filter is given.
struct Epoch {
    truenorth::IntervalAverage average = benchmark::average();
    LargeAzimuth::Fix fix{{0.01, -0.02}, {0.3, -0.1, 0.05}};

    [[nodiscard]] LargeAzimuth::Interval interval(const LargeAzimuth::State& x) const {
        return {average, benchmark::kPosition, x};
    }
};

// The velocity difference that a state predicts.
Eigen::Vector2d predicted(const LargeAzimuth::State& x, const LargeAzimuth::Fix& fix) {
    const truenorth::MisalignmentMatrix<double> C(truenorth::Misalignment::large_azimuth,
                                                  x[LargeAzimuth::kPhiEast], x[LargeAzimuth::kPhiNorth],
                                                  x[LargeAzimuth::kPhiUp]);
    const truenorth::Components<double> lever{fix.lever_velocity.x(), fix.lever_velocity.y(),
                                              fix.lever_velocity.z()};
    return {x[LargeAzimuth::kVelocityEast] + lever[0] - C.transposed_times(0, lever),
            x[LargeAzimuth::kVelocityNorth] + lever[1] - C.transposed_times(1, lever)};
}

// The filter as it is delivered.
struct Delivered {
    Delivered(Discretisation discretisation, truenorth::settings::Corrector method)
        : filter(benchmark::alignment(truenorth::Unscented(), discretisation)) {
        corrector.method = method;
    }

    void operator()() {
        filter.predict(epoch.interval(filter.state));
        const auto innovation = filter.innovate(epoch.fix);
        filter.apply(corrector.correct(filter.covariance, innovation));
    }

    Epoch epoch;
    truenorth::Estimator<LargeAzimuth> filter;
    truenorth::Corrector<kStates, kMeasurements> corrector;
};

// Without gate and hindsight.
struct Plain {
    explicit Plain(Discretisation discretisation)
        : filter(benchmark::alignment(truenorth::Unscented(), discretisation)) {}

    void operator()() {
        filter.predict(epoch.interval(filter.state));
        const auto correction = truenorth::Standard().correct(filter.covariance, filter.innovate(epoch.fix));
        filter.state += correction.deviation;
        filter.covariance = correction.covariance;
    }

    [[nodiscard]] LargeAzimuth::State state() const { return filter.state; }
    [[nodiscard]] Matrix<kStates> covariance() const { return filter.covariance; }

    Epoch epoch;
    truenorth::Estimator<LargeAzimuth> filter;
};

// mherb/kalman.
class Kalman {
  public:
    explicit Kalman(Discretisation discretisation) : filter_(kPoints.alpha, kPoints.beta, kPoints.kappa) {
        const auto start = benchmark::alignment(truenorth::Unscented(), discretisation);
        process_.model = start.model;
        process_.setCovariance(start.model.process_noise(start.state, epoch_.interval(start.state)));
        measurement_.setCovariance(start.model.measurement_noise(start.state, epoch_.fix));
        measurement_.fix = epoch_.fix;
        filter_.init(start.state);
        filter_.setCovariance(start.covariance);
    }

    void operator()() {
        const LargeAzimuth::Interval interval = epoch_.interval(filter_.getState());
        process_.interval = &interval;
        filter_.predict(process_);
        filter_.update(measurement_, Measurement(epoch_.fix.velocity_difference));
    }

    [[nodiscard]] LargeAzimuth::State state() const { return filter_.getState(); }
    [[nodiscard]] Matrix<kStates> covariance() const { return filter_.getCovariance(); }

  private:
    using State = ::Kalman::Vector<double, kStates>;
    using Measurement = ::Kalman::Vector<double, kMeasurements>;

    struct Process : ::Kalman::SystemModel<State> {
        [[nodiscard]] State f(const State& x, const Control& /*u*/) const override {
            const auto rate = [&](const LargeAzimuth::State& point) { return model.rate(point, *interval); };
            return truenorth::integrate(LargeAzimuth::State(x), rate, interval->dt, model.discretisation);
        }
        LargeAzimuth model;
        const LargeAzimuth::Interval* interval = nullptr;
    };

    struct Velocity : ::Kalman::MeasurementModel<State, Measurement> {
        [[nodiscard]] Measurement h(const State& x) const override { return predicted(x, fix); }
        LargeAzimuth::Fix fix;
    };

    Epoch epoch_;
    Process process_;
    Velocity measurement_;
    ::Kalman::UnscentedKalmanFilter<State> filter_;
};

using UkfState = UKF::StateVector<UKF::Field<0, Vector<kStates>>>;
using UkfMeasurement = UKF::FixedMeasurementVector<UKF::Field<0, Vector<kMeasurements>>>;

struct UkfDrive {
    const LargeAzimuth* model;
    const LargeAzimuth::Interval* interval;
};

}  // namespace

namespace UKF {

namespace Parameters {
template <>
constexpr real_t AlphaSquared<UkfState> = kPoints.alpha * kPoints.alpha;
template <>
constexpr real_t Beta<UkfState> = kPoints.beta;
template <>
constexpr real_t Kappa<UkfState> = kPoints.kappa;
}  // namespace Parameters

template <>
template <>
UkfState UkfState::derivative<UkfDrive>(const UkfDrive& drive) const {
    return UkfState(drive.model->rate(LargeAzimuth::State(*this), *drive.interval));
}

template <>
template <>
Vector<kMeasurements> UkfMeasurement::expected_measurement<UkfState, 0, const LargeAzimuth::Fix*>(
    const UkfState& state, const LargeAzimuth::Fix* const& fix) {
    return predicted(state, *fix);
}

}  // namespace UKF

namespace {

// sfwa/ukf. It adds the process noise before the points are moved.
template <class Integrator>
class Ukf {
  public:
    explicit Ukf(Discretisation discretisation) {
        const auto start = benchmark::alignment(truenorth::Unscented(), discretisation);
        model_ = start.model;
        filter_.state = UkfState(start.state);
        filter_.covariance = start.covariance;
        filter_.process_noise_covariance =
            start.model.process_noise(start.state, epoch_.interval(start.state));
        filter_.measurement_covariance =
            Vector<kMeasurements>(start.model.measurement_noise(start.state, epoch_.fix).diagonal());
    }

    void operator()() {
        const LargeAzimuth::Interval interval = epoch_.interval(filter_.state);
        filter_.a_priori_step(interval.dt, UkfDrive{&model_, &interval});
        const LargeAzimuth::Fix* fix = &epoch_.fix;
        filter_.innovation_step(UkfMeasurement(epoch_.fix.velocity_difference), fix);
        filter_.a_posteriori_step();
    }

    [[nodiscard]] LargeAzimuth::State state() const { return filter_.state; }
    [[nodiscard]] Matrix<kStates> covariance() const { return filter_.covariance; }

  private:
    Epoch epoch_;
    LargeAzimuth model_;
    UKF::Core<UkfState, UkfMeasurement, Integrator> filter_;
};

// How far a peer is from us after so many steps: states in sigmas, and sigmas relative to ours.
template <class Peer>
void compare(const char* name, Peer peer, Plain ours) {
    constexpr int kSteps = 20;
    for (int k = 0; k < kSteps; ++k) {
        peer();
        ours();
    }
    const LargeAzimuth::State sigma = ours.covariance().diagonal().cwiseSqrt();
    const LargeAzimuth::State peers_sigma = peer.covariance().diagonal().cwiseSqrt();
    const double state = (peer.state() - ours.state()).cwiseQuotient(sigma).cwiseAbs().maxCoeff();
    const double spread = (peers_sigma.cwiseQuotient(sigma).array() - 1.0).abs().maxCoeff();
    std::printf("%-28s after %d steps: states within %.1e sigma of ours, sigmas within %.1e\n", name, kSteps,
                state, spread);
    if (!(state < 0.05 && spread < 0.05)) {
        throw std::runtime_error(std::string(name) + " does not compute what we compute");
    }
}

template <class Integrator>
std::vector<double> time(const char* name, Discretisation discretisation) {
    const Plain plain(discretisation);
    const Kalman kalman(discretisation);
    const Ukf<Integrator> ukf(discretisation);
    std::printf("%s\n", name);
    compare("  mherb/kalman", kalman, plain);
    compare("  sfwa/ukf", ukf, plain);
    return benchmark::microseconds(
        {benchmark::batch(Delivered(discretisation, truenorth::settings::Corrector::combined)),
         benchmark::batch(Delivered(discretisation, truenorth::settings::Corrector::standard)),
         benchmark::batch(plain), benchmark::batch(kalman), benchmark::batch(ukf)});
}

}  // namespace

int main() {
    const auto euler = time<UKF::IntegratorEuler>("Euler", Discretisation::euler);
    const auto runge_kutta = time<UKF::IntegratorRK4>("Runge-Kutta", Discretisation::runge_kutta);
    const std::array names{"ours, as it comes (combined)", "ours, standard behind the gate",
                           "ours, no gate, no hindsight", "mherb/kalman", "sfwa/ukf"};
    const double best_euler = std::min(euler[3], euler[4]);
    const double best_runge_kutta = std::min(runge_kutta[3], runge_kutta[4]);
    std::printf("\nPredict + correct of the 10-state UKF, 21 points; ratio to the best peer\n\n");
    std::printf("| filter                         | Euler, us | ratio | Runge-Kutta, us | ratio |\n");
    std::printf("|--------------------------------|----------:|------:|----------------:|------:|\n");
    for (std::size_t i = 0; i < names.size(); ++i) {
        std::printf("| %-30s | %9.2f | %5.2f | %15.2f | %5.2f |\n", names[i], euler[i], euler[i] / best_euler,
                    runge_kutta[i], runge_kutta[i] / best_runge_kutta);
    }
    return 0;
}
