// The invariant model at work, and the coarse stage before it.
//
// The state stands where it was predicted last; increments since then are preintegrated, and a mechanisation
// fills the time between for the outputs. In the coarse stage every fix sets the state anew, to the attitude
// that the vectors tell; at its end the filter takes all fixes of the stage again, linearised at what was
// found, with an attitude of which nothing is known as prior. The vectors know no biases and are tilted by
// them: the filter does so until the attitude and the biases that it finds are those at which it linearised.
#pragma once

#include <algorithm>
#include <cmath>

#include "filter/coarse_stage.hpp"
#include "filter/engine.hpp"
#include "filter/invariant_adapter.hpp"
#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

template <bool coloured>
class InvariantEngine : public Engine<Invariant<coloured>> {
  public:
    using M = Invariant<coloured>;
    using Base = Engine<M>;
    using Base::estimator;
    using typename Base::Where;
    using Covariance = Matrix<Base::kStates>;

    // Settings of the coarse stage: the heading sigma that ends it [rad], whether the filter begins with it,
    // and whether it goes through it when it starts again.
    double coarse_heading_sigma = 0.0524;
    bool begins_coarsely = false;
    bool resumes_coarsely = false;

    void start(const Start& start);

    // Likewise, through its coarse stage if it has one and there are fixes.
    void forget(bool has_fixes = true);

    // Starts again with the prior, an attitude of these sigmas [rad], and as proposed; with its coarse stage,
    // if it has one and there are fixes. Returns what changed.
    Change start_again(const Change& proposal, const Eigen::Vector3d& attitude_sigma, const Discrepancy& off,
                       bool has_fixes = true);

    // Its errors are in body axes. A coarse stage keeps the doubt for the filter that follows.
    void add_uncertainty(const Uncertainty& more);

    Prediction mechanise(const ImuIncrement& increment);

    // Time since the state was last carried forward [s].
    [[nodiscard]] double pending() const { return ahead_.duration; }

    Prediction predict();

    [[nodiscard]] Innovation<Base::kStates, Base::kMeasurements> innovate(const Sighting& /*seen*/,
                                                                          const typename M::Fix& fix) const {
        return estimator.innovate(fix);
    }

    // What the corrector makes of an innovation. Its settings are sigmas east, north and up, as the prior is.
    [[nodiscard]] Correction<Base::kStates, Base::kMeasurements> corrected(
        const Innovation<Base::kStates, Base::kMeasurements>& innovation) {
        return corrected(estimator.covariance, innovation);
    }

    // Corrects the state. The correction must have been used. `constants`: of the sensors, after it, if it
    // measured them.
    Change apply(const Correction<Base::kStates, Base::kMeasurements>& correction,
                 const Appended* constants = nullptr);

    [[nodiscard]] bool is_coarse() const { return coarse_.active(); }

    // In the coarse stage: whether the next fix is wanted, and such a fix, which may end the stage.
    [[nodiscard]] bool awaits_fix() const { return coarse_.awaits_fix(); }
    Change apply_coarsely(const typename M::Fix& fix);

    [[nodiscard]] const NavigationState& best() const { return mechanisation_.state; }

    // Of its errors with respect to those of the states.
    [[nodiscard]] Matrix<aiding::kErrors, Base::kStates> navigation_errors() const;

    // Of the errors of the navigation state, east, north, up, and of what the sensors are off by.
    [[nodiscard]] const Covariance& covariance() const { return covariance_; }

    // Constant biases and Gauss-Markov processes together: what the sensors are off by.
    [[nodiscard]] Eigen::Vector3d gyro_bias() const;
    [[nodiscard]] Eigen::Vector3d accelerometer_bias() const;

    // What the last fix found, and how sure that is [rad].
    [[nodiscard]] const Eigen::Vector3d& misalignment() const { return this->found_; }
    [[nodiscard]] Eigen::Vector3d misalignment_sigma() const;

    template <class Archive>
    void serialize(Archive& archive) {
        Base::serialize(archive);
        archive(ahead_, previous_, to_navigation_, covariance_, coarse_);
    }

