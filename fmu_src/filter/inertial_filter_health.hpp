// What inertial_filter.hpp tells: its estimate, and how far that can be believed.
#pragma once

#include <cmath>
#include <type_traits>

#include "contract/text.hpp"
#include "contract/time_tolerance.hpp"
#include "filter/aids.hpp"
#include "filter/filter_outputs.hpp"
#include "filter/inertial_filter.hpp"

namespace truenorth {

// So many fixes in a row beyond what their covariance explains are no outliers: of a consistent filter one in
// 3000 is beyond gate.threshold, of a receiver in a bad place one in twenty.
inline constexpr int kContradictions = 5;

// Finite, and where and as fast as a fix may be, with something to spare.
inline bool possible(const NavigationState& state) {
    return state.finite() && std::abs(state.position.latitude) <= earth::kHighestLatitude &&
           state.velocity.norm() < 2.0 * GnssInput::kLargestSpeed &&
           state.position.height > 2.0 * GnssInput::kLowest &&
           state.position.height < 2.0 * GnssInput::kHighest;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish() {
    std::visit([this](const auto& engine) { this->publish(engine, engine.best()); }, engine_);
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish_if_possible() {
    std::visit(
        [this](const auto& engine) {
            const NavigationState& best = engine.best();
            if (!status_.faulted() && !possible(best)) {
                fault("the navigation state is not finite, or nowhere near the Earth");
            }
            this->publish(engine, best);
        },
        engine_);
}

template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::publish(const E& engine, const NavigationState& best) {
    if (!status_.faulted()) {
        if (learned_ || !engine.waits()) {
            publish_knowledge(outputs, engine, parameters);
            publish_errors_of_sensors(outputs.aid, engine.estimator.appended);
        }
        publish_state(outputs, best, imu_.stamp());
        learned_ = false;
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
    aids_.each([this]<class Aid>(std::type_identity<Aid>, const AidMemory& memory) {
        outputs.clock_disagreements += memory.clock.disagreements();
        publish_health_of(Aid::health(outputs.aid), memory, imu_.time(), clock_);
    });
    outputs.aid.standstill.detected = standstill_.stands() && imu_.silent_for() <= imu_.patience();
    publish_status();
}

// What the filter is told of the gyros.
template <class Interface, class... Engines>
AttitudeLedger::Gyros InertialFilter<Interface, Engines...>::gyros() const {
    const auto& process = parameters.process;
    AttitudeLedger::Gyros gyros{.bias = parameters.prior.gyro_bias_sigma,
                                .random_walk = process.angle_random_walk};
    if constexpr (requires { process.gyro_markov_sigma; }) {
        gyros.bias = Eigen::Vector2d(gyros.bias, process.gyro_markov_sigma).norm();
    }
    if constexpr (requires { process.gyro_bias_random_walk; }) {
        gyros.bias_random_walk = process.gyro_bias_random_walk;
    }
    return gyros;
}

// What speaks against the covariance.
template <class Interface, class... Engines>
Contradiction InertialFilter<Interface, Engines...>::contradiction(const AttitudeLedger::Gyros& gyros) const {
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
    bool contradicted = false;
    aids_.each([&]<class Aid>(std::type_identity<Aid>, const AidMemory& memory) {
        contradicted =
            contradicted ||
            (memory.heard_of_late(clock_) &&
             (memory.contradictions() >= kContradictions || !(memory.window.deviate(imu_.time()) <= limit) ||
              !(memory.mean.deviate() <= limit) || !(sensors.deviate(Aid::kOwn, Aid::kOwnCount) <= limit)));
    });
    if (contradicted) {
        return Contradiction::aids;
    }
    const bool explained = ledger_.deviate(imu_.time() - opened_, gyros) <= limit;
    return explained ? Contradiction::none : Contradiction::start;
}

template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::publish_status() {
    const bool coarse = std::visit([](const auto& engine) { return engine.is_coarse(); }, engine_);
    const double delay = parameters.coasting.delay;
    const AttitudeLedger::Gyros believed = gyros();
    const Contradiction against = contradiction(believed);
    const auto state =
        status_.judge(clock_,
                      {.sensing = imu_.any(),
                       .silent = imu_.silent_for() > imu_.patience() + kTimeTolerance,
                       .suspect = clock_ - imu_.suspected() < delay - kTimeTolerance,
                       .coarse = coarse,
                       .recovering = recovery_.under_way(clock_),
                       .consistent = against == Contradiction::none,
                       .measured = ledger_.measured(outputs.heading_sigma, imu_.time() - opened_, believed),
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
        if (const auto omitted = told_notices_.tell(Notice::contradicted, clock_)) {
            log_->event(text("the covariance is contradicted at ", rounded(clock_), " s: ", reason(against),
                             "; nis_mean is ", rounded(outputs.nis_mean), and_others(*omitted).c_str()));
        }
    }
    if (state == State::silent) {
        if (const auto omitted = told_notices_.tell(Notice::silent, clock_)) {
            log_->event(text("no usable IMU sample since ", rounded(clock_ - imu_.silent_for()),
                             " s by the master's clock: the estimate stands still",
                             and_others(*omitted).c_str()));
        }
    }
    if (outputs.converged || was == State::converged) {
        log_->event(
            text(outputs.converged ? "converged" : "no longer converged", " at ", rounded(clock_), " s"));
    }
}

}  // namespace truenorth
