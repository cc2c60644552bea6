// What inertial_filter.hpp does with a fix.
#pragma once

#include "filter/filter_outputs.hpp"
#include "filter/inertial_filter_run.hpp"
#include "inertial/attitude.hpp"

namespace truenorth {

// A first fix farther than this from initial.* is a wrong initial position rather than an error of it.
inline constexpr double kFar = 10e3;  // [m]

// The innovation of a fix that does not measure everything, or says how well it does.
template <class Where, int N, int M>
void take_sigmas(Innovation<N, M>& innovation, const GnssFix::Mask& measured,
                 const GnssFix::Components& sigma) {
    for (int i = 0; i < M; ++i) {
        const int component = Where::component(i);
        if (!measured(component)) {
            innovation.remove(i);
        } else if (sigma(component) > 0.0) {
            innovation.noise(i, i) = sigma(component) * sigma(component);
        }
    }
}

// How far a fix is off, which perhaps only its channels tell.
template <class E, class Residual>
Discrepancy discrepancy_of(const E& /*engine*/, const Sighting& seen, const Residual& residual) {
    if constexpr (requires { E::Where::discrepancy(residual); }) {
        return E::Where::discrepancy(residual);
    }
    return {.position = earth::displacement(seen.fix.position, seen.then.position),
            .velocity = seen.then.velocity - seen.fix.velocity};
}

template <class Interface, class... Engines>
GnssFix InertialFilter<Interface, Engines...>::fix_at(const Port& port) {
    GnssFix fix{.time = port.time,
                .position = {.latitude = port.latitude, .longitude = port.longitude, .height = port.height},
                .velocity = port.velocity};
    fix.sigma << port.fix_position_sigma, port.fix_velocity_sigma;
    fix.sigma = (fix.sigma > 0.0).select(fix.sigma.max(kLeastSigma), fix.sigma).eval();
    if constexpr (requires { port.channel.valid; }) {
        fix.has_channels = std::ranges::any_of(port.channel.valid, [](bool valid) { return valid; });
    }
    return fix;
}

// Whether one came, or had waited long enough.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::take_fix() {
    const bool came = !gnss_.is_read(inputs.gnss.sample, uncounted()) && read_fix();
    bool due = false;
    while (!status_.faulted() && waiting_.due(imu_.time())) {
        const auto& entry = waiting_.pop();
        use(entry.port, entry.valid_at);
        due = true;
    }
    return came || due;
}

// Whether a new one lies at the port; a sound one waits from now on.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::read_fix() {
    const Port& port = inputs.gnss;
    const double speed = outputs.nav.velocity.norm();
    const auto verdict =
        gnss_.read(port.sample, fix_at(port), moment(imu_.increment().dt), speed, uncounted());
    if (verdict == GnssInput::Verdict::stale) {
        return false;
    }
    if (verdict != GnssInput::Verdict::accepted) {
        reject_fix(refusal_of(verdict), port);
        return true;
    }
    if (waiting_.full()) {
        reject_fix(Refusal::uncovered, waiting_.pop().port);
    }
    waiting_.push(port, gnss_.valid_at());
    return true;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::use(const Port& port, double valid_at) {
    const GnssFix came = fix_at(port);
    const auto then = history_.at(valid_at);
    if (!then) {
        reject_fix(Refusal::too_old, port);
        return;
    }
    const GnssFix fix = came.filled_from(then->position, then->velocity);
    const GnssFix::Mask measured = came.measured();
    gnss_heard_ = clock_;
    question_place(fix, *then);
    const bool takes_place = std::visit([]<class E>(const E&) { return !E::kFindsPosition; }, engine_);
    if (takes_place && (measured(0) || measured(1)) && !is_within_reach(fix, *then)) {
        reject_fix(Refusal::unreachable, port);
        return;
    }
    if (measured(3) && measured(4)) {
        const double told = fix.sigma.segment<2>(3).maxCoeff();
        finder_.add(*then, fix.velocity, told > 0.0 ? told : parameters.measurement.velocity_sigma);
    }
    predict();
    if (!status_.faulted()) {
        std::visit([&](auto& engine) { correct(engine, port, fix, measured, *then); }, engine_);
    }
}