  private:
    using Base::mechanisation_;

    // Covariance of the errors of the navigation state.
    void know(const Covariance& covariance);

    [[nodiscard]] Correction<Base::kStates, Base::kMeasurements> corrected(
        const Covariance& prior, const Innovation<Base::kStates, Base::kMeasurements>& innovation);

    // A covariance of the errors of the navigation state, as one of the model's states.
    [[nodiscard]] Covariance in_states(const Covariance& covariance) const;

    // Position and velocity of a fix, with an attitude of which nothing is known.
    void place(const Eigen::Quaterniond& attitude, const typename M::Fix& fix);

    // Covariance of the attitude that the vectors tell: what the fixes scatter, and what biases do that no
    // scatter shows. An accelerometer bias passes for a tilt, an east gyro bias for a heading, and the errors
    // go with these. Gauss-Markov processes count as biases, although scatter shows a part of them.
    void misalign(const Eigen::Matrix3d& C_bn, const Eigen::Matrix3d& scatter);

    // Filters the coarse stage, from the first fix to the last: linearised at an attitude at the first fix,
    // then at the attitude and the biases that came of it, until these stand.
    void take_again(const Eigen::Quaterniond& at_first_fix);

    // What follows from the covariance.
    void refresh();

    // What follows from state and covariance when both are of now; returns what changed.
    Change follow();

    Preintegration ahead_;                                         // since the state was carried forward
    ImuIncrement previous_;                                        // the one before the next
    Eigen::Matrix3d to_navigation_ = Eigen::Matrix3d::Identity();  // body to local level, of the state
    Covariance covariance_ = Covariance::Zero();                   // of the errors of the navigation state
    CoarseStage<M> coarse_;
};

template <bool coloured>
void InvariantEngine<coloured>::start(const Start& start) {
    this->set_out(start);
    estimator.state = M::State::of(start.state);
    estimator.state.sensors.template head<6>() << start.gyro_bias, start.accelerometer_bias;
    ahead_ = {};
    previous_ = {};
    know(estimator.covariance);
    coarse_.reserve();
    if (begins_coarsely) {
        coarse_.begin();
    } else {
        coarse_.end();
    }
}

template <bool coloured>
void InvariantEngine<coloured>::forget(bool has_fixes) {
    know(this->sigma_at_start().cwiseAbs2().asDiagonal());
    if (resumes_coarsely && has_fixes) {
        coarse_.begin();
    }
}

template <bool coloured>
Change InvariantEngine<coloured>::start_again(const Change& proposal, const Eigen::Vector3d& attitude_sigma,
                                              const Discrepancy& /*off*/, bool has_fixes) {
    mechanisation_.state = proposal.of(mechanisation_.state);
    this->forget_sensors();
    estimator.state = M::State::of(mechanisation_.state);
    estimator.state.sensors.template head<6>() << this->gyro_bias_, this->accelerometer_bias_;
    Base::forget(attitude_sigma);
    know(Covariance(estimator.covariance));
    if (resumes_coarsely && has_fixes) {
        coarse_.begin();
    }
    return proposal;
}

template <bool coloured>
void InvariantEngine<coloured>::add_uncertainty(const Uncertainty& more) {
    estimator.covariance += in_states(this->states_of(more));
    if (is_coarse()) {
        coarse_.doubt(more);
    }
    refresh();
}

template <bool coloured>
Prediction InvariantEngine<coloured>::mechanise(const ImuIncrement& increment) {
    ahead_ = ahead_ * Preintegration::of(previous_, increment);
    previous_ = increment;
    const Vector<6> error = M::sensor_error(estimator.state);
    mechanisation_.advance({.dt = increment.dt,
                            .delta_angle = increment.delta_angle - error.head<3>() * increment.dt,
                            .delta_velocity = increment.delta_velocity - error.tail<3>() * increment.dt});
    return Prediction::sound;
}

template <bool coloured>
Prediction InvariantEngine<coloured>::predict() {
    const Prediction prediction = estimator.predict(ahead_);
    if (is_coarse()) {
        coarse_.extend(ahead_);
    }
    ahead_ = {};
    follow();
    return prediction;
}

