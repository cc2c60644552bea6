// The invariant model at work, and the coarse stage before it.
//
// The state stands where it was predicted last; increments since then are preintegrated, and a mechanisation
// fills the time between for the outputs. In the coarse stage every fix sets the state anew, to the attitude
// that the vectors tell; at its end the filter takes all fixes of the stage again, linearised at what was
// found, with an attitude of which nothing is known as prior. The vectors know no biases and are tilted by
// them: the filter does so until the attitude and the biases that it finds are those at which it linearised.
//
// Where gyros are too coarse for the rate of the Earth, that leaves a heading too wide to linearise at (at
// rest it may stay so for ever). Then the stage goes on with a bank of filters, one for every few degrees of
// heading, until they agree.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "estimation/gaussian_sum.hpp"
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

    // What is known of the state stays as it is until it is predicted or corrected.
    [[nodiscard]] static constexpr bool waits() { return true; }

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

    [[nodiscard]] bool is_coarse() const { return coarse_.active() || bank_.active(); }

    // In the coarse stage: whether a bank of headings is weighed.
    [[nodiscard]] bool weighs_headings() const { return bank_.active(); }

    // Likewise: whether the next fix is wanted, and such a fix, which may end the stage.
    [[nodiscard]] bool awaits_fix() const { return bank_.active() || coarse_.awaits_fix(); }
    // None if the fix is gross.
    std::optional<Change> apply_coarsely(const typename M::Fix& fix);

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
        archive(ahead_, previous_, to_navigation_, covariance_, coarse_, bank_, known_, since_motion_,
                refused_);
    }

  private:
    using Base::mechanisation_;

    // Covariance of the errors of the navigation state.
    void know(const Covariance& covariance);

    [[nodiscard]] Correction<Base::kStates, Base::kMeasurements> corrected(
        const Covariance& prior, const Innovation<Base::kStates, Base::kMeasurements>& innovation);

    // A covariance of the errors of the navigation state, as one of the model's states.
    [[nodiscard]] static Covariance in_states(const typename M::State& state, const Covariance& covariance);
    [[nodiscard]] Covariance in_states(const Covariance& covariance) const {
        return in_states(estimator.state, covariance);
    }

    // The pose at a fix.
    [[nodiscard]] static ExtendedPose placed(const Eigen::Quaterniond& attitude, const typename M::Fix& fix) {
        return {.attitude = attitude,
                .velocity = fix.velocity - attitude * fix.velocity_arm,
                .position = fix.position - attitude * fix.position_arm};
    }

    // Position and velocity of a fix, with an attitude of which nothing is known but the heading, to a sigma
    // [rad].
    void place(const Eigen::Quaterniond& attitude, const typename M::Fix& fix,
               double heading_sigma = kUnknownAngle);

    // Covariance of the attitude that the vectors tell: what the fixes scatter, and what biases do that no
    // scatter shows. An accelerometer bias passes for a tilt, an east gyro bias for a heading, and the errors
    // go with these. Gauss-Markov processes count as biases, although scatter shows a part of them.
    void misalign(const Eigen::Matrix3d& C_bn, const Eigen::Matrix3d& scatter);

    using Sensors = Vector<M::kSensors>;

    // Where a filter that takes the coarse stage again is linearised: the attitude at the first fix, and the
    // biases.
    struct Linearisation {
        Eigen::Quaterniond attitude;
        Vector<6> biases;
    };

    // Ends the collecting of fixes.
    void conclude(const Eigen::Quaterniond& at_first_fix);

    // Filters the coarse stage, from the first fix to the last: linearised at an attitude at the first fix,
    // then at the attitude and the biases that came of it, until these stand. Returns where. `known` is what
    // is known of the sensors beforehand.
    Linearisation take_again(const Eigen::Quaterniond& at_first_fix, const Sensors& known);

    // Once, with a prior heading sigma [rad]: returns the logarithm of the likelihood of all fixes.
    double take_again(const Linearisation& at, const Sensors& known, double heading_sigma);

    // A filter for every heading, about the vertical at the first fix.
    void spread(const Linearisation& at, const Sensors& known);

    // A fix for the bank, which none of it may have foretold.
    std::optional<Change> weigh(const typename M::Fix& fix);

    // Of the sensors' errors, but for a constant.
    [[nodiscard]] double log_prior(const typename M::State& state, const Sensors& known) const;

    // The velocity changes over an interval by more than noise, tilt and biases make it seem to. A heading
    // shows in nothing else but the rate of the Earth, which stands in the priors of the sensors' errors.
    [[nodiscard]] bool moves(const typename M::State& x, const Preintegration& interval) const;

    // Likewise the antenna, against the IMU.
    [[nodiscard]] bool swings(const typename M::State& x, const typename M::Fix& fix) const;

    // Either, anywhere in the coarse stage.
    [[nodiscard]] bool moved(const Linearisation& at, const Sensors& known) const;

    // State and covariance are those of the bank.
    void take_moments();

    [[nodiscard]] double heading_sigma() const { return std::sqrt(covariance_(2, 2)); }

    // Beyond it a heading is too wide to linearise at [rad].
    static constexpr double kWide = 0.17;

    // A motion of so many sigmas is none of noise.
    static constexpr double kSigmas = 5.0;

    // So long after a motion fixes still tell of it [s].
    static constexpr double kSettled = 10.0;

    // What follows from the covariance, where the body stands so.
    void refresh(const Eigen::Matrix3d& C_bn);
    void refresh() { refresh(M::body_to_navigation(estimator.state)); }

    // What follows from state and covariance when both are of now; returns what changed.
    Change follow();

    Preintegration ahead_;                                         // since the state was carried forward
    ImuIncrement previous_;                                        // the one before the next
    Eigen::Matrix3d to_navigation_ = Eigen::Matrix3d::Identity();  // body to local level, of the state
    Covariance covariance_ = Covariance::Zero();                   // of the errors of the navigation state
    CoarseStage<M> coarse_;
    GaussianSum<M> bank_;
    Sensors known_ = Sensors::Zero();  // of the sensors' errors, before the bank
    double since_motion_ = 0.0;        // [s]
    int refused_ = 0;                  // fixes in a row that none of the bank had foretold
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
    bank_.reserve();
    bank_.clear();
    if (begins_coarsely) {
        coarse_.begin();
    } else {
        coarse_.end();
    }
}