// Of a model that takes the place of a fix as it is: whether it can have come there from that of the last
// one. In the first minute anywhere will do, for the first fixes may be wrong. Where the places stay the same
// for long, it has come there somehow, and nothing is known of what happened on the way.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::is_within_reach(const GnssFix& fix, const AntennaState& then) {
    constexpr double kFastest = 100.0;  // of a vehicle, beyond what is known of it [m/s]
    const double reach = kFar + (clock_ - gnss_used_) * (then.velocity.norm() + kFastest);
    const auto from = [&fix](const earth::Position& place) {
        return (earth::ecef(fix.position) - earth::ecef(place)).norm();
    };
    placed_ = std::min(placed_, clock_);
    if (clock_ - placed_ < Recovery::kCalm || from(then.position) <= reach) {
        far_place_ = fix.position;
        far_since_ = clock_;
        return true;
    }
    if (from(far_place_) > reach) {
        far_place_ = fix.position;
        far_since_ = clock_;
    }
    if (clock_ - far_since_ < Recovery::kCalm) {
        return false;
    }
    std::visit([this](auto& engine) { this->doubt_attitude(engine); }, engine_);
    recovery_.doubt(clock_);
    far_since_ = clock_;  // if the gate refuses it, after another minute again
    if (log_->listens()) {
        log_->event(text("fixes have been ", std::round(from(then.position) / 1e3), " km away for ",
                         Recovery::kCalm, " s: the filter takes their place, with its attitude in doubt"));
    }
    return true;
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
void InertialFilter<Interface, Engines...>::reject_fix(Refusal refusal, const Port& port) {
    ++outputs.rejected_fixes;
    outputs.measurement_weight.setZero();
    if (!log_->listens()) {
        return;
    }
    if (const auto omitted = told_fixes_.tell(refusal, clock_)) {
        log_->event(text("fix ", port.sample, " (gnss.time = ", port.time, " s) rejected: ", reason(refusal),
                         and_others(*omitted).c_str()));
    }
}

// The IMU data that would have covered them will not come.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::give_up_waiting() {
    while (waiting_.count() > 0) {
        reject_fix(Refusal::uncovered, waiting_.pop().port);
    }
}

template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::correct(E& engine, const Port& port, const GnssFix& fix,
                                                    const GnssFix::Mask& measured, const AntennaState& then) {
    using Where = typename E::Where;
    const Sighting seen{.fix = fix,
                        .then = then,
                        .now = antenna(),
                        .since = travelled_ - then.travelled,
                        .lever_arm = parameters.gnss.lever_arm};
    if constexpr (requires { engine.adapter.renewed(port, [](int) {}); }) {
        engine.adapter.renewed(port, [&](int i) { engine.corrector.restart(i); });
    }
    const auto model_fix = engine.adapter.fix_of(seen, port);
    scale(engine);
    const auto went_coarsely = [&] {
        if constexpr (requires { engine.apply_coarsely(model_fix); }) {
            if (engine.is_coarse()) {
                if (measured.all()) {
                    correct_coarsely(engine, model_fix, port);
                } else {
                    reject_fix(Refusal::incomplete, port);
                }
                return true;
            }
        }
        return false;
    };
    const auto innovate = [&] {
        auto innovation = engine.innovate(seen, model_fix);
        if constexpr (requires { Where::component(0); }) {
            take_sigmas<Where>(innovation, measured, fix.sigma);
        }
        return innovation;
    };
    engine.corrector.gate_stands_open = recovery_.open();
    engine.corrector.way_back = recovery_.on_ladder(clock_);
    engine.corrector.combined.interval = imu_.time() - last_fix_;
    engine.corrector.combined.may_blame = recovery_.may_doubt(clock_);
    engine.corrector.combined.sure = was_sure_;
    if (went_coarsely()) {
        return;
    }
    auto innovation = innovate();
    auto correction = engine.corrected(innovation);
    if (innovation.channels() > 0 && engine.corrector.out_of_patience()) {
        recover(engine, seen, innovation.residual);
        if (went_coarsely()) {
            return;
        }
        engine.corrector.gate_stands_open = true;
        innovation = innovate();
        correction = engine.corrected(innovation);
    } else if (const Cause cause = engine.corrector.cause();
               innovation.channels() > 0 && cause >= Cause::start) {
        blame(engine, cause, discrepancy_of(engine, seen, innovation.residual),
              correction.nis / innovation.channels());
        engine.corrector.gate_stands_open = true;
        innovation = innovate();
        correction = engine.corrected(innovation);
    }
    publish_innovation<Where>(outputs, innovation, correction.nis);
    if (!correction.used()) {
        reject_fix(refusal_of(engine.corrector.gate, correction.nis, innovation.channels()), port);
        return;
    }
    take(engine, correction, fix, measured, then);
}