template <bool coloured>
Change InvariantEngine<coloured>::apply(const Correction<Base::kStates, Base::kMeasurements>& correction,
                                        const Appended* constants) {
    estimator.apply(correction, constants);
    const Change change = follow();
    this->found_ = to_navigation_ * correction.deviation.template segment<3>(M::kRotation);
    return change;
}

template <bool coloured>
Change InvariantEngine<coloured>::apply_coarsely(const typename M::Fix& fix) {
    coarse_.add(fix);
    const auto solution = coarse_.solve();
    if (!solution) {
        place(estimator.state.pose.attitude, fix);
        return follow();
    }
    place(solution->attitude, fix);
    const Eigen::Matrix3d C_bn = fix.C_en * solution->attitude.toRotationMatrix();
    const Eigen::Matrix3d scatter = fix.C_en * solution->covariance * fix.C_en.transpose();
    misalign(C_bn, C_bn.transpose() * scatter * C_bn);
    if (coarse_.done(std::sqrt(scatter(2, 2)), coarse_heading_sigma)) {
        take_again(solution->at_first_fix);
    }
    return follow();
}

template <bool coloured>
Eigen::Vector3d InvariantEngine<coloured>::gyro_bias() const {
    return M::sensor_error(estimator.state).template head<3>();
}

template <bool coloured>
Eigen::Vector3d InvariantEngine<coloured>::accelerometer_bias() const {
    return M::sensor_error(estimator.state).template tail<3>();
}

template <bool coloured>
Eigen::Vector3d InvariantEngine<coloured>::misalignment_sigma() const {
    return covariance_.diagonal().template head<3>().cwiseMax(0.0).cwiseSqrt();
}

template <bool coloured>
auto InvariantEngine<coloured>::navigation_errors() const -> Matrix<aiding::kErrors, Base::kStates> {
    Matrix<aiding::kErrors, Base::kStates> J =
        M::navigation_errors(estimator.state).template topRows<aiding::kErrors>();
    if constexpr (coloured) {
        J.template block<6, 6>(aiding::kGyro, M::kGyroMarkov).setIdentity();
    }
    return J;
}

template <bool coloured>
void InvariantEngine<coloured>::know(const Covariance& covariance) {
    estimator.covariance = in_states(covariance);
    estimator.appended.part();
    refresh();
}

template <bool coloured>
auto InvariantEngine<coloured>::in_states(const Covariance& covariance) const -> Covariance {
    return transformed<Base::kStates>(M::navigation_errors(estimator.state).transpose(), covariance);
}

template <bool coloured>
auto InvariantEngine<coloured>::corrected(const Covariance& prior,
                                          const Innovation<Base::kStates, Base::kMeasurements>& innovation)
    -> Correction<Base::kStates, Base::kMeasurements> {
    if (!this->corrector.knows_sigmas()) {
        return this->corrector.correct(prior, innovation);
    }
    const Covariance J = M::navigation_errors(estimator.state);  // orthogonal
    auto turned = innovation;
    turned.cross = J * innovation.cross;
    auto correction = this->corrector.correct(transformed<Base::kStates>(J, prior), turned);
    correction.deviation = (J.transpose() * correction.deviation).eval();
    correction.covariance = in_states(correction.covariance);
    return correction;
}

template <bool coloured>
void InvariantEngine<coloured>::place(const Eigen::Quaterniond& attitude, const typename M::Fix& fix) {
    estimator.state.pose = {.attitude = attitude,
                            .velocity = fix.velocity - attitude * fix.velocity_arm,
                            .position = fix.position - attitude * fix.position_arm};
    Vector<Base::kStates> sigma = this->sigma_at_start();
    sigma.template segment<3>(M::kRotation).setConstant(kUnknownAngle);
    sigma.template segment<3>(M::kVelocity) = estimator.model.velocity_sigma(fix);
    sigma.template segment<3>(M::kPosition) = estimator.model.position_sigma(fix);
    know(sigma.cwiseAbs2().asDiagonal());
}

