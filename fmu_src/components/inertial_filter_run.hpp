// The run loop of inertial_filter.hpp.
#pragma once

#include "components/filter_outputs.hpp"
#include "components/filter_settings.hpp"
#include "components/inertial_filter.hpp"
#include "components/text.hpp"
#include "components/time_tolerance.hpp"

namespace truenorth {

// Over longer increments the two-sample compensation of coning and sculling loses what a swaying vehicle does
// in between: 2 s on a ship that rolls in 8 s make a heading RMSE of 17 arcmin one of 70.
inline constexpr double kLongestGoodInterval = 1.0;  // [s]

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
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::prepare(double start_time) {
    choose_model();
    check();
    configure_engine();
    imu_.start(start_time);
    gnss_.start();
    status_.start(start_time);
    travelled_ = IntervalAverage{};
    history_ = AntennaHistory{};
    under_way_ = false;
    told_long_interval_ = false;
    outputs = {};
    outputs.robust.feasible = true;
    outputs.adaptive.alpha = 1.0;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::set_out(const Start& start) {
    std::visit([&](auto& engine) { engine.start(start); }, engine_);
    history_.push(antenna());
    nis_window_.restart();
    status_.start(imu_.time());  // which may be long after that of the component
    under_way_ = true;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::retune() {
    check();
    configure_engine();
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::advance() {
    if (!under_way_) {
        watch();
        publish();
        return;
    }
    if (!status_.faulted()) {
        take_sample();
    }
    if (!status_.faulted()) {
        take_fix();
    }
    const double pending = std::visit([](const auto& engine) { return engine.pending(); }, engine_);
    if (!status_.faulted() && pending > parameters.filter.interval - kTimeTolerance) {
        predict();
    }
    if (!status_.faulted() &&
        !std::visit([](const auto& engine) { return engine.best().finite(); }, engine_)) {
        fault("the navigation state is not finite");
    }
    publish();
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::watch() {
    const auto& imu = inputs.imu;
    imu_.read(imu.sample, imu.time, imu.delta_angle, imu.delta_velocity);
    gnss_.read(inputs.gnss.sample, fix_at_port(), imu_.time());
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::take_sample() {
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
                                 " s after a gap that cannot be bridged; the estimate starts again"));
            }
            break;
        case ImuInput::Verdict::accepted:
            break;
    }
    if (imu_.gap() > 0 && log_->listens()) {
        log_->event(text(imu_.gap(), " IMU sample(s) missed before imu.time = ", port.time,
                         " s; bridged with the mean rate of the next"));
    }
    warn_of_long_interval();
    const Prediction prediction = std::visit(
        [&](auto& engine) {
            if (verdict == ImuInput::Verdict::resumed) {
                engine.forget();
                nis_window_.restart();
                history_ = AntennaHistory{};
            }
            const NavigationState before = engine.mechanisation().state;
            const Prediction outcome = engine.mechanise(imu_.increment());
            engine.doubt(imu_.doubtful_angle(), imu_.doubtful_velocity());
            travelled_.add(before, engine.mechanisation(), imu_.increment().dt);
            return outcome;
        },
        engine_);
    history_.push(antenna());
    report(prediction);
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::warn_of_long_interval() {
    const double interval = imu_.increment().dt / (imu_.gap() + 1);
    if (told_long_interval_ || interval <= kLongestGoodInterval + kTimeTolerance) {
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
                log_->event(
                    text("covariance was not positive definite at ", imu_.time(), " s and was repaired"));
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
    outputs.rejected_samples = imu_.rejected();
    outputs.missed_samples = imu_.missed();
    if (!status_.faulted()) {
        std::visit([this](const auto& engine) { publish_estimate(outputs, engine, imu_.time(), parameters); },
                   engine_);
    }
    publish_status();
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish_status() {
    const double now = imu_.time();
    const bool coarse = std::visit([](const auto& engine) { return engine.is_coarse(); }, engine_);
    outputs.nis_mean = nis_window_.mean(now);
    const auto state = status_.judge(now,
                                     {.sensing = imu_.any(),
                                      .coarse = coarse,
                                      .consistent = nis_window_.deviate(now) <= parameters.consistency.limit,
                                      .heading_sigma = outputs.heading_sigma},
                                     {.heading_sigma = parameters.convergence.heading_sigma,
                                      .hold_time = parameters.convergence.hold_time,
                                      .coasting_delay = parameters.coasting.delay});
    using State = FilterStatus::State;
    using Status = typename Interface::Status;
    constexpr auto same = [](Status status, State internal) {
        return static_cast<State>(status) == internal;
    };
    static_assert(same(Status::waiting, State::waiting) && same(Status::aligning, State::aligning) &&
                  same(Status::converged, State::converged) && same(Status::coasting, State::coasting) &&
                  same(Status::faulted, State::faulted) && same(Status::coarse, State::coarse) &&
                  same(Status::inconsistent, State::inconsistent));
    const auto was = static_cast<State>(outputs.status);
    outputs.status = static_cast<Status>(state);
    outputs.converged = state == State::converged;
    if (state == was || !log_->listens()) {
        return;
    }
    if (state == State::inconsistent) {
        log_->event(text("innovations contradict their covariance at ", now, " s: nis_mean is ",
                         outputs.nis_mean, " (consistency.limit)"));
    }
    if (outputs.converged || was == State::converged) {
        log_->event(text(outputs.converged ? "converged" : "no longer converged", " at ", now, " s"));
    }
}

}  // namespace truenorth