// A correction by a fix.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::take(E& engine, const typename E::Correction& correction,
                                                 const GnssFix& fix, const GnssFix::Mask& measured,
                                                 const AntennaState& then) {
    using Where = typename E::Where;
    recovery_.pass(clock_);
    const Change change = engine.apply(correction);
    if (!change.finite) {
        fault("the correction is not finite");
        return;
    }
    // What a model of channels used, no component of the fix tells.
    note_use(requires { Where::component(0); } ? measured : GnssFix::Mask(GnssFix::Mask::Constant(true)));
    nis_window_.add(imu_.time(), correction.nis_used, correction.channels_used);
    const bool robust = parameters.corrector == decltype(parameters.corrector)::h_infinity;
    publish_correction<Where>(outputs, correction, robust);
    if (!correction.feasible) {
        report_infeasible();
    }

    follow(change);
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
void InertialFilter<Interface, Engines...>::correct_coarsely(E& engine, const Fix& fix, const Port& port) {
    if (!engine.awaits_fix()) {
        return;
    }
    const bool weighed = engine.weighs_headings();
    const std::optional<Change> taken = engine.apply_coarsely(fix);
    if (!taken) {
        reject_fix(Refusal::beyond_gate, port);
        return;
    }
    const Change& change = *taken;
    if (!change.finite) {
        fault("the coarse alignment is not finite");
        return;
    }
    note_use(GnssFix::Mask::Constant(true));
    ++outputs.used_fixes;
    publish_no_innovation(outputs);
    turn(change.rotation);
    history_.shift(change.velocity, change.displacement);
    if (!engine.is_coarse()) {
        open_ledger(engine);
    }
    if (engine.weighs_headings() && !weighed && log_->listens()) {
        log_->event(text("the heading cannot be told yet at ", imu_.time(), " s (sigma ",
                         std::round(engine.misalignment_sigma().z() * 180.0 / std::numbers::pi),
                         " deg): the coarse stage goes on with a filter for every heading"));
    }
    if (!engine.is_coarse() && log_->listens()) {
        log_->event(
            text("coarse stage ends at ", imu_.time(), " s after ", outputs.used_fixes,
                 " fixes, which the filter has taken again from the first, as far as its gate admits them"));
    }
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::note_use(const GnssFix::Mask& measured) {
    if (measured(0) || measured(1) || measured(3) || measured(4)) {  // a height alone binds nothing
        status_.use_fix(clock_);
        gnss_every_ = clock_ - gnss_used_;
        gnss_used_ = clock_;
        astray_ = 0.0;
        astray_at_ = clock_;
    }
    forgetting_ += imu_.time() - last_fix_;
    last_fix_ = imu_.time();
}

// L and the ceiling of the H-infinity update. What the update gives up is meant for an alignment that lasts
// robust.horizon; for longer it would, in time, give up everything that no fix renews. Where a ceiling bounds
// it, it may go on.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::scale(E& engine) {
    const double left = parameters.robust.horizon - forgetting_;
    scale_h_infinity(engine, parameters, std::min(imu_.time() - last_fix_, left));
}

// Fixes after which what is wrong of the start is no longer the position or the velocity.
inline constexpr double kSettled = 10.0;

// What a rung of the way back does.
inline const char* deed(int rung, bool heading_found, bool stays, bool keeps_heading) {
    if (rung < Recovery::kSensors) {
        return "position and velocity are taken from the next";
    }
    if (keeps_heading ? heading_found || rung >= Recovery::kRestart
                      : stays && !heading_found && rung == Recovery::kRestart) {
        return "and the filter starts again where it is, with any heading";
    }
    if (heading_found) {
        return "and the filter starts again, with the heading that changes of velocity tell";
    }
    if (rung < Recovery::kAttitude) {
        return "the sensors are in doubt with it";
    }
    if (rung < Recovery::kRestart) {
        return "attitude and sensors are in doubt with it";
    }
    return rung < Recovery::kLast ? "and the filter starts again from the next"
                                  : "and the filter starts again, with another heading";
}

// A correction has changed the estimate.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::follow(const Change& change) {
    const double latitude = outputs.nav.latitude;
    ledger_.lean(outputs.heading_sigma, earth::rate(latitude).y(), imu_.time() - leaned_);
    leaned_ = imu_.time();
    ledger_.turn(change.rotation);
    turn(change.rotation);
    history_.shift(change.velocity, change.displacement);
}