template <bool coloured>
void InvariantEngine<coloured>::misalign(const Eigen::Matrix3d& C_bn, const Eigen::Matrix3d& scatter) {
    const Eigen::Vector3d east = C_bn.row(0);
    const Eigen::Vector3d up = C_bn.row(2);
    const double latitude = mechanisation_.state.position.latitude;
    const double gravity = earth::gravity(latitude, 0.0);
    // At the poles the heading is as uncertain as it can be.
    const double north_rate =
        std::max(earth::rate(latitude).y(), this->sigma_at_start()(M::kGyro) / kUnknownAngle);
    Matrix<3, 6> bias;
    bias << -up * east.transpose() / north_rate, skew(up) / gravity;

    auto& P = estimator.covariance;
    P.template block<3, 3>(M::kRotation, M::kRotation) = scatter;
    for (int sensor = M::kGyro; sensor < M::kStates; sensor += 6) {
        const Matrix<3, 6> cross = bias * P.template block<6, 6>(sensor, sensor);
        P.template block<3, 3>(M::kRotation, M::kRotation) += cross * bias.transpose();
        P.template block<3, 6>(M::kRotation, sensor) = cross;
        P.template block<6, 3>(sensor, M::kRotation) = cross.transpose();
    }
}

template <bool coloured>
void InvariantEngine<coloured>::take_again(const Eigen::Quaterniond& at_first_fix) {
    constexpr int kPasses = 5;
    constexpr double kStands = 0.01;  // [rad]
    const Vector<M::kSensors> known = estimator.state.sensors;
    Eigen::Quaterniond attitude = at_first_fix;
    Vector<6> biases = known.template head<6>();
    double moved = kUnknownAngle;
    for (int pass = 0; pass < kPasses && moved > kStands; ++pass) {
        estimator.state.sensors = known;
        estimator.state.sensors.template head<6>() = biases;
        place(attitude, coarse_.first_fix());
        // Wherever the trajectory has the biases, what is known of them beforehand stays what it was.
        Vector<Base::kStates> prior = Vector<Base::kStates>::Zero();
        prior.template tail<M::kSensors>() = known - estimator.state.sensors;
        this->corrector.restart();
        filter_along_trajectory(
            estimator.model, estimator.state, estimator.covariance, prior, coarse_.after_first_fix(),
            [this](const auto& P, const auto& innovation) { return this->corrected(P, innovation); });
        biases = estimator.state.sensors.template head<6>();
        const Eigen::Quaterniond found = coarse_.at_first_fix(estimator.state.pose.attitude, biases);
        moved = attitude.angularDistance(found);
        attitude = found;
    }
    const Uncertainty doubted = coarse_.doubted();
    coarse_.end();
    add_uncertainty(doubted);
}

template <bool coloured>
void InvariantEngine<coloured>::refresh() {
    const Covariance J = M::navigation_errors(estimator.state);
    to_navigation_ = J.template topLeftCorner<3, 3>();
    covariance_ = transformed<Base::kStates>(J, estimator.covariance);
    if constexpr (coloured) {
        covariance_.template middleRows<6>(M::kGyro) += covariance_.template middleRows<6>(M::kGyroMarkov);
        covariance_.template middleCols<6>(M::kGyro) += covariance_.template middleCols<6>(M::kGyroMarkov);
        symmetrise(covariance_);
    }
}

template <bool coloured>
Change InvariantEngine<coloured>::follow() {
    refresh();
    const NavigationState before = mechanisation_.state;
    mechanisation_.state = estimator.state.navigation();
    Change change = Change::between(before, mechanisation_.state);
    change.finite = change.rotation.allFinite() && change.velocity.allFinite() &&
                    change.displacement.allFinite() && covariance_.allFinite();
    return change;
}

extern template class Engine<Invariant<false>>;
extern template class Engine<Invariant<true>>;
extern template class InvariantEngine<false>;
extern template class InvariantEngine<true>;
extern template struct AidUpdate<InvariantEngine<false>>;
extern template struct AidUpdate<InvariantEngine<true>>;

}  // namespace truenorth
