// An error model at work: what the kinds of it share. NavigationEngine estimates the errors of a
// mechanisation that runs beside it, StateEngine the navigation state itself, InvariantEngine that on its
// group.
//
// What takes work stands behind the classes, not in them, so that it is compiled once, in the source file of
// each adapter.
#pragma once

#include <algorithm>

#include "aiding/observation.hpp"
#include "estimation/corrector.hpp"
#include "estimation/estimator.hpp"
#include "filter/aid_update.hpp"
#include "filter/change.hpp"
#include "filter/hand_over.hpp"

namespace truenorth {

// From where a filter sets out.
struct Start {
    NavigationState state;
    Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           // [rad/s]
    Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  // [m/s2]
    HandedCovariance covariance = HandedCovariance::Zero();        // zero: the prior
};

template <ErrorModel M>
class Engine {
  public:
    using Where = Adapter<M>;
    using Correction = truenorth::Correction<M::kStates, M::kMeasurements>;
    static constexpr int kStates = M::kStates;
    static constexpr int kMeasurements = M::kMeasurements;
    static constexpr bool kFindsPosition = Where::position.count > 0;
    static constexpr bool kStartsWhereItIs = false;  // at a new start its tilts and its place stay,
    static constexpr bool kKeepsHeading = false;     // and so does its heading

    // Settings; they follow from the parameters and are not part of a saved state, unlike what they learn.
    Estimator<M> estimator;
    Corrector<kStates, kMeasurements> corrector;
    Adapter<M> adapter;
    Vector<kStates> prior_sigma = Vector<kStates>::Ones();

    // Back to the prior covariance: the estimate stays, but nothing is known of its error.
    void forget(bool has_fixes = true);

    // Likewise, with an attitude of these sigmas, east, north, up [rad].
    void forget(const Eigen::Vector3d& attitude_sigma);

    // What the corrector makes of an innovation.
    [[nodiscard]] Correction corrected(const Innovation<kStates, kMeasurements>& innovation) {
        return corrector.correct(estimator.covariance, innovation);
    }

    // A mechanised state with what the estimate says of its errors taken out.
    [[nodiscard]] static NavigationState estimated(const NavigationState& mechanised) { return mechanised; }

    // What is known of the navigation state and the sensors becomes less certain.
    void add_uncertainty(const Uncertainty& more);

    // A model that has a coarse stage says when it is in it.
    [[nodiscard]] static constexpr bool is_coarse() { return false; }

    [[nodiscard]] const Mechanisation& mechanisation() const { return mechanisation_; }

    // Of the misalignment that is estimated [rad].
    [[nodiscard]] Eigen::Vector3d misalignment_sigma() const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(estimator, corrector, adapter, mechanisation_, gyro_bias_, accelerometer_bias_,
                first_gyro_bias_, first_accelerometer_bias_, handed_sigma_, found_);
    }

  protected:
    // Of the errors of the navigation state (aiding/observation.hpp) with respect to those of the states, for
    // such a model.
    [[nodiscard]] static Matrix<aiding::kErrors, kStates> errors_of_states();

    // As a covariance of the states, for a model whose errors are those of the navigation state, ENU.
    [[nodiscard]] Matrix<kStates> states_of(const Uncertainty& more) const;

    void set_out(const Start& start);

    // Of the errors at the start: the prior, or a covariance that was handed over and is wider.
    [[nodiscard]] Vector<kStates> sigma_at_start() const { return prior_sigma.cwiseMax(handed_sigma_); }

    // Back to what was known of the sensors at the start.
    void forget_sensors() {
        gyro_bias_ = first_gyro_bias_;
        accelerometer_bias_ = first_accelerometer_bias_;
    }

    // Freed of the biases that are known.
    [[nodiscard]] ImuIncrement compensated(ImuIncrement increment) const {
        increment.delta_angle -= gyro_bias_ * increment.dt;
        increment.delta_velocity -= accelerometer_bias_ * increment.dt;
        return increment;
    }

