#include "components/alignment_filter.hpp"

#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "components/invalid_parameter.hpp"

namespace truenorth {

using alignment_filter::Status;

namespace {

// One text of several parts, for the log.
template <class... Parts>
std::string text(const Parts&... parts) {
    std::ostringstream stream;
    (stream << ... << parts);
    return stream.str();
}

const char* reason(GnssInput::Verdict verdict) {
    switch (verdict) {
        case GnssInput::Verdict::not_finite:
            return "a value is not finite";
        case GnssInput::Verdict::impossible:
            return "position or velocity is impossible";
        case GnssInput::Verdict::backwards:
            return "its time does not follow that of the fix before";
        case GnssInput::Verdict::future:
            return "it is younger than the IMU data";
        case GnssInput::Verdict::stale:
        case GnssInput::Verdict::accepted:
            break;
    }
    return "";
}

}  // namespace

void AlignmentFilter::initialise(double start_time) {
    configure();
    imu_.start(start_time);
    gnss_.start();

    NavigationState start;
    const auto& initial = parameters.initial;
    start.q_bn = Eigen::Quaterniond(dcm({initial.roll, initial.pitch, initial.heading}));
    start.velocity = initial.velocity;
    start.position = {initial.latitude, wrap_angle(initial.longitude), initial.height};
    mechanisation_ = Mechanisation(start);

    average_ = IntervalAverage{};
    history_ = AntennaHistory{};
    remember_antenna();
    estimator_.state.setZero();
    estimator_.covariance = prior_sigma_.cwiseAbs2().asDiagonal();
    gyro_bias_.setZero();
    accelerometer_bias_.setZero();
    fed_back_.setZero();
    last_use_ = start_time;
    below_since_ = std::numeric_limits<double>::quiet_NaN();
    faulted_ = false;
    outputs = {};
    publish();
}

void AlignmentFilter::retune() { configure(); }

// Everything that follows from the parameters alone.
void AlignmentFilter::configure() {
    validate(parameters);
    const auto& p = parameters;
    if (p.robust.heading_sigma > 0.0 && p.robust.heading_sigma < p.prior.heading_sigma) {
        throw InvalidParameter(text("robust.heading_sigma = ", p.robust.heading_sigma,
                                    ": must be 0 or at least prior.heading_sigma = ", p.prior.heading_sigma));
    }

    Model& model = estimator_.model;
    // The enumerations of the interface count from 1, in the order of the model's own.
    model.velocity_form = static_cast<Model::VelocityForm>(static_cast<int>(p.velocity_form) - 1);
    model.discretisation = static_cast<Discretisation>(static_cast<int>(p.discretisation) - 1);
    model.noise = {p.process.angle_random_walk, p.process.velocity_random_walk, p.measurement.velocity_sigma};

    if (p.predictor == alignment_filter::Predictor::linearised) {
        estimator_.predictor = Linearised();
    } else {
        estimator_.predictor = Unscented({p.unscented.alpha, p.unscented.beta, p.unscented.kappa});
    }

    prior_sigma_.segment<2>(Model::kVelocityEast).setConstant(p.prior.velocity_sigma);
    prior_sigma_.segment<2>(Model::kPhiEast).setConstant(p.prior.tilt_sigma);
    prior_sigma_(Model::kPhiUp) = p.prior.heading_sigma;
    prior_sigma_.segment<2>(Model::kAccelerometerX).setConstant(p.prior.accelerometer_bias_sigma);
    prior_sigma_.segment<3>(Model::kGyroX).setConstant(p.prior.gyro_bias_sigma);
    gate_ = {p.gate.enabled, p.gate.threshold};
}

void AlignmentFilter::step(double /*time*/, double /*step*/) {
    if (!faulted_) {
        take_sample();
    }
    if (!faulted_) {
        take_fix();
    }
    if (!faulted_ && average_.duration() > parameters.filter.interval - 1e-9) {
        predict();
    }
    publish();
}

void AlignmentFilter::take_sample() {
    const auto& port = inputs.imu;
    switch (imu_.read(port.sample, port.time, port.delta_angle, port.delta_velocity)) {
        case ImuInput::Verdict::stale:
            return;
        case ImuInput::Verdict::rejected:
            if (log_->listens()) {
                log_->event(text("IMU sample ", port.sample, " (imu.time = ", port.time,
                                 " s) rejected: not finite, impossible, or its time does not follow ",
                                 imu_.time(), " s"));
            }
            return;
        case ImuInput::Verdict::accepted:
            break;
    }
    if (imu_.gap() > 0 && log_->listens()) {
        log_->event(text(imu_.gap(), " IMU sample(s) missed before imu.time = ", port.time,
                         " s; bridged with the mean rate of the next"));
    }

    ImuIncrement increment = imu_.increment();
    increment.delta_angle -= gyro_bias_ * increment.dt;
    increment.delta_velocity -= accelerometer_bias_ * increment.dt;
    const NavigationState before = mechanisation_.state;
    mechanisation_.advance(increment);
    average_.add(before, mechanisation_, increment.dt);
    remember_antenna();
}

void AlignmentFilter::remember_antenna() {
    const NavigationState best = Model::corrected(mechanisation_.state, estimator_.state);
    const NavigationState& computed = mechanisation_.state;
    const Eigen::Vector3d& lever_arm = parameters.gnss.lever_arm;
    history_.push({imu_.time(), point_position(best, lever_arm),
                   point_velocity(computed, mechanisation_.omega_eb_b(), lever_arm)});
}

void AlignmentFilter::take_fix() {
    const auto& port = inputs.gnss;
    const GnssFix fix{port.time, {port.latitude, port.longitude, port.height}, port.velocity};
    const auto verdict = gnss_.read(port.sample, fix, imu_.time());
    if (verdict == GnssInput::Verdict::stale) {
        return;
    }
    if (verdict != GnssInput::Verdict::accepted) {
        reject_fix(reason(verdict));
        return;
    }
    const auto antenna = history_.at(fix.time);
    if (!antenna) {
        reject_fix("it is older than the history that is kept");
        return;
    }
    if (average_.duration() > 0.0) {
        predict();
    }
    if (!faulted_) {
        correct(fix, *antenna);
    }
}

void AlignmentFilter::reject_fix(const char* reason) {
    ++outputs.rejected_fixes;
    if (log_->listens()) {
        log_->event(
            text("fix ", inputs.gnss.sample, " (gnss.time = ", inputs.gnss.time, " s) rejected: ", reason));
    }
}

void AlignmentFilter::predict() {
    const Model::Interval interval(average_, mechanisation_.state.position, estimator_.state);
    average_ = IntervalAverage{};
    switch (estimator_.predict(interval)) {
        case Prediction::sound:
            break;
        case Prediction::repaired:
            if (log_->listens()) {
                log_->event(
                    text("covariance was not positive definite at ", imu_.time(), " s and was repaired"));
            }
            break;
        case Prediction::failed:
            fault("the prediction is not finite");
            break;
    }
}

void AlignmentFilter::correct(const GnssFix& fix, const AntennaState& antenna) {
    // The velocity error is taken as constant between the fix and now: its rate is that of the remaining
    // tilt.
    const Eigen::Vector3d lever_velocity =
        mechanisation_.state.q_bn * mechanisation_.omega_eb_b().cross(parameters.gnss.lever_arm);
    const auto innovation =
        estimator_.innovate({(antenna.velocity - fix.velocity).head<2>(), lever_velocity});

    outputs.innovation = innovation.residual;
    outputs.innovation_sigma = (innovation.spread + innovation.noise).diagonal().cwiseSqrt();
    outputs.nis = nis(innovation);
    const bool admitted = gate_.admits(outputs.nis);
    outputs.measurement_weight.setConstant(admitted ? 1.0 : 0.0);
    if (!admitted) {
        reject_fix("its NIS is beyond gate.threshold");
        return;
    }

    estimator_.apply(corrected(innovation));
    if (!estimator_.state.allFinite() || !estimator_.covariance.allFinite()) {
        fault("the correction is not finite");
        return;
    }
    ++outputs.used_fixes;
    last_use_ = imu_.time();

    // Vertical channel and position.
    const double climb = fix.velocity.z() - antenna.velocity.z();
    const Eigen::Vector3d displacement = earth::displacement(antenna.position, fix.position);
    NavigationState& state = mechanisation_.state;
    state.velocity.z() += climb;
    state.position = earth::displaced(state.position, displacement);
    history_.shift({0.0, 0.0, climb}, displacement);

    fed_back_ = estimator_.state.segment<3>(Model::kPhiEast);
    if (parameters.feedback) {
        feed_back();
    }
}

Correction<LargeAzimuth::kStates, LargeAzimuth::kMeasurements> AlignmentFilter::corrected(
    const Innovation<Model::kStates, Model::kMeasurements>& innovation) {
    if (parameters.corrector == alignment_filter::Corrector::standard) {
        return {Standard().correct(estimator_.covariance, innovation)};
    }
    using alignment_filter::RobustScaling;
    const auto& robust = parameters.robust;
    Vector<Model::kStates> sigma = prior_sigma_;
    if (robust.heading_sigma > 0.0) {
        sigma(Model::kPhiUp) = robust.heading_sigma;
    }
    HInfinity<Model::kStates> corrector;
    corrector.gamma = robust.gamma;
    switch (robust.scaling) {
        case RobustScaling::printed:
            corrector.scale.setOnes();
            break;
        case RobustScaling::rate_invariant:
            corrector.scale = std::sqrt((imu_.time() - last_use_) / robust.horizon) * sigma.cwiseInverse();
            break;
        case RobustScaling::ceiling:
            corrector.scale = sigma.cwiseInverse();
            corrector.ceiling = {sigma, robust.ceiling};
            break;
    }
    if (robust.states == alignment_filter::RobustStates::heading) {
        const double heading = corrector.scale(Model::kPhiUp);
        corrector.scale.setZero();
        corrector.scale(Model::kPhiUp) = heading;
    }
    const auto correction = corrector.correct(estimator_.covariance, innovation);
    outputs.robust.gamma_effective = correction.gamma_effective;
    outputs.robust.feasible = correction.feasible;
    if (!correction.feasible && log_->listens()) {
        log_->event(text("H-infinity update at ", imu_.time(), " s: robust.gamma = ", robust.gamma,
                         " is infeasible, backed off to ", correction.gamma_effective));
    }
    return correction;
}

void AlignmentFilter::feed_back() {
    const Model::State& x = estimator_.state;
    const Eigen::Vector3d velocity_before = mechanisation_.state.velocity;
    mechanisation_.state = Model::corrected(mechanisation_.state, x);
    history_.shift(mechanisation_.state.velocity - velocity_before, Eigen::Vector3d::Zero());
    gyro_bias_ += x.segment<3>(Model::kGyroX);
    accelerometer_bias_.head<2>() += x.segment<2>(Model::kAccelerometerX);
    estimator_.reset(Model::State::Zero());
}

void AlignmentFilter::fault(const char* reason) {
    faulted_ = true;
    if (log_->listens()) {
        log_->event(text("estimation stopped at ", imu_.time(), " s: ", reason));
    }
}

void AlignmentFilter::publish() {
    outputs.rejected_samples = imu_.rejected();
    outputs.missed_samples = imu_.missed();
    if (!faulted_) {
        const Model::State& x = estimator_.state;
        const NavigationState best = Model::corrected(mechanisation_.state, x);
        const EulerAngles angles = euler_angles(best.q_bn.toRotationMatrix());
        outputs.nav.time = imu_.time();
        outputs.nav.roll = angles.roll;
        outputs.nav.pitch = angles.pitch;
        outputs.nav.heading = angles.heading;
        outputs.nav.velocity = best.velocity;
        outputs.nav.latitude = best.position.latitude;
        outputs.nav.longitude = best.position.longitude;
        outputs.nav.height = best.position.height;

        const Model::State sigma = estimator_.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
        outputs.misalignment =
            parameters.feedback ? fed_back_ : Eigen::Vector3d(x.segment<3>(Model::kPhiEast));
        outputs.misalignment_sigma = sigma.segment<3>(Model::kPhiEast);
        outputs.heading_sigma = sigma(Model::kPhiUp);
        outputs.velocity_sigma = sigma.segment<2>(Model::kVelocityEast);
        outputs.gyro_bias = gyro_bias_ + x.segment<3>(Model::kGyroX);
        outputs.gyro_bias_sigma = sigma.segment<3>(Model::kGyroX);
        outputs.accelerometer_bias = accelerometer_bias_;
        outputs.accelerometer_bias.head<2>() += x.segment<2>(Model::kAccelerometerX);
        outputs.accelerometer_bias_sigma << sigma.segment<2>(Model::kAccelerometerX),
            parameters.prior.accelerometer_bias_sigma;
    }
    publish_status();
}

void AlignmentFilter::publish_status() {
    const double now = imu_.time();
    if (outputs.heading_sigma >= parameters.convergence.heading_sigma) {
        below_since_ = std::numeric_limits<double>::quiet_NaN();
    } else if (std::isnan(below_since_)) {
        below_since_ = now;
    }
    const bool was_converged = outputs.converged;
    outputs.converged =
        !faulted_ && outputs.used_fixes > 0 && now - below_since_ >= parameters.convergence.hold_time;

    if (faulted_) {
        outputs.status = Status::faulted;
    } else if (!imu_.any() || outputs.used_fixes == 0) {
        outputs.status = Status::waiting;
    } else if (now - last_use_ > parameters.coasting.delay) {
        outputs.status = Status::coasting;
    } else {
        outputs.status = outputs.converged ? Status::converged : Status::aligning;
    }
    if (outputs.converged != was_converged && log_->listens()) {
        log_->event(text(outputs.converged ? "converged" : "no longer converged", " at ", now, " s"));
    }
}

}  // namespace truenorth
