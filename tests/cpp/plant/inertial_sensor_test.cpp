#include "plant/inertial_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

namespace truenorth::plant {
namespace {

constexpr double kPeriod = 0.01;
constexpr double kSigmas = 5.0;  // every statistical bound here is missed by chance once in 2 million

Eigen::Vector3d some_increment() { return {1e-3, -2e-3, 3e-3}; }

InertialSensor::Streams streams(std::uint32_t seed) {
    return {
        .bias = {seed, NoiseSource::gyro_bias},
        .walk = {seed, NoiseSource::gyro_bias_walk},
        .white = {seed, NoiseSource::gyro_white},
        .markov = {seed, NoiseSource::gyro_markov},
        .wave = {seed, NoiseSource::gyro_wave},
    };
}

// What a sensor makes of `count` equal increments.
std::vector<Eigen::Vector3d> measure(const InertialSensor::Errors& errors, std::uint32_t seed, int count,
                                     const Eigen::Vector3d& increment = some_increment()) {
    const InertialSensor sensor(errors, kPeriod, streams(seed));
    InertialSensor::State state = sensor.begin();
    std::vector<Eigen::Vector3d> measured;
    for (int k = 1; k <= count; ++k) {
        measured.push_back(sensor.measure(state, static_cast<std::uint64_t>(k), k * kPeriod, increment));
    }
    return measured;
}

TEST(InertialSensor, WithoutErrorsTheTruthComesOut) {
    for (const Eigen::Vector3d& increment : measure(InertialSensor::Errors(), 1, 10)) {
        EXPECT_EQ(increment, some_increment());
    }
}

TEST(InertialSensor, FixedBiasIsAddedToTheRate) {
    InertialSensor::Errors errors;
    errors.bias = {0.1, 0.2, -0.3};
    EXPECT_LT((measure(errors, 1, 1)[0] - some_increment() - errors.bias * kPeriod).norm(), 1e-17);
}

TEST(InertialSensor, ScaleFactorsAndMisalignment) {
    InertialSensor::Errors errors;
    errors.scale_factor = {0.01, 0.0, -0.02};
    errors.misalignment = {0.0, 0.0, 1e-3};  // the triad is turned counter-clockwise about up
    const Eigen::Vector3d measured = measure(errors, 1, 1, {1.0, 0.0, 1.0})[0];
    // The right axis turns towards forward and sees cos of the input, forward turns away from right and sees
    // -sin.
    EXPECT_NEAR(measured.x(), 1.01 * std::cos(1e-3), 1e-15);
    EXPECT_NEAR(measured.y(), -std::sin(1e-3), 1e-15);
    EXPECT_NEAR(measured.z(), 0.98, 1e-15);
}

TEST(InertialSensor, TheBiasStepsInTheMiddleOfASample) {
    InertialSensor::Errors errors;
    errors.bias_step = {1.0, 2.0, 3.0};
    errors.bias_step_time = 0.0275;
    const auto measured = measure(errors, 1, 4, Eigen::Vector3d::Zero());
    EXPECT_EQ(measured[1].norm(), 0.0);
    EXPECT_LT((measured[2] - 0.0025 * errors.bias_step).norm(), 1e-16);
    EXPECT_LT((measured[3] - kPeriod * errors.bias_step).norm(), 1e-17);
}

TEST(InertialSensor, ABiasStepOfLimitedDurationEnds) {
    InertialSensor::Errors errors;
    errors.bias_step = {1.0, 2.0, 3.0};
    errors.bias_step_time = 0.0175;
    errors.bias_step_duration = 0.02;
    const auto measured = measure(errors, 1, 6, Eigen::Vector3d::Zero());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& increment : measured) {
        sum += increment;
    }
    EXPECT_LT((sum - 0.02 * errors.bias_step).norm(), 1e-15);
    EXPECT_LT((measured[2] - kPeriod * errors.bias_step).norm(), 1e-16);
    EXPECT_LT((measured[3] - 0.0075 * errors.bias_step).norm(), 1e-16);
    EXPECT_LT(measured[4].norm(), 1e-16);
}

TEST(InertialSensor, SlowErrorIsWhatTheIncrementsShow) {
    InertialSensor::Errors errors;
    errors.bias = {0.1, 0.2, -0.3};
    errors.bias_sigma = 0.1;
    errors.bias_random_walk = 0.2;
    errors.markov_sigma = 0.05;
    errors.bias_step = {1.0, 2.0, 3.0};
    errors.bias_step_time = 0.5;
    errors.bias_step_duration = 0.25;
    const InertialSensor sensor(errors, kPeriod, streams(3));
    InertialSensor::State state = sensor.begin();
    for (int k = 1; k <= 100; ++k) {
        const Eigen::Vector3d measured =
            sensor.measure(state, static_cast<std::uint64_t>(k), k * kPeriod, Eigen::Vector3d::Zero());
        EXPECT_LT((measured - kPeriod * sensor.slow_error(state, k * kPeriod)).norm(), 1e-16);
    }
}

TEST(InertialSensor, TheQuantiserCarriesItsRemainder) {
    InertialSensor::Errors errors;
    errors.quantisation = 0.7e-3;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Vector3d truth = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& increment : measure(errors, 1, 1000)) {
        const Eigen::Vector3d counts = increment / errors.quantisation;
        EXPECT_LT((counts.array() - counts.array().round()).abs().maxCoeff(), 1e-12);
        sum += increment;
        truth += some_increment();
        EXPECT_LE((sum - truth).cwiseAbs().maxCoeff(), 0.5 * errors.quantisation + 1e-12);
    }
}

