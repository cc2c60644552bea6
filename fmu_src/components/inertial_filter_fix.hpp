// What inertial_filter.hpp does with a fix.
#pragma once

#include "components/inertial_filter_run.hpp"

namespace truenorth {

// A first fix farther than this from initial.* is a wrong initial position rather than an error of it.
inline constexpr double kFar = 10e3;  // [m]

inline const char* reason(GnssInput::Verdict verdict) {
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

template <int N, int M>
const char* reason_of_refusal(const InnovationGate& gate, const Innovation<N, M>& innovation) {
    if (innovation.channels() == 0) {
        return "no channel has a usable measurement";
    }
    return gate.admits(innovation) ? "every component lost its weight" : "its NIS is beyond gate.threshold";
}

template <class Interface, class... Engines>
GnssFix InertialFilter<Interface, Engines...>::fix_at_port() const {
    const auto& port = inputs.gnss;
    return {.time = port.time,
            .position = {.latitude = port.latitude, .longitude = port.longitude, .height = port.height},
            .velocity = port.velocity};
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::take_fix() {
    const GnssFix fix = fix_at_port();
    const auto verdict = gnss_.read(inputs.gnss.sample, fix, imu_.time());
    if (verdict == GnssInput::Verdict::stale) {
        return;
    }
    if (verdict != GnssInput::Verdict::accepted) {
        reject_fix(reason(verdict));
        return;
    }
    const auto then = history_.at(fix.time);
    if (!then) {
        reject_fix("it is older than the history that is kept");
        return;
    }
    question_place(fix, *then);
    predict();
    if (!status_.faulted()) {
        std::visit([&](auto& engine) { correct(engine, fix, *then); }, engine_);
    }
}

// The first fix tells whether the filter was sent to the right place.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::question_place(const GnssFix& fix, const AntennaState& then) {
    if (outputs.used_fixes + outputs.rejected_fixes > 0 || !log_->listens()) {
        return;
    }
    const double distance = (earth::ecef(fix.position) - earth::ecef(then.position)).norm();
    if (distance > kFar) {
        log_->event(text("the first fix is ", std::round(distance / 1e3),
                         " km from where the filter is: are initial.latitude and initial.longitude right?"));
    }
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::reject_fix(const char* reason) {
    ++outputs.rejected_fixes;
    outputs.measurement_weight.setZero();
    if (log_->listens()) {
        log_->event(
            text("fix ", inputs.gnss.sample, " (gnss.time = ", inputs.gnss.time, " s) rejected: ", reason));
    }
}

template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::correct(E& engine, const GnssFix& fix, const AntennaState& then) {
    using Where = typename E::Where;
    const Sighting seen{.fix = fix,
                        .then = then,
                        .now = antenna(),
                        .since = travelled_ - then.travelled,
                        .lever_arm = parameters.gnss.lever_arm};
    if constexpr (requires { engine.adapter.renewed(inputs.gnss, [](int) {}); }) {
        engine.adapter.renewed(inputs.gnss, [&](int i) { engine.corrector.variational_bayes.restart(i); });
    }
    const auto measured = engine.adapter.fix_of(seen, inputs.gnss);
    scale_h_infinity(engine, parameters, status_.since_fix(imu_.time()));
    if constexpr (requires { engine.apply_coarsely(measured); }) {
        if (engine.is_coarse()) {
            correct_coarsely(engine, measured);
            return;
        }
    }
    double blamed = 1.0;
    auto innovation = engine.innovate(seen, measured);
    auto correction = engine.corrector.correct(engine.estimator.covariance, innovation);
    if (innovation.channels() > 0 && engine.corrector.out_of_patience()) {
        const double alpha = reconcile(engine, seen, measured);
        innovation = engine.innovate(seen, measured);
        correction = engine.corrector.correct(engine.estimator.covariance, innovation);
        blamed = alpha;
    }
    publish_innovation<Where>(outputs, innovation);
    if (!correction.used()) {
        reject_fix(reason_of_refusal(engine.corrector.gate, innovation));
        return;
    }
    const Change change = engine.apply(correction);
    if (!change.finite) {
        fault("the correction is not finite");
        return;
    }
    status_.use_fix(imu_.time());
    const auto used = as_used(innovation, correction);
    nis_window_.add(imu_.time(), nis(used), used.channels());
    correction.alpha *= blamed;
    const bool robust = parameters.corrector == decltype(parameters.corrector)::h_infinity;
    publish_correction<Where>(outputs, correction, robust);
    if (!correction.feasible) {
        report_infeasible();
    }

    history_.turn(change.rotation, travelled_);
    history_.shift(change.velocity, change.displacement);

    if constexpr (!E::kFindsPosition) {  // and perhaps the vertical velocity is no state either
        const bool climbs = Where::velocity.count == 3;
        const Eigen::Vector3d climb(0.0, 0.0, climbs ? 0.0 : fix.velocity.z() - then.velocity.z());
        const Eigen::Vector3d displacement = earth::displacement(then.position, fix.position);
        engine.move(climb, displacement);
        history_.shift(climb, displacement);
    }
}

template <class Interface, class... Engines>
template <class E, class Fix>
void InertialFilter<Interface, Engines...>::correct_coarsely(E& engine, const Fix& fix) {
    if (!engine.awaits_fix()) {
        return;
    }
    const Change change = engine.apply_coarsely(fix);
    if (!change.finite) {
        fault("the coarse alignment is not finite");
        return;
    }
    status_.use_fix(imu_.time());
    ++outputs.used_fixes;
    publish_no_innovation(outputs);
    history_.turn(change.rotation, travelled_);
    history_.shift(change.velocity, change.displacement);
    if (!engine.is_coarse() && log_->listens()) {
        log_->event(
            text("coarse stage ends at ", imu_.time(), " s after ", outputs.used_fixes,
                 " fixes, which the filter has taken again from the first, as far as its gate admits them"));
    }
}

// The gate has refused so many fixes in a row that the prediction is blamed: by as much as lets this one
// pass. Returns the factor; 1, and nothing is changed, if none helps.
template <class Interface, class... Engines>
template <class E, class Fix>
double InertialFilter<Interface, Engines...>::reconcile(E& engine, const Sighting& seen, const Fix& fix) {
    const auto before = engine.estimator.covariance;
    const double smallest = engine.corrector.adaptive_factor.smallest(before);
    double alpha = engine.corrector.adaptive_factor.alpha(before, engine.innovate(seen, fix));
    while (alpha >= smallest) {
        engine.blame(alpha);
        if (engine.corrector.gate.admits(engine.innovate(seen, fix))) {
            if (log_->listens()) {
                log_->event(text("the gate refused ", parameters.gate.patience, " fixes in a row until ",
                                 imu_.time(), " s (gate.patience): the prediction is blamed, its variances, ",
                                 "those of the sensor errors excepted, divided by ", alpha));
            }
            return alpha;
        }
        engine.estimator.covariance = before;
        alpha /= 2.0;
    }
    return 1.0;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::report_infeasible() {
    if (log_->listens()) {
        log_->event(text("H-infinity update at ", imu_.time(), " s: robust.gamma = ", parameters.robust.gamma,
                         " is infeasible; a standard update took its place"));
    }
}

}  // namespace truenorth
