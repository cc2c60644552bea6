// The run loop of inertial_filter.hpp.
#pragma once

#include <algorithm>

#include "contract/text.hpp"
#include "contract/time_tolerance.hpp"
#include "filter/filter_settings.hpp"
#include "filter/inertial_filter.hpp"

namespace truenorth {

inline constexpr double kLeastSigma = 1e-6;  // better is no sensor, and no number [m/s], [rad], [m]

// Over longer increments the two-sample compensation of coning and sculling loses what a swaying vehicle does
// in between: 2 s on a ship that rolls in 8 s make a heading RMSE of 17 arcmin one of 70.
inline constexpr double kLongestGoodInterval = 1.0;  // [s]

// Where a vehicle that was last seen at a velocity [m/s] may be after `gap` [s] without increments.
inline Uncertainty travelled_unseen(double gap, const Eigen::Vector3d& velocity) {
    constexpr double kAcceleration = 1.0;  // of a vehicle, over more than a few seconds [m/s2]
    constexpr double kFastest = 100.0;     // [m/s]
    constexpr double kFarthest = 1e6;      // [m]
    constexpr double kHighest = 1e3;       // [m]
    const double speed = std::min(kAcceleration * gap, kFastest);
    const double way = std::min(gap * (velocity.norm() + speed), kFarthest);
    const Eigen::Vector3d place(way, way, std::min(way, kHighest));
    return {.velocity = speed * speed * Eigen::Matrix3d::Identity(),
            .position = place.cwiseAbs2().asDiagonal()};
}

// By how much increments of `dt` [s] that may be off by `angle` [rad] and `velocity` [m/s], body axes, leave
// a filter more uncertain. An attitude that goes astray over that time takes gravity for an acceleration in
// the mean by half of what it is off in the end.
inline Uncertainty left_out(const Eigen::Quaterniond& q_bn, const Eigen::Vector3d& angle,
                            const Eigen::Vector3d& velocity, double dt) {
    constexpr double kGravity = 9.8;  // [m/s2]
    const Eigen::Matrix3d C_bn = q_bn.toRotationMatrix();
    const auto turned = [&C_bn](const Eigen::Vector3d& sigma) -> Eigen::Matrix3d {
        return C_bn * sigma.cwiseAbs2().asDiagonal() * C_bn.transpose();
    };
    const Eigen::Matrix3d attitude = turned(angle);
    const double fallen = 0.5 * kGravity * dt;  // [m/s]
    const Eigen::Vector3d astray = fallen * fallen * Eigen::Vector3d(attitude(1, 1), attitude(0, 0), 0.0);
    const Eigen::Matrix3d variance = turned(velocity) + Eigen::Matrix3d(astray.asDiagonal());
    return {.attitude = attitude, .velocity = variance, .position = 0.25 * dt * dt * variance};
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::check() const {
    Interface::validate(parameters);
    check_settings(parameters);
    std::visit([this]<class E>(const E&) { E::Where::check(parameters); }, engine_);
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::choose_model() {
    const auto choose = [this]<class E> {
        if (E::Where::is_chosen(parameters)) {
            engine_.template emplace<E>();
        }
    };
    (choose.template operator()<Engines>(), ...);
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::configure_engine() {
    std::visit([this](auto& engine) { configure(engine, parameters); }, engine_);
    nis_window_.length = parameters.consistency.window;
    aids_.each([this](auto, AidMemory& memory) { memory.window.length = parameters.consistency.window; });
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::tell_what_has_no_effect() const {
    const auto tell = [this](const char* name, double value) {
        if (value > 0.0 && log_->listens()) {
            log_->event(text(name, " = ", value, " has no effect: the error model has no such noise"));
        }
    };
    std::visit([&]<class E>(
                   const E&) { each_without_effect<decltype(E::estimator.model)>(parameters.process, tell); },
               engine_);
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::prepare(double start_time) {
    choose_model();
    check();
    imu_.start(start_time);
    gnss_.start();
    status_.start(start_time);
    clock_ = start_time;
    gnss_used_ = start_time;
    aids_ = {};
    aids_.each([start_time](auto, AidMemory& memory) { memory.start(start_time); });
    standstill_.start();
    told_samples_ = {};
    told_fixes_ = {};
    told_notices_ = {};
    configure_engine();
    tell_what_has_no_effect();
    under_way_ = false;
    learned_ = true;
    told_long_interval_ = false;
    outputs = {};
    outputs.robust.feasible = true;
    outputs.adaptive.alpha = 1.0;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::set_out(const Start& start) {
    learned_ = true;
    std::visit(
        [&](auto& engine) {
            engine.start(start);
            open_ledger(engine);
        },
        engine_);
    travelled_ = IntervalAverage{};
    history_ = AntennaHistory{};
    history_.push(antenna());
    give_up_waiting();
    finder_.start();
    leveller_.start();
    nis_window_.restart();
    recovery_.start();
    status_.start(clock_);  // which may be long after that of the component
    forgetting_ = 0.0;
    last_fix_ = imu_.time();
    gnss_used_ = clock_;
    gnss_every_ = 0.0;
    gnss_heard_ = clock_;
    astray_ = 0.0;
    astray_at_ = clock_;
    aids_.each([this](auto, AidMemory& memory) { memory.start(clock_); });
    standstill_.start();
    placed_ = std::numeric_limits<double>::infinity();
    was_sure_ = false;
    under_way_ = true;
}

template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::open_ledger(const E& engine) {
    constexpr int attitude = E::Where::attitude.first;
    ledger_.open(engine.covariance().diagonal().template segment<3>(attitude));
    opened_ = imu_.time();
    leaned_ = imu_.time();
}

// It is no better known than after a fault.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::doubt_attitude(E& engine) {
    if (!engine.is_coarse()) {  // which knows nothing of it as it is
        const Eigen::Vector3d sigma(Recovery::kTilt, Recovery::kTilt, Recovery::kHeading);
        engine.add_uncertainty({.attitude = sigma.cwiseAbs2().asDiagonal()});
    }
    open_ledger(engine);
    was_sure_ = false;
}

// What was learned of the aids was learned from an attitude that is in doubt.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::doubt_sensors(E& engine) {
    engine.estimator.appended.start();
    aids_.each([](auto, AidMemory& memory) { memory.forgive(); });
}

// Whether no fix has been used of late, as often as they come.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::alone() const {
    return clock_ - gnss_used_ > wait_for_fix();
}

// After which there are no fixes [s].
template <class Interface, class... Engines>
double InertialFilter<Interface, Engines...>::wait_for_fix() const {
    constexpr double kSeldom = 60.0;  // fixes that come less often are none [s]
    return std::max(parameters.coasting.delay, 3.0 * std::min(gnss_every_, kSeldom));
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::retune() {
    check();
    configure_engine();
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::advance(double time, double step) {
    clock_ = std::max(clock_, time + step);
    const ImuPort imu = imu_port(time);
    if (!under_way_ || status_.faulted()) {
        const bool fix = watch(imu);
        tell_what_is_missing();
        if (under_way_ && fix) {
            start_over();
        }
        publish();
        return;
    }
    const bool sampled = take_sample(imu);
    bool measured = false;
    if (!status_.faulted()) {
        measured = take_fix();
        measured = take_aids(sampled) || measured;
    }
    learned_ = learned_ || measured;
    tell_what_is_missing();
    const double pending = std::visit([](const auto& engine) { return engine.pending(); }, engine_);
    if (!status_.faulted() && pending > parameters.filter.interval - kTimeTolerance) {
        predict();
    }
    if (!sampled && !measured) {
        publish_health();
        return;
    }
    publish_if_possible();
}

// What the IMU put out by a step that begins at `time` [s].
template <class Interface, class... Engines>
auto InertialFilter<Interface, Engines...>::imu_port(double time) const -> ImuPort {
    ImuPort port = inputs.imu;
    if (parameters.imu.each_step) {
        port.sample = 0;
        port.time = time;
    }
    return port;
}

// Whether a sound fix came, from which, and from what the outputs still tell, a filter could set out.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::watch(const ImuPort& port) {
    const auto sample = imu_.read(port.sample, port.time, port.delta_angle, port.delta_velocity, clock_);
    if (sample == ImuInput::Verdict::rejected) {
        tell_of(sample, port);
    }
    const auto verdict =
        gnss_.read(inputs.gnss.sample, fix_at(inputs.gnss), moment(imu_.increment().dt), 0.0, uncounted());
    if (verdict == GnssInput::Verdict::accepted) {
        return filled(fix_at(inputs.gnss)).complete();
    }
    if (verdict != GnssInput::Verdict::stale) {
        reject_fix(refusal_of(verdict), inputs.gnss);
    }
    return false;
}

// What a fix does not measure, as the outputs have it.
template <class Interface, class... Engines>
GnssFix InertialFilter<Interface, Engines...>::filled(const GnssFix& fix) const {
    const auto& nav = outputs.nav;
    return fix.filled_from({.latitude = nav.latitude, .longitude = nav.longitude, .height = nav.height},
                           nav.velocity);
}

// After a fault nothing of the estimate can be used but, perhaps, its last attitude, and what a fix does not
// have.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::start_over() {
    const auto& nav = outputs.nav;
    const bool known = std::isfinite(nav.roll) && std::isfinite(nav.pitch) && std::isfinite(nav.heading);
    const EulerAngles level{.roll = 0.0, .pitch = 0.0, .heading = 0.0};
    const EulerAngles last{.roll = nav.roll, .pitch = nav.pitch, .heading = nav.heading};
    const GnssFix fix = filled(fix_at(inputs.gnss));
    set_out({.state = {.q_bn = Eigen::Quaterniond(dcm(known ? last : level)),
                       .velocity = fix.velocity,
                       .position = fix.position}});
    std::visit([this](auto& engine) { this->doubt_attitude(engine); }, engine_);
    if (log_->listens()) {
        log_->event(text("estimation starts over at ", rounded(clock_), " s, from the fix that came"));
    }
}

// When a stamp is read, if the next sample of the IMU comes so much later [s].
template <class Interface, class... Engines>
StampClock::Moment InertialFilter<Interface, Engines...>::moment(double slack) const {
    return {.now = imu_.time() + imu_.silent_for(),
            .offset = imu_.offset(),
            .slack = slack,
            .oldest = history_.oldest()};
}

// Whether there was one.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::take_sample(const ImuPort& port) {
    const bool had_fixes = imu_.time() - last_fix_ <= wait_for_fix();

    const auto verdict = imu_.read(port.sample, port.time, port.delta_angle, port.delta_velocity, clock_);
    if (verdict == ImuInput::Verdict::stale) {
        return false;
    }
    tell_of(verdict, port);
    if (verdict == ImuInput::Verdict::rejected) {
        return true;
    }
    // The first sample of all goes on from where the filter was told to be, whatever its stamp, unless it has
    // been long in coming.
    const bool was_blind = verdict == ImuInput::Verdict::resumed && imu_.blind_for() > 0.0;
    warn_of_long_interval();
    if (verdict == ImuInput::Verdict::resumed || imu_.bridged() > kLongestGoodInterval) {
        give_up_waiting();  // what came in a long gap is nowhere near what is known of it
    }
    const Prediction prediction = std::visit(
        [&](auto& engine) {
            if (was_blind) {
                learned_ = true;
                engine.forget(had_fixes);
                if (!engine.is_coarse()) {
                    const Eigen::Vector3d& velocity = engine.mechanisation().state.velocity;
                    engine.add_uncertainty(travelled_unseen(imu_.blind_for(), velocity));
                }
                doubt_attitude(engine);
            }
            if (verdict == ImuInput::Verdict::resumed) {
                open_ledger(engine);
                nis_window_.restart();
                history_ = AntennaHistory{};
                finder_.start();
                leveller_.start();
                forgetting_ = 0.0;
                last_fix_ = imu_.time();
            }
            const NavigationState before = engine.mechanisation().state;
            Prediction outcome = engine.mechanise(imu_.increment());
            if (!imu_.doubtful_angle().isZero(0.0) || !imu_.doubtful_velocity().isZero(0.0)) {
                // What the increments left out is off at their end, and not from where a prediction still to
                // come would begin.
                if (engine.pending() > 0.0) {
                    outcome = std::max(outcome, engine.predict());
                }
                learned_ = true;
                const Uncertainty more = left_out(engine.mechanisation().state.q_bn, imu_.doubtful_angle(),
                                                  imu_.doubtful_velocity(), imu_.increment().dt);
                engine.add_uncertainty(more);
                ledger_.doubt(more.attitude.diagonal());
            }
            travelled_.add(before, engine.mechanisation(), imu_.increment().dt);
            return outcome;
        },
        engine_);
    history_.push(antenna());
    report(prediction);
    return true;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::tell_of(ImuInput::Verdict verdict, const ImuPort& port) {
    if (!log_->listens()) {
        return;
    }
    if (verdict == ImuInput::Verdict::resumed && imu_.blind_for() > 0.0) {
        log_->event(text("IMU data resume at imu.time = ", port.time,
                         " s after a gap that cannot be bridged; the estimate starts again"));
    }
    const auto finding = imu_.finding();
    if (finding != ImuInput::Finding::none) {
        if (const auto omitted = told_samples_.tell(finding, clock_)) {
            const bool rejected = verdict == ImuInput::Verdict::rejected;
            log_->event(text("IMU sample ", port.sample, " (imu.time = ", port.time, " s) ",
                             rejected ? "rejected: " : "is suspect: ", reason(finding),
                             and_others(*omitted).c_str()));
        }
    }
    if (verdict != ImuInput::Verdict::rejected && imu_.gap() > 0) {
        if (const auto omitted = told_notices_.tell(Notice::gap, clock_)) {
            log_->event(text(imu_.gap(), " IMU sample(s) missed before imu.time = ", port.time, " s; bridged",
                             and_others(*omitted).c_str()));
        }
    }
}

// What is not connected, as far as that shows; once of each port.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::tell_what_is_missing() {
    constexpr double kPatience = 1.0;           // [s]
    constexpr double kPatienceForFixes = 10.0;  // [s]
    if (!log_->listens()) {
        return;
    }
    const auto tell = [this](Arrival& arrival, const char* port) {
        if (arrival.by_stamps() && arrival.tell()) {
            log_->event(text(port, ".sample stays 0: a new ", port, ".time counts as a new measurement"));
        }
    };
    if (!parameters.imu.each_step) {
        tell(imu_.arrival(), "imu");
    }
    tell(gnss_.arrival(), "gnss");
    aids_.each([&]<class Aid>(std::type_identity<Aid>, AidMemory& memory) {
        if constexpr (Aid::kHasPort) {
            tell(memory.arrival, Aid::kName);
        }
    });
    if (!imu_.arrival().any() && imu_.silent_for() > kPatience && imu_.arrival().tell()) {
        log_->event(text("neither imu.sample nor imu.time has changed for ", kPatience,
                         " s: no IMU data are taken until one does; connect one, or set imu.each_step"));
    }
    if (!gnss_.arrival().any() && outputs.status == Interface::Status::waiting &&
        clock_ - gnss_used_ > kPatienceForFixes && gnss_.arrival().tell()) {
        log_->event(text(uncounted() ? "neither gnss.sample nor gnss.time has changed for "
                                     : "gnss.sample has not changed for ",
                         kPatienceForFixes, " s: no fix has come"));
    }
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::warn_of_long_interval() {
    const double interval = imu_.increment().dt;
    if (told_long_interval_ || imu_.bridged() > 0.0 || interval <= kLongestGoodInterval + kTimeTolerance) {
        return;
    }
    told_long_interval_ = true;
    if (log_->listens()) {
        log_->event(text("the increment that ends at imu.time = ", imu_.time(), " s covers ", interval,
                         " s: a vehicle that moves is followed well over at most ", kLongestGoodInterval,
                         " s; take shorter communication steps"));
    }
}

template <class Interface, class... Engines>
AntennaState InertialFilter<Interface, Engines...>::antenna() const {
    return std::visit(
        [this]<class E>(const E& engine) {
            const Mechanisation& mechanisation = engine.mechanisation();
            const Eigen::Vector3d& lever_arm = parameters.gnss.lever_arm;
            const Eigen::Vector3d& omega_eb_b = mechanisation.omega_eb_b();
            // A model that finds the position is told the error of the mechanised one. Any other has the
            // position taken from the fix, as it is; but of the lever velocity every model knows the error,
            // which therefore is that of the mechanised attitude.
            const NavigationState& there = E::kFindsPosition ? mechanisation.state : engine.best();
            const Eigen::Vector3d lever_velocity = mechanisation.state.q_bn * omega_eb_b.cross(lever_arm);
            return AntennaState{.time = imu_.time(),
                                .position = point_position(there, lever_arm),
                                .velocity = mechanisation.state.velocity + lever_velocity,
                                .lever_velocity = lever_velocity,
                                .q_bn = mechanisation.state.q_bn,
                                .omega_eb_b = omega_eb_b,
                                .travelled = travelled_};
        },
        engine_);
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::predict() {
    learned_ = true;
    report(std::visit(
        [](auto& engine) { return engine.pending() > 0.0 ? engine.predict() : Prediction::sound; }, engine_));
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::report(Prediction prediction) {
    switch (prediction) {
        case Prediction::sound:
            break;
        case Prediction::repaired:
            if (log_->listens()) {
                if (const auto omitted = told_notices_.tell(Notice::repaired, clock_)) {
                    log_->event(text("covariance was not positive definite at ", imu_.time(),
                                     " s and was repaired", and_others(*omitted).c_str()));
                }
            }
            break;
        case Prediction::failed:
            fault("the prediction is not finite");
            break;
    }
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::fault(const char* reason) {
    status_.fault();
    if (!log_->listens()) {
        return;
    }
    if (const auto omitted = told_notices_.tell(Notice::faulted, clock_)) {
        log_->event(
            text("estimation stopped at ", imu_.time(), " s: ", reason, and_others(*omitted).c_str()));
    }
}

}  // namespace truenorth