// ---------------------------------------------------------------- independence of the sources

// Switching one source off takes away that source's part alone, sample for sample.
TEST(InertialSensor, SourcesDoNotDisturbEachOther) {
    const InertialSensor::Errors all{
        .bias_sigma = 0.1,
        .bias_limit = 0.1,
        .bias_random_walk = 0.5,
        .white_noise = 0.2,
        .markov_sigma = 0.3,
        .markov_time = 5.0,
        .wave_sigma = 0.4,
        .wave_period = 2.0,
    };
    const std::vector<double InertialSensor::Errors::*> sources{
        &InertialSensor::Errors::bias_sigma,       &InertialSensor::Errors::bias_limit,
        &InertialSensor::Errors::bias_random_walk, &InertialSensor::Errors::white_noise,
        &InertialSensor::Errors::markov_sigma,     &InertialSensor::Errors::wave_sigma,
    };
    const auto with_all = measure(all, 7, 500, Eigen::Vector3d::Zero());
    for (const auto source : sources) {
        InertialSensor::Errors without = all;
        without.*source = 0.0;
        InertialSensor::Errors alone;
        alone.markov_time = all.markov_time;
        alone.wave_period = all.wave_period;
        alone.*source = all.*source;
        const auto rest = measure(without, 7, 500, Eigen::Vector3d::Zero());
        const auto part = measure(alone, 7, 500, Eigen::Vector3d::Zero());
        for (std::size_t k = 0; k < rest.size(); ++k) {
            ASSERT_LT((with_all[k] - rest[k] - part[k]).norm(), 1e-16) << "sample " << k;
            ASSERT_GT(part[k].norm(), 0.0);
        }
    }
}

// ---------------------------------------------------------------- statistics

TEST(InertialSensor, DrawnBiasesAreNormal) {
    InertialSensor::Errors errors;
    errors.bias_sigma = 2.0;
    constexpr int count = 3 * 4000;
    double sum = 0.0;
    double squares = 0.0;
    double neighbours = 0.0;
    int within_sigma = 0;
    Eigen::Vector3d previous = Eigen::Vector3d::Zero();
    for (std::uint32_t seed = 1; seed <= count / 3; ++seed) {
        const InertialSensor sensor(errors, kPeriod, streams(seed));
        const Eigen::Vector3d bias = sensor.slow_error(sensor.begin(), 0.0) / errors.bias_sigma;
        sum += bias.sum();
        squares += bias.squaredNorm();
        neighbours += bias.dot(previous);
        within_sigma += static_cast<int>((bias.array().abs() < 1.0).count());
        previous = bias;
    }
    EXPECT_NEAR(sum / count, 0.0, kSigmas / std::sqrt(count));
    EXPECT_NEAR(squares / count, 1.0, kSigmas * std::sqrt(2.0 / count));
    EXPECT_NEAR(neighbours / count, 0.0, kSigmas / std::sqrt(count));  // of neighbouring seeds
    EXPECT_NEAR(static_cast<double>(within_sigma) / count, 0.6827,
                kSigmas * std::sqrt(0.6827 * 0.3173 / count));
}

