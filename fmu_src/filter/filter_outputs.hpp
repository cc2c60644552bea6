// From an engine to the outputs that the inertial filters share (modelDescription/shared).
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aiding/heading.hpp"
#include "estimation/innovation_gate.hpp"
#include "filter/aid_memory.hpp"
#include "filter/engine.hpp"

namespace truenorth {

// Of the azimuth of the body's forward axis. With that axis steep the tilts tell in it; straight up there is
// no heading. That of a uniform distribution on the circle at most.
inline double heading_sigma(const Eigen::Matrix3d& attitude_covariance, const Eigen::Quaterniond& q_bn) {
    constexpr double kAny = std::numbers::pi / std::numbers::sqrt3;
    const Eigen::RowVector3d gradient = aiding::heading_gradient(q_bn);
    if (gradient.z() == 0.0) {
        return kAny;
    }
    const double variance = gradient.dot(gradient * attitude_covariance);
    return std::min(std::sqrt(std::max(variance, 0.0)), kAny);
}

// Of the position with what is handed over (hand_over.hpp) and, behind that, with itself; zero with what the
// model lacks.
template <class Where, int N>
Eigen::Matrix<double, 3, kHandedStates + 3> position_covariance(const Matrix<N>& P) {
    constexpr auto states = handed_states<Where>();
    const auto rows = P.template middleRows<3>(Where::position.first);
    Eigen::Matrix<double, 3, kHandedStates + 3> covariance;
    for (int j = 0; j < kHandedStates; ++j) {
        if (states[j] < 0) {
            covariance.col(j).setZero();
        } else {
            covariance.col(j) = rows.col(states[j]);
        }
    }
    covariance.template rightCols<3>() = rows.template middleCols<3>(Where::position.first);
    return covariance;
}

// The navigation state, and how sure the heading is where the vehicle has turned to.
template <class Outputs>
void publish_state(Outputs& outputs, const NavigationState& best, double time) {
    const EulerAngles angles = euler_angles(best.q_bn.toRotationMatrix());
    auto& nav = outputs.nav;
    nav.time = time;
    nav.roll = angles.roll;
    nav.pitch = angles.pitch;
    nav.heading = angles.heading;
    nav.velocity = best.velocity;
    nav.latitude = best.position.latitude;
    nav.longitude = best.position.longitude;
    nav.height = best.position.height;
    outputs.heading_sigma = heading_sigma(outputs.covariance.template topLeftCorner<3, 3>(), best.q_bn);
}

// What is known of it besides, which time alone does not change.
template <class Outputs, class Engine, class Parameters>
void publish_knowledge(Outputs& outputs, const Engine& engine, const Parameters& p) {
    using Where = typename Engine::Where;
    const auto& covariance = engine.covariance();  // by value or by reference, as the engine has it
    const Vector<Engine::kStates> sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    outputs.misalignment = engine.misalignment();
    outputs.misalignment_sigma = engine.misalignment_sigma();
    outputs.velocity_sigma = components(sigma, Where::velocity);
    outputs.gyro_bias = engine.gyro_bias();
    outputs.gyro_bias_sigma = components(sigma, Where::gyro, p.prior.gyro_bias_sigma);
    outputs.accelerometer_bias = engine.accelerometer_bias();
    outputs.accelerometer_bias_sigma =
        components(sigma, Where::accelerometer, p.prior.accelerometer_bias_sigma);
    if constexpr (requires { outputs.position_sigma; }) {
        outputs.position_sigma = components(sigma, Where::position);
    }
    outputs.covariance = handed_covariance<Where>(covariance, p);
    if constexpr (requires { outputs.position_covariance; }) {
        outputs.position_covariance = position_covariance<Where>(covariance);
    }
    if constexpr (requires { engine.adapter.publish(outputs, engine.estimator.state, sigma); }) {
        engine.adapter.publish(outputs, engine.estimator.state, sigma);
    }
}

// What is known of the constant errors of the aids' sensors.
template <class Aids>
void publish_errors_of_sensors(Aids& aids, const Appended& sensors) {
    const auto& errors = sensors.mean();
    const Appended::Constants sigma = sensors.covariance().diagonal().cwiseMax(0.0).cwiseSqrt();
    aids.body_velocity.scale = errors(aiding::kScale);
    aids.body_velocity.scale_sigma = sigma(aiding::kScale);
    aids.body_velocity.boresight = errors.segment<3>(aiding::kBoresight);
    aids.body_velocity.boresight_sigma = sigma.segment<3>(aiding::kBoresight);
    aids.heading_aid.bias = errors(aiding::kHeadingBias);
    aids.heading_aid.bias_sigma = sigma(aiding::kHeadingBias);
    aids.height_aid.bias = errors(aiding::kHeightBias);
    aids.height_aid.bias_sigma = sigma(aiding::kHeightBias);
}

// How an aid is.
template <class Health>
void publish_health_of(Health& health, const AidMemory& memory, double now, double clock) {
    health.nis_mean = memory.window.mean(now);
    health.used = memory.used;
    health.rejected = memory.rejected;
    health.silent_for = clock - memory.last;
}

// The elements of `output` that belong to the measurements; the others are zero.
template <class Where, int M, class Output>
void spread_out(Output& output, const Vector<M>& measurements) {
    output.setZero();
    for (int i = 0; i < M; ++i) {
        if constexpr (requires { Where::slot(i, output); }) {
            output(Where::slot(i, output)) = measurements(i);
        } else {
            output(i) = measurements(i);
        }
    }
}

// What a fix brought.
template <class Where, class Outputs, int N, int M>
void publish_innovation(Outputs& outputs, const Innovation<N, M>& innovation, double nis) {
    const Vector<M> present = innovation.present.template cast<double>().matrix();
    const Vector<M> sigma = (innovation.spread + innovation.noise).diagonal().cwiseSqrt();
    spread_out<Where, M>(outputs.innovation, innovation.residual);
    spread_out<Where, M>(outputs.innovation_sigma, sigma.cwiseProduct(present));
    outputs.nis = nis;
    outputs.nis_channels = innovation.channels();
}

// Of a fix that a coarse stage took, which has none.
template <class Outputs>
void publish_no_innovation(Outputs& outputs) {
    outputs.innovation.setZero();
    outputs.innovation_sigma.setZero();
    outputs.measurement_weight.setZero();
    outputs.nis = 0.0;
    outputs.nis_channels = 0;
}

// What a corrector made of it.
template <class Where, class Outputs, int N, int M>
void publish_correction(Outputs& outputs, const Correction<N, M>& correction, bool h_infinity) {
    const Vector<M> sigma = correction.noise.diagonal().cwiseSqrt();
    const Vector<M> measured = (correction.weight.array() > 0.0).template cast<double>().matrix();
    ++outputs.used_fixes;
    spread_out<Where, M>(outputs.measurement_weight, correction.weight);
    spread_out<Where, M>(outputs.measurement_sigma_estimate, sigma.cwiseProduct(measured));
    outputs.adaptive.alpha = correction.alpha;
    outputs.robust.feasible = correction.feasible;
    const bool robust = h_infinity && correction.feasible && std::isfinite(correction.gamma_effective);
    outputs.robust.gamma_effective = robust ? correction.gamma_effective : 0.0;
}

}  // namespace truenorth
