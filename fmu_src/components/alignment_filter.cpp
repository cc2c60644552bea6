#include "components/alignment_filter.hpp"

#include <cmath>
#include <limits>

#include "components/parameter_rules.hpp"
#include "components/text.hpp"
#include "estimation/delayed.hpp"

namespace truenorth {

using alignment_filter::Parameters;
using alignment_filter::Status;

namespace {

constexpr double kTimeTolerance = 1e-9;  // [s]

// The part of the parameters that follows the choice of a model: one overload a model.

void configure_model(LargeAzimuth& model, const Parameters& p) {
    using Form = LargeAzimuth::VelocityForm;
    switch (p.velocity_form) {
        case alignment_filter::VelocityForm::transposed:
            model.velocity_form = Form::transposed;
            break;
        case alignment_filter::VelocityForm::computed_force:
            model.velocity_form = Form::computed_force;
            break;
        case alignment_filter::VelocityForm::vertical_force:
            model.velocity_form = Form::vertical_force;
            break;
        case alignment_filter::VelocityForm::printed:
            model.velocity_form = Form::printed;
            break;
    }
}

void configure_model(EulerPlatform& model, const Parameters& p) {
    switch (p.error_model) {
        case alignment_filter::ErrorModel::large_azimuth:
        case alignment_filter::ErrorModel::euler_platform:
            model.form = Misalignment::large;
            break;
        case alignment_filter::ErrorModel::euler_platform_large_azimuth:
            model.form = Misalignment::large_azimuth;
            break;
        case alignment_filter::ErrorModel::euler_platform_small:
            model.form = Misalignment::small;
            break;
    }
}

LargeAzimuth::Fix fix_of(const LargeAzimuth& /*model*/, const AntennaState& antenna, const GnssFix& fix) {
    return {.velocity_difference = (antenna.velocity - fix.velocity).head<2>(),
            .lever_velocity = antenna.lever_velocity};
}

EulerPlatform::Fix fix_of(const EulerPlatform& /*model*/, const AntennaState& antenna, const GnssFix& fix) {
    return {.velocity = antenna.velocity - fix.velocity};
}

// Settings that every model has.

Predictor predictor(const Parameters& p) {
    const UnscentedParameters unscented{
        .alpha = p.unscented.alpha, .beta = p.unscented.beta, .kappa = p.unscented.kappa};
    switch (p.predictor) {
        case alignment_filter::Predictor::linearised:
            return Linearised();
        case alignment_filter::Predictor::unscented:
            break;
        case alignment_filter::Predictor::augmented:
            return Augmented(unscented);
    }
    return Unscented(unscented);
}

Discretisation discretisation(const Parameters& p) {
    return p.discretisation == alignment_filter::Discretisation::euler ? Discretisation::euler
                                                                       : Discretisation::runge_kutta;
}

template <class Engine>
Vector<Engine::kStates> prior_sigma(const Parameters& p) {
    using Where = typename Engine::Where;
    Vector<Engine::kStates> sigma;
    const auto set = [&](Block block, double value) {
        sigma.segment(block.first, block.count).setConstant(value);
    };
    set(Where::velocity, p.prior.velocity_sigma);
    set(Where::gyro, p.prior.gyro_bias_sigma);
    set(Where::accelerometer, p.prior.accelerometer_bias_sigma);
    set(Where::attitude, p.prior.tilt_sigma);
    sigma(Where::attitude.first + 2) = p.prior.heading_sigma;
    return sigma;
}

template <class Engine>
void configure_corrector(Engine& engine, const Parameters& p) {
    auto& corrector = engine.corrector;
    using Method = typename std::remove_reference_t<decltype(corrector)>::Method;
    switch (p.corrector) {
        case alignment_filter::Corrector::standard:
            corrector.method = Method::standard;
            break;
        case alignment_filter::Corrector::h_infinity:
            corrector.method = Method::h_infinity;
            break;
        case alignment_filter::Corrector::igg:
            corrector.method = Method::igg;
            break;
        case alignment_filter::Corrector::adaptive_factor:
            corrector.method = Method::adaptive_factor;
            break;
        case alignment_filter::Corrector::variational_bayes:
            corrector.method = Method::variational_bayes;
            break;
    }
    corrector.gate.enabled = p.gate.enabled;
    corrector.gate.threshold = p.gate.threshold;
    corrector.igg.k0 = p.igg.k0;
    corrector.igg.k1 = p.igg.k1;
    corrector.igg.patience = p.igg.patience;
    auto& adaptive = corrector.adaptive_factor;
    adaptive.form = p.adaptive.form == alignment_filter::AdaptiveForm::printed
                        ? AdaptiveFactor::Form::printed
                        : AdaptiveFactor::Form::unit_free;
    adaptive.threshold = p.adaptive.threshold;
    auto& bayes = corrector.variational_bayes;
    using BayesForm = typename std::remove_reference_t<decltype(bayes)>::Form;
    bayes.form = p.variational_bayes.form == alignment_filter::BayesForm::printed ? BayesForm::printed
                                                                                  : BayesForm::corrected;
    bayes.rho = p.variational_bayes.rho;
    bayes.iterations = p.variational_bayes.iterations;
}

// L and the ceiling of the H-infinity update, `elapsed` seconds after the last one.
template <class Engine>
void scale_h_infinity(Engine& engine, const Parameters& p, double elapsed) {
    using alignment_filter::RobustScaling;
    auto& h_infinity = engine.corrector.h_infinity;
    h_infinity.gamma = p.robust.gamma;
    constexpr int heading = Engine::Where::attitude.first + 2;
    Vector<Engine::kStates> sigma = engine.prior_sigma;
    if (p.robust.heading_sigma > 0.0) {
        sigma(heading) = p.robust.heading_sigma;
    }
    h_infinity.ceiling = std::nullopt;
    switch (p.robust.scaling) {
        case RobustScaling::printed:
            h_infinity.scale.setOnes();
            break;
        case RobustScaling::rate_invariant:
            h_infinity.scale = std::sqrt(elapsed / p.robust.horizon) * sigma.cwiseInverse();
            break;
        case RobustScaling::ceiling:
            h_infinity.scale = sigma.cwiseInverse();
            h_infinity.ceiling = {.sigma = sigma, .limit = p.robust.ceiling};
            break;
    }
    if (p.robust.states == alignment_filter::RobustStates::heading) {
        const double protected_scale = h_infinity.scale(heading);
        h_infinity.scale.setZero();
        h_infinity.scale(heading) = protected_scale;
    }
}

// The first components of an output; the others are zero.
template <int Size>
Eigen::Vector3d padded(const Vector<Size>& v) {
    Eigen::Vector3d output = Eigen::Vector3d::Zero();
    output.head<Size>() = v;
    return output;
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

void AlignmentFilter::check() const {
    validate(parameters);
    const auto& p = parameters;
    if (p.robust.heading_sigma > 0.0 && p.robust.heading_sigma < p.prior.heading_sigma) {
        rules::refuse("robust.heading_sigma", p.robust.heading_sigma,
                      text("0 or at least prior.heading_sigma = ", p.prior.heading_sigma));
    }
    if (p.igg.k1 <= p.igg.k0) {
        rules::refuse("igg.k1", p.igg.k1, text("greater than igg.k0 = ", p.igg.k0));
    }
    if (p.error_model == alignment_filter::ErrorModel::large_azimuth) {
        return;
    }
    if (p.velocity_form != alignment_filter::VelocityForm::transposed) {
        rules::refuse(
            "velocity_form", static_cast<int>(p.velocity_form),
            "transposed (1) unless error_model is large_azimuth: the Euler models have one right form");
    }
    for (int i = 0; i < 3; ++i) {
        if (p.initial.velocity[i] != 0.0) {
            rules::refuse(
                text("initial.velocity[", i + 1, "]"), p.initial.velocity[i],
                "0 unless error_model is large_azimuth: the Euler models are for a stationary base");
        }
        if (p.gnss.lever_arm[i] != 0.0) {
            rules::refuse(
                text("gnss.lever_arm[", i + 1, "]"), p.gnss.lever_arm[i],
                "0 unless error_model is large_azimuth: the Euler models measure the IMU's velocity");
        }
    }
}

void AlignmentFilter::choose_model() {
    if (parameters.error_model == alignment_filter::ErrorModel::large_azimuth) {
        engine_.emplace<NavigationEngine<LargeAzimuth>>();
    } else {
        engine_.emplace<NavigationEngine<EulerPlatform>>();
    }
}

void AlignmentFilter::configure() {
    std::visit(
        [this]<class Engine>(Engine& engine) {
            auto& model = engine.estimator.model;
            configure_model(model, parameters);
            model.discretisation = discretisation(parameters);
            model.noise = {.angle_random_walk = parameters.process.angle_random_walk,
                           .velocity_random_walk = parameters.process.velocity_random_walk,
                           .velocity_sigma = parameters.measurement.velocity_sigma};
            engine.estimator.predictor = predictor(parameters);
            engine.feedback = parameters.feedback;
            engine.prior_sigma = prior_sigma<Engine>(parameters);
            configure_corrector(engine, parameters);
        },
        engine_);
}

void AlignmentFilter::initialise(double start_time) {
    check();
    choose_model();
    configure();
    imu_.start(start_time);
    gnss_.start();

    const auto& initial = parameters.initial;
    const NavigationState start{
        .q_bn = Eigen::Quaterniond(
            dcm({.roll = initial.roll, .pitch = initial.pitch, .heading = initial.heading})),
        .velocity = initial.velocity,
        .position = {.latitude = initial.latitude,
                     .longitude = wrap_angle(initial.longitude),
                     .height = initial.height}};
    std::visit([&](auto& engine) { engine.start(start); }, engine_);

    travelled_ = IntervalAverage{};
    history_ = AntennaHistory{};
    remember_antenna();
    last_use_ = start_time;
    below_since_ = std::numeric_limits<double>::quiet_NaN();
    faulted_ = false;
    outputs = {};
    outputs.robust.feasible = true;
    outputs.adaptive.alpha = 1.0;
    publish();
}

void AlignmentFilter::retune() {
    check();
    configure();
}

void AlignmentFilter::step(double /*time*/, double /*step*/) {
    if (!faulted_) {
        take_sample();
        take_fix();
    }
    const double pending = std::visit([](const auto& engine) { return engine.pending(); }, engine_);
    if (!faulted_ && pending > parameters.filter.interval - kTimeTolerance) {
        predict();
    }
    publish();
}

void AlignmentFilter::take_sample() {
    const auto& port = inputs.imu;
    const auto verdict = imu_.read(port.sample, port.time, port.delta_angle, port.delta_velocity);
    switch (verdict) {
        case ImuInput::Verdict::stale:
            return;
        case ImuInput::Verdict::rejected:
            if (log_->listens()) {
                log_->event(text("IMU sample ", port.sample, " (imu.time = ", port.time,
                                 " s) rejected: not finite, impossible, or its time does not follow ",
                                 imu_.time(), " s"));
            }
            return;
        case ImuInput::Verdict::resumed:
            if (log_->listens()) {
                log_->event(text("IMU data resume at imu.time = ", port.time,
                                 " s after a gap that cannot be bridged; alignment starts again"));
            }
            break;
        case ImuInput::Verdict::accepted:
            break;
    }
    if (imu_.gap() > 0 && log_->listens()) {
        log_->event(text(imu_.gap(), " IMU sample(s) missed before imu.time = ", port.time,
                         " s; bridged with the mean rate of the next"));
    }
    std::visit(
        [&](auto& engine) {
            if (verdict == ImuInput::Verdict::resumed) {
                engine.forget();
                history_ = AntennaHistory{};
            }
            const NavigationState before = engine.mechanisation().state;
            engine.mechanise(imu_.increment());
            engine.doubt(imu_.doubtful_angle(), imu_.doubtful_velocity());
            travelled_.add(before, engine.mechanisation(), imu_.increment().dt);
        },
        engine_);
    remember_antenna();
}

void AlignmentFilter::remember_antenna() {
    std::visit(
        [&](const auto& engine) {
            const Mechanisation& mechanisation = engine.mechanisation();
            const Eigen::Vector3d& lever_arm = parameters.gnss.lever_arm;
            // The position is compared with the fix's as it is; the model accounts for the error of the lever
            // velocity, which therefore is that of the mechanised attitude.
            const Eigen::Vector3d lever_velocity =
                mechanisation.state.q_bn * mechanisation.omega_eb_b().cross(lever_arm);
            history_.push({.time = imu_.time(),
                           .position = point_position(engine.best(), lever_arm),
                           .velocity = mechanisation.state.velocity + lever_velocity,
                           .lever_velocity = lever_velocity,
                           .travelled = travelled_});
        },
        engine_);
}

void AlignmentFilter::take_fix() {
    const auto& port = inputs.gnss;
    const GnssFix fix{
        .time = port.time,
        .position = {.latitude = port.latitude, .longitude = port.longitude, .height = port.height},
        .velocity = port.velocity};
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
    predict();
    if (!faulted_) {
        std::visit([&](auto& engine) { correct(engine, fix, *antenna); }, engine_);
    }
}

void AlignmentFilter::reject_fix(const char* reason) {
    ++outputs.rejected_fixes;
    outputs.measurement_weight.setZero();
    if (log_->listens()) {
        log_->event(
            text("fix ", inputs.gnss.sample, " (gnss.time = ", inputs.gnss.time, " s) rejected: ", reason));
    }
}

void AlignmentFilter::predict() {
    const Prediction prediction = std::visit(
        [](auto& engine) { return engine.pending() > 0.0 ? engine.predict() : Prediction::sound; }, engine_);
    switch (prediction) {
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

template <class Engine>
void AlignmentFilter::correct(Engine& engine, const GnssFix& fix, const AntennaState& antenna) {
    using Model = typename Engine::Model;
    const typename Model::Fix seen = fix_of(engine.estimator.model, antenna, fix);
    const IntervalAverage since = travelled_ - antenna.travelled;
    const auto& estimator = engine.estimator;
    const auto innovation =
        since.duration() > kTimeTolerance
            ? innovate_delayed(estimator.model, estimator.state, estimator.covariance, seen,
                               typename Model::Interval(since, antenna.position, estimator.state))
            : engine.innovate(seen);

    scale_h_infinity(engine, parameters, imu_.time() - last_use_);
    const auto correction = engine.corrector.correct(estimator.covariance, innovation);
    outputs.innovation = padded(innovation.residual);
    outputs.innovation_sigma =
        padded<Engine::kMeasurements>((innovation.spread + innovation.noise).diagonal().cwiseSqrt());
    outputs.nis = nis(innovation);
    if (!correction.used()) {
        reject_fix(engine.corrector.gate.admits(innovation) ? "every component lost its weight"
                                                            : "its NIS is beyond gate.threshold");
        return;
    }

    const auto change = engine.apply(correction);
    if (!change.finite) {
        fault("the correction is not finite");
        return;
    }
    ++outputs.used_fixes;
    last_use_ = imu_.time();
    outputs.measurement_weight = padded(correction.weight);
    outputs.measurement_sigma_estimate =
        padded<Engine::kMeasurements>(correction.noise.diagonal().cwiseSqrt());
    outputs.adaptive.alpha = correction.alpha;
    const bool robust = parameters.corrector == alignment_filter::Corrector::h_infinity;
    outputs.robust.feasible = correction.feasible;
    outputs.robust.gamma_effective = robust && correction.feasible ? correction.gamma_effective : 0.0;
    if (!correction.feasible && log_->listens()) {
        log_->event(text("H-infinity update at ", imu_.time(), " s: robust.gamma = ", parameters.robust.gamma,
                         " is infeasible; a standard update took its place"));
    }

    // Position, and the vertical velocity where it is not a state.
    const bool climbs = Engine::Where::velocity.count == 3;
    const Eigen::Vector3d climb(0.0, 0.0, climbs ? 0.0 : fix.velocity.z() - antenna.velocity.z());
    const Eigen::Vector3d displacement = earth::displacement(antenna.position, fix.position);
    engine.move(climb, displacement);
    history_.turn(change.rotation, travelled_);
    history_.shift(change.velocity + climb, displacement);
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
        std::visit([this](const auto& engine) { publish(engine); }, engine_);
    }
    publish_status();
}

template <class Engine>
void AlignmentFilter::publish(const Engine& engine) {
    using Where = typename Engine::Where;
    const NavigationState best = engine.best();
    const EulerAngles angles = euler_angles(best.q_bn.toRotationMatrix());
    auto& nav = outputs.nav;
    nav.time = imu_.time();
    nav.roll = angles.roll;
    nav.pitch = angles.pitch;
    nav.heading = angles.heading;
    nav.velocity = best.velocity;
    nav.latitude = best.position.latitude;
    nav.longitude = best.position.longitude;
    nav.height = best.position.height;

    const Vector<Engine::kStates> sigma = engine.estimator.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    outputs.misalignment = engine.misalignment();
    outputs.misalignment_sigma = components(sigma, Where::attitude);
    outputs.heading_sigma = outputs.misalignment_sigma.z();
    outputs.velocity_sigma = components(sigma, Where::velocity);
    outputs.gyro_bias = engine.gyro_bias();
    outputs.gyro_bias_sigma = components(sigma, Where::gyro, parameters.prior.gyro_bias_sigma);
    outputs.accelerometer_bias = engine.accelerometer_bias();
    outputs.accelerometer_bias_sigma =
        components(sigma, Where::accelerometer, parameters.prior.accelerometer_bias_sigma);
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
