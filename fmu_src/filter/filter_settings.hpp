// From the parameters of an inertial filter to the settings of an engine. The declarations that the filters
// share (modelDescription/shared) make these templates fit each of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "contract/parameter_rules.hpp"
#include "estimation/integration.hpp"
#include "filter/engine.hpp"

namespace truenorth {

// Rules between shared parameters. Throws InvalidParameter.
template <class Parameters>
void check_settings(const Parameters& p) {
    if (p.robust.heading_sigma > 0.0 && p.robust.heading_sigma < p.prior.heading_sigma) {
        rules::refuse("robust.heading_sigma", p.robust.heading_sigma,
                      text("0 or at least prior.heading_sigma = ", p.prior.heading_sigma));
    }
    if (p.igg.k1 <= p.igg.k0) {
        rules::refuse("igg.k1", p.igg.k1, text("greater than igg.k0 = ", p.igg.k0));
    }
}

// The navigation state that initial.* are.
template <class Initial>
NavigationState state_of(const Initial& initial) {
    return {.q_bn = Eigen::Quaterniond(
                dcm({.roll = initial.roll, .pitch = initial.pitch, .heading = initial.heading})),
            .velocity = initial.velocity,
            .position = {.latitude = initial.latitude,
                         .longitude = wrap_angle(initial.longitude),
                         .height = initial.height}};
}

template <class Parameters>
Predictor predictor_of(const Parameters& p) {
    switch (p.predictor) {
        case settings::Predictor::linearised:
            return Linearised();
        case settings::Predictor::unscented:
            break;
        case settings::Predictor::augmented:
            return Augmented(p.unscented);
    }
    return Unscented(p.unscented);
}

template <class Engine, class Parameters>
Vector<Engine::kStates> prior_sigma_of(const Parameters& p) {
    using Where = typename Engine::Where;
    Vector<Engine::kStates> sigma = Vector<Engine::kStates>::Zero();
    const auto set = [&](Block block, double value) {
        sigma.segment(block.first, block.count).setConstant(value);
    };
    set(Where::velocity, p.prior.velocity_sigma);
    set(Where::gyro, p.prior.gyro_bias_sigma);
    set(Where::accelerometer, p.prior.accelerometer_bias_sigma);
    set(Where::attitude, p.prior.tilt_sigma);
    sigma(Where::attitude.first + 2) = p.prior.heading_sigma;
    if constexpr (Where::position.count == 3) {
        set(Where::position, p.prior.position_sigma);
        sigma(Where::position.first + 2) = p.prior.height_sigma;
    }
    if constexpr (requires { Where::set_prior(sigma, p); }) {
        Where::set_prior(sigma, p);
    }
    return sigma;
}

// Sigmas beyond which the adaptive factor makes no state uncertain: an attitude not beyond what an error
// equation still describes (or some times its prior), a sensor not beyond some times its prior, anything else
// not beyond far more than was known of it at the start, or than a fix tells of it.
template <class Engine, class Parameters>
Vector<Engine::kStates> widest_of(const Engine& engine, const Parameters& p) {
    using Where = typename Engine::Where;
    constexpr double kTimes = 1e4;  // 1e8 of a variance: half of the digits of a double
    constexpr double kTimesOfAttitude = 3.0;
    constexpr double kTimesOfSensors = 10.0;
    constexpr double kTilt = 0.1;     // [rad]
    constexpr double kHeading = 0.3;  // [rad]
    Vector<Engine::kStates> widest = kTimes * engine.prior_sigma;
    const auto at_least = [&](Block block, double value) {
        auto part = widest.segment(block.first, block.count);
        part = part.cwiseMax(value).eval();
    };
    at_least(Where::velocity, kTimes * p.measurement.velocity_sigma);
    if constexpr (Where::position.count == 3) {
        at_least(Where::position,
                 kTimes * std::max(p.measurement.position_sigma, p.measurement.height_sigma));
    }
    for (const Block sensor : {Where::gyro, Where::accelerometer}) {
        widest.segment(sensor.first, sensor.count) *= kTimesOfSensors / kTimes;
    }
    auto attitude = widest.segment(Where::attitude.first, Where::attitude.count);
    attitude = (kTimesOfAttitude / kTimes * attitude).cwiseMin(std::numbers::pi).eval();
    const Eigen::Vector3d least(kTilt, kTilt, kHeading);
    attitude = attitude.cwiseMax(least).eval();
    return widest;
}

// Of the constant errors of the aids' sensors (aiding/observation.hpp).
template <class Parameters>
Appended::Constants sensor_sigma_of(const Parameters& p) {
    Appended::Constants sigma;
    sigma(aiding::kScale) = p.body_velocity.scale_sigma;
    sigma.segment<3>(aiding::kBoresight) = p.body_velocity.boresight_sigma;
    sigma(aiding::kHeadingBias) = p.prior.heading_aid_bias_sigma;
    sigma(aiding::kHeightBias) = p.prior.height_aid_bias_sigma;
    return sigma;
}

// The positions or pseudoranges of a fix come first, as many velocities or range rates after them, or there
// are velocities alone.
template <class Where, int M>
constexpr int positions_of() {
    return Where::position.count > 0 ? M / 2 : 0;
}

// With which variance variational Bayes starts a channel.
template <class Where, int M, class Parameters>
Vector<M> starting_variance_of(const Parameters& p) {
    constexpr int positions = positions_of<Where, M>();
    Vector<M> sigma = Vector<M>::Constant(p.variational_bayes.velocity_sigma);
    sigma.template head<positions>().setConstant(p.variational_bayes.position_sigma);
    return sigma.cwiseAbs2();
}

// L and the ceiling of the H-infinity update that gives up what is due for `elapsed` seconds: nothing, if
// these are not positive and no ceiling bounds it.
template <class Engine, class Parameters>
void scale_h_infinity(Engine& engine, const Parameters& p, double elapsed) {
    auto& h_infinity = engine.corrector.h_infinity;
    h_infinity.gamma = p.robust.gamma;
    constexpr int heading = Engine::Where::attitude.first + 2;
    Vector<Engine::kStates> sigma = engine.prior_sigma;
    if (p.robust.heading_sigma > 0.0) {
        sigma(heading) = p.robust.heading_sigma;
    }
    h_infinity.ceiling = std::nullopt;
    switch (p.robust.scaling) {
        case settings::RobustScaling::printed:
            h_infinity.scale.setConstant(elapsed > 0.0 ? 1.0 : 0.0);
            break;
        case settings::RobustScaling::rate_invariant:
            h_infinity.scale = std::sqrt(std::max(elapsed, 0.0) / p.robust.horizon) * sigma.cwiseInverse();
            break;
        case settings::RobustScaling::ceiling:
            h_infinity.scale = sigma.cwiseInverse();
            h_infinity.ceiling = {.sigma = sigma, .limit = p.robust.ceiling};
            break;
    }
    if (p.robust.states == settings::RobustStates::heading) {
        const double protected_scale = h_infinity.scale(heading);
        h_infinity.scale.setZero();
        h_infinity.scale(heading) = protected_scale;
    }
}

// Calls tell(name, value) for each noise that the error model does not have, of those that are 0 unless they
// are asked for.
template <class Model, class Process, class Tell>
void each_without_effect(const Process& process, const Tell& tell) {
    using Noise = decltype(Model::noise);
    if constexpr (
        requires { process.accelerometer_markov_sigma; } &&
        !requires(Noise noise) { noise.accelerometer.sigma; }) {
        tell("process.gyro_markov_sigma", process.gyro_markov_sigma);
        tell("process.accelerometer_markov_sigma", process.accelerometer_markov_sigma);
    }
    if constexpr (
        requires { process.gyro_bias_random_walk; } && !requires(Noise noise) { noise.gyro_random_walk; }) {
        tell("process.gyro_bias_random_walk", process.gyro_bias_random_walk);
        tell("process.accelerometer_bias_random_walk", process.accelerometer_bias_random_walk);
    }
}

template <class Engine, class Parameters>
void configure(Engine& engine, const Parameters& p) {
    auto& model = engine.estimator.model;
    engine.adapter.configure(model, p);
    if constexpr (requires { model.discretisation; }) {
        model.discretisation = p.discretisation;
    }
    if constexpr (requires { engine.feedback = p.feedback; }) {
        engine.feedback = p.feedback;
    }
    if constexpr (requires { engine.gyro_bias_sigma; }) {
        engine.gyro_bias_sigma = p.prior.gyro_bias_sigma;
        engine.accelerometer_bias_sigma = p.prior.accelerometer_bias_sigma;
    }
    if constexpr (requires { engine.coarse_heading_sigma = p.coarse.heading_sigma; }) {
        engine.coarse_heading_sigma = p.coarse.heading_sigma;
        engine.begins_coarsely = p.coarse.enabled;
        engine.resumes_coarsely = p.coarse.enabled;
    }
    engine.estimator.predictor = predictor_of(p);
    engine.estimator.appended.prior_sigma = sensor_sigma_of(p);
    engine.prior_sigma = prior_sigma_of<Engine>(p);
    auto& corrector = engine.corrector;
    corrector.configure(p);
    corrector.adaptive_factor.widest = widest_of(engine, p);
    corrector.igg.guard.widest = corrector.adaptive_factor.widest;
    corrector.variational_bayes.start_variance =
        starting_variance_of<typename Engine::Where, Engine::kMeasurements>(p);
    corrector.combined.positions = positions_of<typename Engine::Where, Engine::kMeasurements>();
}

}  // namespace truenorth
