#include "plant/inertial_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "inertial/attitude.hpp"

namespace truenorth::plant {

InertialSensor::InertialSensor(const Errors& errors, double period, const Streams& streams)
    : gain_((Eigen::Vector3d::Ones() + errors.scale_factor).asDiagonal() *
            quaternion(-errors.misalignment).toRotationMatrix()),
      bias_(errors.bias + errors.bias_sigma * streams.bias.normal(0) +
            errors.bias_limit * (2.0 * streams.bias.uniform(1).head<3>() - Eigen::Vector3d::Ones())),
      bias_step_(errors.bias_step),
      bias_step_time_(errors.bias_step_time),
      bias_step_duration_(errors.bias_step_duration),
      period_(period),
      walk_sigma_(errors.bias_random_walk * std::sqrt(period)),
      white_sigma_(errors.white_noise * std::sqrt(period)),
      quantisation_(errors.quantisation),
      walk_(streams.walk),
      white_(streams.white),
      markov_(errors.markov_sigma, errors.markov_time, period, streams.markov),
      wave_(errors.wave_sigma, errors.wave_period, errors.wave_damping, period, streams.wave) {}

Eigen::Vector3d InertialSensor::measure(State& state, std::uint64_t sample, double time,
                                        const Eigen::Vector3d& true_increment) const {
    if (walk_sigma_ > 0.0) {
        state.walk += walk_sigma_ * walk_.normal(sample);
    }
    markov_.advance(state.markov, sample);
    wave_.advance(state.wave, sample);
    Eigen::Vector3d increment =
        gain_ * true_increment + (slow_error(state, time) + WaveNoise::noise(state.wave)) * period_;
    if (white_sigma_ > 0.0) {
        increment += white_sigma_ * white_.normal(sample);
    }
    if (quantisation_ > 0.0) {
        const Eigen::Vector3d total = state.remainder + increment;
        increment = quantisation_ * (total / quantisation_).array().round();
        state.remainder = total - increment;
    }
    return increment;
}

Eigen::Vector3d InertialSensor::slow_error(const State& state, double time) const {
    return bias_ + stepped(time) * bias_step_ + state.markov + state.walk;
}

double InertialSensor::stepped(double time) const {
    const auto since = [&](double begin) { return std::clamp((time - begin) / period_, 0.0, 1.0); };
    const double begun = since(bias_step_time_);
    return bias_step_duration_ > 0.0 ? begun - since(bias_step_time_ + bias_step_duration_) : begun;
}

}  // namespace truenorth::plant