// The computed level frame has been turned: what is kept of the past turns with it.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::turn(const Eigen::Matrix3d& rotation) {
    history_.turn(rotation, travelled_);
    finder_.turn(rotation, travelled_);
    leveller_.turn_with_measured(rotation, travelled_);
}

// The corrector knows what the last fixes contradict, and the prediction becomes uncertain in that. A motion
// that no sensor measured is an acceleration since the last fix that was used, which goes on: where it is an
// error of the accelerometers, their biases follow it, and the attitude stays what it is. A start that was
// wrong was told too sure of everything alike (Li, eq. 16), of the attitude as of what the fix shows.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::blame(E& engine, Cause cause, const Discrepancy& off,
                                                  double mean_square) {
    Uncertainty more{.velocity = off.velocity.cwiseAbs2().asDiagonal()};
    if (cause == Cause::motion) {
        const double elapsed = std::max(imu_.time() - last_fix_, imu_.increment().dt);
        more.position = 0.25 * elapsed * elapsed * more.velocity;
        more.accelerometer = off.velocity.squaredNorm() / (elapsed * elapsed);
    } else {
        const Eigen::Vector3d widest(Recovery::kTilt, Recovery::kTilt, Recovery::kHeading);
        const Eigen::Vector3d variance = (mean_square - 1.0) * engine.misalignment_sigma().cwiseAbs2();
        more.position = off.position.cwiseAbs2().asDiagonal();
        more.attitude = variance.cwiseMin(widest.cwiseAbs2()).asDiagonal();
    }
    engine.add_uncertainty(more);
    if (cause == Cause::start) {  // the attitude sets out anew
        was_sure_ = false;
        const bool settled = imu_.time() - opened_ > kSettled * gnss_every_;
        open_ledger(engine);
        if (settled) {  // position and velocity were the fixes' already: it is the attitude that was wrong
            ledger_.guess();
        }
    }
    recovery_.doubt(clock_);
    if (log_->listens()) {
        if (const auto omitted = told_notices_.tell(Notice::blamed, clock_)) {
            log_->event(text("fixes until ", rounded(clock_), " s contradict the prediction: ", reason(cause),
                             and_others(*omitted).c_str()));
        }
    }
}

// What a new start proposes: a heading that is turned by this angle about up [rad], and of a model that does
// not go on from where it is, the position and velocity of the fix if it is `directed`.
template <class Interface, class... Engines>
template <class E>
Change InertialFilter<Interface, Engines...>::proposed(double angle, bool directed,
                                                       const Discrepancy& off) const {
    if constexpr (!E::kStartsWhereItIs) {
        const Eigen::Vector3d velocity = directed ? Eigen::Vector3d(-off.velocity) : Eigen::Vector3d::Zero();
        const Eigen::Vector3d place = directed ? Eigen::Vector3d(-off.position) : Eigen::Vector3d::Zero();
        return {.rotation = finder_.upright(angle), .velocity = velocity, .displacement = place};
    } else if constexpr (!E::kKeepsHeading) {
        return {.rotation = about_up(angle)};
    } else {
        return {};
    }
}