    Mechanisation mechanisation_;
    Eigen::Vector3d gyro_bias_ = Eigen::Vector3d::Zero();                 // known [rad/s]
    Eigen::Vector3d accelerometer_bias_ = Eigen::Vector3d::Zero();        // known [m/s2]
    Eigen::Vector3d first_gyro_bias_ = Eigen::Vector3d::Zero();           // at the start
    Eigen::Vector3d first_accelerometer_bias_ = Eigen::Vector3d::Zero();  // likewise
    Vector<kStates> handed_sigma_ = Vector<kStates>::Zero();              // of the errors at the start
    Eigen::Vector3d found_ = Eigen::Vector3d::Zero();  // misalignment, by the last fix [rad]
};

template <ErrorModel M>
void Engine<M>::forget(bool /*has_fixes*/) {
    estimator.appended.part();
    estimator.covariance = sigma_at_start().cwiseAbs2().asDiagonal();
}

template <ErrorModel M>
void Engine<M>::forget(const Eigen::Vector3d& attitude_sigma) {
    Vector<kStates> sigma = sigma_at_start();
    sigma.template segment<3>(Where::attitude.first) = attitude_sigma;
    estimator.appended.part();
    estimator.covariance = sigma.cwiseAbs2().asDiagonal();
}

template <ErrorModel M>
void Engine<M>::add_uncertainty(const Uncertainty& more) {
    estimator.covariance += states_of(more);
}

template <ErrorModel M>
Eigen::Vector3d Engine<M>::misalignment_sigma() const {
    const Vector<kStates> sigma = estimator.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    return components(sigma, Where::attitude);
}

template <ErrorModel M>
auto Engine<M>::errors_of_states() -> Matrix<aiding::kErrors, kStates> {
    Matrix<aiding::kErrors, kStates> J = Matrix<aiding::kErrors, kStates>::Zero();
    const auto put = [&J](int error, Block block) {
        for (int i = 0; i < block.count; ++i) {
            J(error + i, block.first + i) = 1.0;
        }
    };
    put(aiding::kMisalignment, Where::attitude);
    put(aiding::kVelocity, Where::velocity);
    put(aiding::kPosition, Where::position);
    put(aiding::kGyro, Where::gyro);
    put(aiding::kAccelerometer, Where::accelerometer);
    if constexpr (requires { Where::markov; }) {
        put(aiding::kGyro, {.first = Where::markov.first, .count = std::min(Where::markov.count, 6)});
    }
    return J;
}

template <ErrorModel M>
auto Engine<M>::states_of(const Uncertainty& more) const -> Matrix<kStates> {
    Matrix<kStates> P = Matrix<kStates>::Zero();
    const auto put = [&P](Block block, const Eigen::Matrix3d& variance) {
        for (int i = 0; i < block.count; ++i) {
            for (int j = 0; j < block.count; ++j) {
                P(block.first + i, block.first + j) = variance(i, j);
            }
        }
    };
    put(Where::attitude, more.attitude);
    put(Where::velocity, more.velocity);
    put(Where::position, more.position);
    const Vector<kStates> sigma = sigma_at_start();
    const auto blame = [&](Block block) {
        for (int i = block.first; i < block.first + block.count; ++i) {
            P(i, i) = more.sensors * sigma(i) * sigma(i);
        }
    };
    blame(Where::gyro);
    blame(Where::accelerometer);
    P.diagonal().segment(Where::accelerometer.first, Where::accelerometer.count).array() +=
        more.accelerometer;
    if constexpr (requires { Where::markov; }) {
        blame(Where::markov);
    }
    if constexpr (requires { Where::blame(P, more); }) {
        Where::blame(P, more);
    }
    return P;
}

template <ErrorModel M>
void Engine<M>::set_out(const Start& start) {
    mechanisation_ = Mechanisation(start.state);
    gyro_bias_ = start.gyro_bias;
    accelerometer_bias_ = start.accelerometer_bias;
    first_gyro_bias_ = gyro_bias_;
    first_accelerometer_bias_ = accelerometer_bias_;
    found_.setZero();
    adapter = {};
    corrector.restart();
    estimator.appended.start();
    handed_sigma_.setZero();
    Engine::forget();
    if (!start.covariance.isZero(0.0)) {
        take_covariance<Where>(estimator.covariance, start.covariance);
        handed_sigma_ = estimator.covariance.diagonal().cwiseSqrt();
    }
}

}  // namespace truenorth