TEST(InertialSensor, BiasesDrawnWithinALimitAreUniform) {
    InertialSensor::Errors errors;
    errors.bias_limit = 2.0;
    constexpr int count = 3 * 4000;
    double sum = 0.0;
    double squares = 0.0;
    int within_half = 0;
    for (std::uint32_t seed = 1; seed <= count / 3; ++seed) {
        const InertialSensor sensor(errors, kPeriod, streams(seed));
        const Eigen::Vector3d bias = sensor.slow_error(sensor.begin(), 0.0) / errors.bias_limit;
        ASSERT_LT(bias.cwiseAbs().maxCoeff(), 1.0);
        sum += bias.sum();
        squares += bias.squaredNorm();
        within_half += static_cast<int>((bias.array().abs() < 0.5).count());
    }
    EXPECT_NEAR(sum / count, 0.0, kSigmas / std::sqrt(3.0 * count));
    EXPECT_NEAR(squares / count, 1.0 / 3.0, kSigmas * std::sqrt(4.0 / 45.0 / count));
    EXPECT_NEAR(static_cast<double>(within_half) / count, 0.5, kSigmas * std::sqrt(0.25 / count));
}

class SensorOfSeed : public testing::TestWithParam<std::uint32_t> {};

TEST_P(SensorOfSeed, WhiteNoiseHasItsDensity) {
    InertialSensor::Errors errors;
    errors.white_noise = 3.0;
    constexpr int count = 50000;
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    Eigen::Vector3d tens = Eigen::Vector3d::Zero();  // a random walk grows with the square root of time
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int k = 0;
    for (const Eigen::Vector3d& increment : measure(errors, GetParam(), count, Eigen::Vector3d::Zero())) {
        squares += increment.cwiseAbs2();
        sum += increment;
        if (++k % 10 == 0) {
            tens += sum.cwiseAbs2();
            sum.setZero();
        }
    }
    const double variance = errors.white_noise * errors.white_noise * kPeriod;
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(squares[i] / count / variance, 1.0, kSigmas * std::sqrt(2.0 / count));
        EXPECT_NEAR(tens[i] / count / variance, 1.0, kSigmas * std::sqrt(20.0 / count));
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SensorOfSeed, testing::Values(1U, 2U, 3U));

constexpr int kRuns = 4000;

// Autocovariance between sample 1 and sample 1 + lag, over an ensemble of kRuns runs (three axes each).
double autocovariance(const InertialSensor::Errors& errors, int lag) {
    double sum = 0.0;
    for (std::uint32_t run = 1; run <= kRuns; ++run) {
        const auto x = measure(errors, run, lag + 1, Eigen::Vector3d::Zero());
        sum += x.front().dot(x.back()) / (kPeriod * kPeriod);
    }
    return sum / (3.0 * kRuns);
}

// Sigma of an estimated autocovariance of unit-variance normal numbers: sqrt((1 + rho^2) / n).
double bound(double rho) { return kSigmas * std::sqrt((1.0 + rho * rho) / (3.0 * kRuns)); }

// The variance of noise of sigma 1 is 1 at sample number `sample` too.
void expect_stationary(const InertialSensor::Errors& errors, int sample) {
    double sum = 0.0;
    for (std::uint32_t run = 1; run <= kRuns; ++run) {
        sum += measure(errors, run, sample, Eigen::Vector3d::Zero()).back().squaredNorm();
    }
    EXPECT_NEAR(sum / (3.0 * kRuns * kPeriod * kPeriod), 1.0, bound(1.0)) << "sample " << sample;
}

TEST(InertialSensor, TheBiasWalksWithTheSquareRootOfTime) {
    // Covariance q min(t, t') of the biases at samples 10 and 40; it sets out from the drawn bias.
    InertialSensor::Errors errors;
    errors.bias_random_walk = 3.0;
    const double q = 9.0;
    double early = 0.0;
    double late = 0.0;
    double both = 0.0;
    for (std::uint32_t run = 1; run <= kRuns; ++run) {
        const auto x = measure(errors, run, 40, Eigen::Vector3d::Zero());
        early += x[9].squaredNorm() / (kPeriod * kPeriod);
        late += x[39].squaredNorm() / (kPeriod * kPeriod);
        both += x[9].dot(x[39]) / (kPeriod * kPeriod);
    }
    const double count = 3.0 * kRuns;
    EXPECT_NEAR(early / count / (q * 0.1), 1.0, bound(1.0));
    EXPECT_NEAR(late / count / (q * 0.4), 1.0, bound(1.0));
    EXPECT_NEAR(both / count / (q * 0.2), 0.5, bound(0.5));  // correlation sqrt(10 / 40)
}

