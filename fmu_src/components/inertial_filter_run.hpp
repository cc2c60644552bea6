// The run loop of inertial_filter.hpp.
#pragma once

#include <type_traits>

#include "components/filter_outputs.hpp"
#include "components/filter_settings.hpp"
#include "components/inertial_filter.hpp"
#include "components/text.hpp"
#include "components/time_tolerance.hpp"

namespace truenorth {

// Over longer increments the two-sample compensation of coning and sculling loses what a swaying vehicle does
// in between: 2 s on a ship that rolls in 8 s make a heading RMSE of 17 arcmin one of 70.
inline constexpr double kLongestGoodInterval = 1.0;  // [s]

// So many fixes in a row beyond what their covariance explains are no outliers: of a consistent filter one in
// 3000 is beyond gate.threshold, of a receiver in a bad place one in twenty.
inline constexpr int kContradictions = 5;

// Finite, and where and as fast as a fix may be, with something to spare.
inline bool possible(const NavigationState& state) {
    return state.finite() && state.velocity.norm() < 2.0 * GnssInput::kLargestSpeed &&
           state.position.height > 2.0 * GnssInput::kLowest &&
           state.position.height < 2.0 * GnssInput::kHighest;
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
    for (NisWindow* window :
         {&nis_window_, &body_velocity_.window, &heading_aid_.window, &height_aid_.window}) {
        window->length = parameters.consistency.window;
    }
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
    for (AidMemory* memory : {&body_velocity_, &heading_aid_, &height_aid_}) {
        *memory = {};
        memory->start(start_time);
    }
    told_samples_ = {};
    told_fixes_ = {};
    told_notices_ = {};
    configure_engine();
    under_way_ = false;
    told_long_interval_ = false;
    outputs = {};
    outputs.robust.feasible = true;
    outputs.adaptive.alpha = 1.0;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::set_out(const Start& start) {
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
    gnss_heard_ = clock_;
    astray_ = 0.0;
    astray_at_ = clock_;
    for (AidMemory* memory : {&body_velocity_, &heading_aid_, &height_aid_}) {
        memory->start(clock_);
    }
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

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::retune() {
    check();
    configure_engine();
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::advance(double clock) {
    clock_ = std::max(clock_, clock);
    if (!under_way_ || status_.faulted()) {
        const bool fix = watch();
        if (under_way_ && fix) {
            start_over();
        }
        publish();
        return;
    }
    bool anything_new = take_sample();
    if (!status_.faulted()) {
        anything_new = take_fix() || anything_new;
        anything_new = take_aids() || anything_new;
    }
    const double pending = std::visit([](const auto& engine) { return engine.pending(); }, engine_);
    if (!status_.faulted() && pending > parameters.filter.interval - kTimeTolerance) {
        predict();
    }
    if (!anything_new) {
        publish_health();
        return;
    }
    if (!status_.faulted() &&
        !std::visit([](const auto& engine) { return possible(engine.best()); }, engine_)) {
        fault("the navigation state is not finite, or nowhere near the Earth");
    }
    publish();
}

// Whether a sound fix came, from which, and from what the outputs still tell, a filter could set out.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::watch() {
    const auto& imu = inputs.imu;
    const auto sample = imu_.read(imu.sample, imu.time, imu.delta_angle, imu.delta_velocity, clock_);
    if (sample == ImuInput::Verdict::rejected) {
        tell_of(sample);
    }
    const auto verdict =
        gnss_.read(inputs.gnss.sample, fix_at(inputs.gnss), {.now = imu_.time(), .offset = imu_.offset()});
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
    const Eigen::Vector3d sigma(Recovery::kTilt, Recovery::kTilt, Recovery::kHeading);
    std::visit(
        [&](auto& engine) {
            engine.add_uncertainty({.attitude = sigma.cwiseAbs2().asDiagonal()});
            open_ledger(engine);
        },
        engine_);
    if (log_->listens()) {
        log_->event(text("estimation starts over at ", rounded(clock_), " s, from the fix that came"));
    }
}

// Whether there was one.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::take_sample() {
    const auto& port = inputs.imu;
    const auto verdict = imu_.read(port.sample, port.time, port.delta_angle, port.delta_velocity, clock_);
    if (verdict == ImuInput::Verdict::stale) {
        return false;
    }
    tell_of(verdict);
    if (verdict == ImuInput::Verdict::rejected) {
        return true;
    }
    warn_of_long_interval();
    const bool long_gap = imu_.gap() > 0 && imu_.increment().dt > kLongestGoodInterval;
    if (verdict == ImuInput::Verdict::resumed || long_gap) {
        give_up_waiting();  // what came in a long gap is nowhere near what is known of it
    }
    const Prediction prediction = std::visit(
        [&](auto& engine) {
            if (verdict == ImuInput::Verdict::resumed) {
                engine.forget();
                open_ledger(engine);
                nis_window_.restart();
                history_ = AntennaHistory{};
                finder_.start();
                leveller_.start();
                forgetting_ = 0.0;
            }
            const NavigationState before = engine.mechanisation().state;
            const Prediction outcome = engine.mechanise(imu_.increment());
            if (!imu_.doubtful_angle().isZero(0.0) || !imu_.doubtful_velocity().isZero(0.0)) {
                const Eigen::Matrix3d C_bn = engine.mechanisation().state.q_bn.toRotationMatrix();
                const auto turned = [&C_bn](const Eigen::Vector3d& sigma) -> Eigen::Matrix3d {
                    return C_bn * sigma.cwiseAbs2().asDiagonal() * C_bn.transpose();
                };
                Uncertainty more{.attitude = turned(imu_.doubtful_angle()),
                                 .velocity = turned(imu_.doubtful_velocity())};
                if (engine.pending() <= 0.0) {  // or the prediction to come will carry it to the position
                    more.position = turned(0.5 * imu_.increment().dt * imu_.doubtful_velocity());
                }
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
void InertialFilter<Interface, Engines...>::tell_of(ImuInput::Verdict verdict) {
    if (!log_->listens()) {
        return;
    }
    const auto& port = inputs.imu;
    if (verdict == ImuInput::Verdict::resumed) {
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

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::warn_of_long_interval() {
    const double interval = imu_.increment().dt;
    if (told_long_interval_ || imu_.gap() > 0 || interval <= kLongestGoodInterval + kTimeTolerance) {
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
    if (log_->listens()) {
        log_->event(text("estimation stopped at ", imu_.time(), " s: ", reason));
    }
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish() {
    if (!status_.faulted()) {
        std::visit(
            [this](const auto& engine) { publish_estimate(outputs, engine, imu_.stamp(), parameters); },
            engine_);
    }
    publish_health();
}

// What the clock alone can change.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish_health() {
    outputs.rejected_samples = imu_.rejected();
    outputs.missed_samples = imu_.missed();
    outputs.imu.silent_for = imu_.silent_for();
    outputs.clock_disagreements = imu_.disagreements() + gnss_.disagreements();
    outputs.nis_mean = nis_window_.mean(imu_.time());
    auto& gnss = outputs.aid.gnss;
    gnss.nis_mean = outputs.nis_mean;
    gnss.used = outputs.used_fixes;
    gnss.rejected = outputs.rejected_fixes;
    gnss.silent_for = clock_ - gnss_used_;
    auto& aid = outputs.aid;
    const Appended& sensors =
        std::visit([](const auto& engine) -> const Appended& { return engine.estimator.appended; }, engine_);
    publish_errors_of_sensors(aid, sensors);
    publish_health_of(aid.body_velocity, body_velocity_, imu_.time(), clock_);
    publish_health_of(aid.heading_aid, heading_aid_, imu_.time(), clock_);
    publish_health_of(aid.height_aid, height_aid_, imu_.time(), clock_);
    publish_status();
}

// What the filter is told of the gyros.
template <class Interface, class... Engines>
AttitudeLedger::Gyros InertialFilter<Interface, Engines...>::gyros() const {
    const auto& process = parameters.process;
    AttitudeLedger::Gyros gyros{.bias = parameters.prior.gyro_bias_sigma,
                                .random_walk = process.angle_random_walk};
    if constexpr (requires { process.gyro_markov_sigma; }) {
        gyros.bias = std::hypot(gyros.bias, process.gyro_markov_sigma);
    }
    if constexpr (requires { process.gyro_bias_random_walk; }) {
        gyros.bias_random_walk = process.gyro_bias_random_walk;
    }
    return gyros;
}

// What speaks against the covariance.
template <class Interface, class... Engines>
Contradiction InertialFilter<Interface, Engines...>::contradiction() const {
    const int in_a_row =
        std::visit([](const auto& engine) { return engine.corrector.contradictions(); }, engine_);
    const double limit = parameters.consistency.limit;
    if (in_a_row >= kContradictions && clock_ - gnss_heard_ <= parameters.consistency.window) {
        return Contradiction::fixes;
    }
    if (!(nis_window_.deviate(imu_.time()) <= limit)) {  // nor is what is no number
        return Contradiction::innovations;
    }
    const Appended& sensors =
        std::visit([](const auto& engine) -> const Appended& { return engine.estimator.appended; }, engine_);
    const auto contradicts = [&]<class Aid>(const AidMemory& memory, std::type_identity<Aid>) {
        return memory.heard_of_late(clock_) &&
               (memory.contradictions() >= kContradictions ||
                !(memory.window.deviate(imu_.time()) <= limit) || !(memory.mean.deviate() <= limit) ||
                !(sensors.deviate(Aid::kOwn, Aid::kOwnCount) <= limit));
    };
    if (contradicts(body_velocity_, std::type_identity<BodyVelocityAid>{}) ||
        contradicts(heading_aid_, std::type_identity<HeadingAid>{}) ||
        contradicts(height_aid_, std::type_identity<HeightAid>{})) {
        return Contradiction::aids;
    }
    const bool explained = ledger_.deviate(imu_.time() - opened_, gyros()) <= limit;
    return explained ? Contradiction::none : Contradiction::start;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish_status() {
    const bool coarse = std::visit([](const auto& engine) { return engine.is_coarse(); }, engine_);
    const double delay = parameters.coasting.delay;
    const Contradiction against = contradiction();
    const auto state = status_.judge(clock_,
                                     {.sensing = imu_.any(),
                                      .silent = imu_.silent_for() > imu_.patience() + kTimeTolerance,
                                      .suspect = clock_ - imu_.suspected() < delay - kTimeTolerance,
                                      .coarse = coarse,
                                      .recovering = recovery_.under_way(clock_),
                                      .consistent = against == Contradiction::none,
                                      .heading_sigma = outputs.heading_sigma},
                                     {.heading_sigma = parameters.convergence.heading_sigma,
                                      .hold_time = parameters.convergence.hold_time,
                                      .coasting_delay = delay});
    using State = FilterStatus::State;
    using Status = typename Interface::Status;
    constexpr auto same = [](Status status, State internal) {
        return static_cast<State>(status) == internal;
    };
    static_assert(same(Status::waiting, State::waiting) && same(Status::aligning, State::aligning) &&
                  same(Status::converged, State::converged) && same(Status::coasting, State::coasting) &&
                  same(Status::faulted, State::faulted) && same(Status::coarse, State::coarse) &&
                  same(Status::inconsistent, State::inconsistent) && same(Status::silent, State::silent) &&
                  same(Status::suspect, State::suspect) && same(Status::recovering, State::recovering));
    const auto was = static_cast<State>(outputs.status);
    outputs.status = static_cast<Status>(state);
    outputs.converged = state == State::converged;
    was_sure_ = was_sure_ || outputs.converged;
    if (state == was || !log_->listens()) {
        return;
    }
    if (state == State::inconsistent) {
        log_->event(text("the covariance is contradicted at ", rounded(clock_), " s: ", reason(against),
                         "; nis_mean is ", rounded(outputs.nis_mean)));
    }
    if (state == State::silent) {
        log_->event(text("no usable IMU sample since ", rounded(clock_ - imu_.silent_for()),
                         " s by the master's clock: the estimate stands still"));
    }
    if (outputs.converged || was == State::converged) {
        log_->event(
            text(outputs.converged ? "converged" : "no longer converged", " at ", rounded(clock_), " s"));
    }
}

}  // namespace truenorth