template <bool coloured>
void InvariantEngine<coloured>::forget(bool has_fixes) {
    know(this->sigma_at_start().cwiseAbs2().asDiagonal());
    bank_.clear();
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
    bank_.clear();
    if (resumes_coarsely && has_fixes) {
        coarse_.begin();
    }
    return proposal;
}

template <bool coloured>
void InvariantEngine<coloured>::add_uncertainty(const Uncertainty& more) {
    estimator.covariance += in_states(this->states_of(more));
    if (coarse_.active()) {
        coarse_.doubt(more);
    }
    for (auto& member : bank_.members()) {
        member.covariance += in_states(member.state, this->states_of(more));
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
    if (bank_.active()) {
        since_motion_ = moves(estimator.state, ahead_) ? 0.0 : since_motion_ + ahead_.duration;
        bank_.predict(estimator.model, ahead_);
    }
    const Prediction prediction = estimator.predict(ahead_);
    if (coarse_.active()) {
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
std::optional<Change> InvariantEngine<coloured>::apply_coarsely(const typename M::Fix& fix) {
    if (bank_.active()) {
        return weigh(fix);
    }
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
        conclude(solution->at_first_fix);
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
auto InvariantEngine<coloured>::in_states(const typename M::State& state, const Covariance& covariance)
    -> Covariance {
    return M::turned(M::body_to_navigation(state).transpose(), covariance);
}

template <bool coloured>
auto InvariantEngine<coloured>::corrected(const Covariance& prior,
                                          const Innovation<Base::kStates, Base::kMeasurements>& innovation)
    -> Correction<Base::kStates, Base::kMeasurements> {
    if (!this->corrector.knows_sigmas()) {
        return this->corrector.correct(prior, innovation);
    }
    const Eigen::Matrix3d C_bn = M::body_to_navigation(estimator.state);
    const Eigen::Matrix3d C_nb = C_bn.transpose();
    auto turned = innovation;
    M::turn(C_bn, turned.cross);
    auto correction = this->corrector.correct(M::turned(C_bn, prior), turned);
    M::turn(C_nb, correction.deviation);
    correction.covariance = M::turned(C_nb, correction.covariance);
    return correction;
}

template <bool coloured>
void InvariantEngine<coloured>::place(const Eigen::Quaterniond& attitude, const typename M::Fix& fix,
                                      double heading_sigma) {
    estimator.state.pose = placed(attitude, fix);
    Vector<Base::kStates> sigma = this->sigma_at_start();
    sigma.template segment<3>(M::kRotation).setConstant(kUnknownAngle);
    sigma.template segment<3>(M::kVelocity) = estimator.model.velocity_sigma(fix);
    sigma.template segment<3>(M::kPosition) = estimator.model.position_sigma(fix);
    // Of the errors of the navigation state, whose third is about the vertical.
    sigma(M::kRotation + 2) = heading_sigma;
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
void InvariantEngine<coloured>::conclude(const Eigen::Quaterniond& at_first_fix) {
    const Sensors known = estimator.state.sensors;
    const Linearisation found = take_again(at_first_fix, known);
    refresh();
    if (heading_sigma() > kWide) {
        spread(found, known);
        take_moments();
    }
    const Uncertainty doubted = coarse_.doubted();
    coarse_.end();
    add_uncertainty(doubted);
}

template <bool coloured>
auto InvariantEngine<coloured>::take_again(const Eigen::Quaterniond& at_first_fix, const Sensors& known)
    -> Linearisation {
    constexpr int kPasses = 5;
    constexpr double kStands = 0.01;  // [rad]
    Linearisation at{.attitude = at_first_fix, .biases = known.template head<6>()};
    double moved = kUnknownAngle;
    for (int pass = 0; pass < kPasses && moved > kStands; ++pass) {
        take_again(at, known, kUnknownAngle);
        at.biases = estimator.state.sensors.template head<6>();
        const Eigen::Quaterniond found = coarse_.at_first_fix(estimator.state.pose.attitude, at.biases);
        moved = angle_between(at.attitude, found);
        at.attitude = found;
    }
    return at;
}

template <bool coloured>
double InvariantEngine<coloured>::take_again(const Linearisation& at, const Sensors& known,
                                             double heading_sigma) {
    estimator.state.sensors = known;
    estimator.state.sensors.template head<6>() = at.biases;
    place(at.attitude, coarse_.first_fix(), heading_sigma);
    // Wherever the trajectory has the biases, what is known of them beforehand stays what it was.
    Vector<Base::kStates> prior = Vector<Base::kStates>::Zero();
    prior.template tail<M::kSensors>() = known - estimator.state.sensors;
    this->corrector.restart();
    double likelihood = 0.0;
    filter_along_trajectory(estimator.model, estimator.state, estimator.covariance, prior,
                            coarse_.after_first_fix(), [&](const auto& P, const auto& innovation) {
                                likelihood += log_likelihood(innovation);
                                return this->corrected(P, innovation);
                            });
    return likelihood;
}

template <bool coloured>
void InvariantEngine<coloured>::spread(const Linearisation& at, const Sensors& known) {
    constexpr int kHeadings = 18;
    constexpr double kApart = 2.0 * std::numbers::pi / kHeadings;
    const Eigen::Vector3d vertical = coarse_.first_fix().C_en.row(2);
    const bool evident = moved(at, known);
    for (int k = 0; k < kHeadings; ++k) {
        const Eigen::Quaterniond turn = quaternion(k * kApart * vertical);
        const double likelihood =
            take_again({.attitude = turn * at.attitude, .biases = at.biases}, known, 0.5 * kApart);
        const double prior = log_prior(estimator.state, known);
        bank_.add({.state = estimator.state,
                   .covariance = estimator.covariance,
                   .evidence = evident ? likelihood - prior : 0.0,
                   .log_prior = prior});
    }
    refused_ = 0;
    since_motion_ = kSettled;
    known_ = known;
}

template <bool coloured>
std::optional<Change> InvariantEngine<coloured>::weigh(const typename M::Fix& fix) {
    constexpr int kPatience = 10;
    const auto prior = [this](const typename M::State& state) { return log_prior(state, known_); };
    const bool evident = since_motion_ < kSettled || swings(estimator.state, fix);
    if (!bank_.correct(estimator.model, fix, this->corrector.gate, prior, evident)) {
        if (++refused_ == kPatience) {
            bank_.clear();
            coarse_.begin();
        }
        return std::nullopt;
    }
    refused_ = 0;
    take_moments();
    if (heading_sigma() < kWide) {
        bank_.clear();
        this->corrector.restart();
    }
    return follow();
}

template <bool coloured>
double InvariantEngine<coloured>::log_prior(const typename M::State& state, const Sensors& known) const {
    const Vector<Base::kStates> sigma = this->sigma_at_start();
    return -0.5 * (state.sensors - known).cwiseQuotient(sigma.template tail<M::kSensors>()).squaredNorm();
}

template <bool coloured>
bool InvariantEngine<coloured>::moves(const typename M::State& x, const Preintegration& interval) const {
    const M& model = estimator.model;
    const Eigen::Vector3d change = model.moved(x, interval).navigation().velocity - x.navigation().velocity;
    // What the velocity gains by the errors of tilt and sensors.
    Matrix<3, Base::kStates> gain = model.transition(x, interval).template middleRows<3>(M::kVelocity);
    gain.template middleCols<3>(M::kVelocity).setZero();
    const Eigen::Matrix3d C_bn = M::navigation_errors(x).template topLeftCorner<3, 3>();
    const Eigen::Vector3d up = C_bn.row(2);
    gain.template leftCols<3>() -= (gain.template leftCols<3>() * up * up.transpose()).eval();
    const Matrix<2, Base::kStates> level = C_bn.topRows<2>() * gain;
    const double errors = (level * estimator.covariance * level.transpose()).trace();
    const double walk = model.noise.velocity_random_walk;
    const double noise = 2.0 * walk * walk * interval.duration;
    return change.head<2>().squaredNorm() > kSigmas * kSigmas * (errors + noise);
}

template <bool coloured>
bool InvariantEngine<coloured>::moved(const Linearisation& at, const Sensors& known) const {
    typename M::State x = estimator.state;
    x.sensors = known;
    x.sensors.template head<6>() = at.biases;
    x.pose = placed(at.attitude, coarse_.first_fix());
    return std::ranges::any_of(coarse_.after_first_fix(), [&](const Epoch<M>& epoch) {
        const typename M::State before = std::exchange(x, estimator.model.moved(x, epoch.interval));
        return moves(before, epoch.interval) || swings(x, epoch.fix);
    });
}

template <bool coloured>
bool InvariantEngine<coloured>::swings(const typename M::State& x, const typename M::Fix& fix) const {
    const Eigen::Vector3d velocity = fix.C_en * (x.pose.attitude * fix.velocity_arm);
    const double rate_noise = estimator.model.noise.angle_random_walk / std::sqrt(previous_.dt);
    return velocity.head<2>().norm() > kSigmas * rate_noise * fix.lever_arm.norm();
}

template <bool coloured>
void InvariantEngine<coloured>::take_moments() {
    const auto moments = bank_.moments();
    estimator.state = moments.state;
    estimator.covariance = moments.covariance;
    refresh();
}

template <bool coloured>
void InvariantEngine<coloured>::refresh(const Eigen::Matrix3d& C_bn) {
    to_navigation_ = C_bn;
    covariance_ = M::turned(C_bn, estimator.covariance);
    if constexpr (coloured) {
        covariance_.template middleRows<6>(M::kGyro) += covariance_.template middleRows<6>(M::kGyroMarkov);
        covariance_.template middleCols<6>(M::kGyro) += covariance_.template middleCols<6>(M::kGyroMarkov);
        symmetrise(covariance_);
    }
}

template <bool coloured>
Change InvariantEngine<coloured>::follow() {
    const NavigationState before = mechanisation_.state;
    mechanisation_.state = estimator.state.navigation();
    refresh(mechanisation_.state.q_bn.toRotationMatrix());
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