TEST(InertialSensor, GaussMarkovNoiseHasItsSigmaAndCorrelationTime) {
    InertialSensor::Errors errors;
    errors.markov_sigma = 1.0;
    errors.markov_time = 0.5;
    for (const int lag : {0, 10, 50, 150}) {
        const double rho = std::exp(-lag * kPeriod / errors.markov_time);
        EXPECT_NEAR(autocovariance(errors, lag), rho, bound(rho)) << "lag " << lag;
    }
}

TEST(InertialSensor, GaussMarkovNoiseIsStationary) {
    InertialSensor::Errors errors;
    errors.markov_sigma = 1.0;
    errors.markov_time = 0.5;
    expect_stationary(errors, 200);
}

// Autocorrelation of the band-pass filter's output.
double wave_autocorrelation(double damping, double angle) {
    const double root = std::sqrt(1.0 - damping * damping);
    return std::exp(-damping * angle) * (std::cos(root * angle) - damping / root * std::sin(root * angle));
}

void expect_wave_autocorrelation(double period, double damping, std::initializer_list<int> lags) {
    InertialSensor::Errors errors;
    errors.wave_sigma = 1.0;
    errors.wave_period = period;
    errors.wave_damping = damping;
    for (const int lag : lags) {
        const double rho = wave_autocorrelation(damping, 2.0 * std::numbers::pi * lag * kPeriod / period);
        EXPECT_NEAR(autocovariance(errors, lag), rho, bound(rho)) << "lag " << lag;
    }
}

TEST(InertialSensor, WaveNoiseHasItsSigmaAndAutocorrelation) {
    expect_wave_autocorrelation(0.8, 0.1, {0, 20, 40, 80, 160});
}

// Eight samples a period: the discretisation is exact, not a matter of short samples.
TEST(InertialSensor, WaveNoiseIsRightForLongSamplesToo) {
    expect_wave_autocorrelation(0.08, 0.7, {0, 1, 2, 3, 4});
}

TEST(InertialSensor, WaveNoiseIsStationary) {
    InertialSensor::Errors errors;
    errors.wave_sigma = 1.0;
    errors.wave_period = 0.8;
    expect_stationary(errors, 300);
}

// Mean periodogram at `frequency` [Hz], Hann window, over an ensemble of runs (three axes each).
double power(const std::vector<std::vector<Eigen::Vector3d>>& runs, double frequency) {
    double sum = 0.0;
    for (const auto& run : runs) {
        Eigen::Vector3d cosine = Eigen::Vector3d::Zero();
        Eigen::Vector3d sine = Eigen::Vector3d::Zero();
        const double turn = 2.0 * std::numbers::pi / static_cast<double>(run.size());
        for (std::size_t k = 0; k < run.size(); ++k) {
            const auto index = static_cast<double>(k);
            const double window = 1.0 - std::cos(turn * index);
            const double angle = 2.0 * std::numbers::pi * frequency * kPeriod * index;
            cosine += window * std::cos(angle) * run[k];
            sine += window * std::sin(angle) * run[k];
        }
        sum += cosine.squaredNorm() + sine.squaredNorm();
    }
    return sum;
}

TEST(InertialSensor, TheSpectrumOfWaveNoisePeaksAtItsPeriod) {
    InertialSensor::Errors errors;
    errors.wave_sigma = 1.0;
    errors.wave_period = 0.5;
    errors.wave_damping = 0.1;
    std::vector<std::vector<Eigen::Vector3d>> runs;
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        runs.push_back(measure(errors, seed, 2000, Eigen::Vector3d::Zero()));
    }
    // |H|^2 ~ f^2 / ((f0^2 - f^2)^2 + (2 zeta f0 f)^2). 600 periodograms: sigma of their mean 4 %.
    const auto shape = [&](double f) {
        const double f0 = 1.0 / errors.wave_period;
        return f * f / (std::pow(f0 * f0 - f * f, 2) + std::pow(2.0 * errors.wave_damping * f0 * f, 2));
    };
    const double peak = power(runs, 2.0);
    for (const double f : {0.5, 1.0, 1.8, 2.2, 4.0}) {
        EXPECT_NEAR(power(runs, f) / peak / (shape(f) / shape(2.0)), 1.0, kSigmas * std::sqrt(2.0 / 600.0))
            << f << " Hz";
    }
}

}  // namespace
}  // namespace truenorth::plant