// Starts again at a fix, with the heading that changes of velocity tell, if they do, or with `another`.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::start_again_at_fix(E& engine, bool another, bool directed,
                                                               const Discrepancy& off) {
    constexpr double kUntold = E::kStartsWhereItIs ? Recovery::kAnyHeading : Recovery::kHeading;
    const bool found = finder_.tells();
    double angle = found ? finder_.angle() : 0.0;
    if (another && !found) {
        const NavigationState& now = E::kStartsWhereItIs ? engine.mechanisation().state : engine.best();
        angle = euler_angles(now.q_bn.toRotationMatrix()).heading - recovery_.next_heading();
    }
    const double sigma = found && !E::kKeepsHeading ? Recovery::kTilt + finder_.sigma() : kUntold;
    const Change change =
        engine.start_again(proposed<E>(angle, directed, off), {Recovery::kTilt, Recovery::kTilt, sigma}, off);
    turn(change.rotation);
    history_.shift(change.velocity, change.displacement);
}

// The gate has refused so many fixes in a row that something else than the fixes is to be blamed: what,
// recovery.hpp says.
template <class Interface, class... Engines>
template <class E, class Residual>
void InertialFilter<Interface, Engines...>::recover(E& engine, const Sighting& seen,
                                                    const Residual& residual) {
    const int rung = recovery_.climb(clock_, parameters.gate.patience, was_sure_);
    was_sure_ = was_sure_ && rung < Recovery::kAttitude;
    const bool found = finder_.tells();
    if (log_->listens()) {
        log_->event(text("the gate refused ", parameters.gate.patience, " fixes in a row until ",
                         rounded(clock_), " s (gate.patience): the prediction is blamed, ",
                         deed(rung, found, E::kStartsWhereItIs, E::kKeepsHeading)));
    }
    nis_window_.restart();
    engine.corrector.restart();
    forgetting_ = 0.0;

    Discrepancy off = discrepancy_of(engine, seen, residual);
    const bool directed = !requires { E::Where::discrepancy(residual); };
    const bool again = rung >= Recovery::kRestart || (rung >= Recovery::kSensors && found);
    if (again) {
        start_again_at_fix(engine, rung == Recovery::kLast, directed, off);
        const auto& measurement = parameters.measurement;
        const double place = std::max(measurement.position_sigma, measurement.height_sigma);
        off = {.position = Eigen::Vector3d::Constant(place),
               .velocity = Eigen::Vector3d::Constant(measurement.velocity_sigma)};
    }
    Uncertainty more{.velocity = off.velocity.cwiseAbs2().asDiagonal(),
                     .position = off.position.cwiseAbs2().asDiagonal()};
    const bool blame_attitude = !again && rung >= Recovery::kAttitude;
    if (blame_attitude) {
        const Eigen::Vector3d sigma(Recovery::kTilt, Recovery::kTilt, Recovery::kHeading);
        more.attitude = sigma.cwiseAbs2().asDiagonal();
    }
    more.sensors = !again && rung >= Recovery::kSensors ? 1.0 : 0.0;
    engine.add_uncertainty(more);
    if (again || rung >= Recovery::kAttitude) {
        doubt_sensors(engine);
    }
    if (rung >= Recovery::kSensors) {
        open_ledger(engine);
    }
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::report_infeasible() {
    if (!log_->listens()) {
        return;
    }
    if (const auto omitted = told_notices_.tell(Notice::infeasible, clock_)) {
        log_->event(text("H-infinity update at ", imu_.time(), " s: robust.gamma = ", parameters.robust.gamma,
                         " is infeasible; a standard update took its place", and_others(*omitted).c_str()));
    }
}

}  // namespace truenorth
