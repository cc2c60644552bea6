// What inertial_filter.hpp does with the measurements of its aids.
#pragma once

#include "components/aids.hpp"
#include "components/inertial_filter_run.hpp"

namespace truenorth {

inline constexpr double kAnyVelocity = 100.0;  // sigma of a velocity of which nothing is known [m/s]

// Whether anything came.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::take_aids() {
    const auto& sigma = parameters.measurement;
    const BodyVelocityAid velocity{.lever_arm = parameters.body_velocity.lever_arm,
                                   .sigma = sigma.body_velocity_sigma,
                                   .scale_sigma = parameters.body_velocity.scale_sigma};
    const bool moved = take_aid(velocity, inputs.body_velocity, body_velocity_);
    const bool turned =
        take_aid(HeadingAid{.sigma = sigma.heading_aid_sigma}, inputs.heading_aid, heading_aid_);
    const bool lifted = take_aid(HeightAid{.sigma = sigma.height_aid_sigma}, inputs.height_aid, height_aid_);
    return moved || turned || lifted;
}

template <class Interface, class... Engines>
template <class Aid, class AidPort>
bool InertialFilter<Interface, Engines...>::take_aid(const Aid& aid, const AidPort& port, AidMemory& memory) {
    if (status_.faulted() || port.sample == memory.sample) {
        return false;
    }
    memory.sample = port.sample;
    const auto refuse = [&](Refusal refusal) {
        ++memory.rejected;
        const auto omitted = log_->listens() ? memory.told.tell(refusal, clock_) : std::nullopt;
        if (omitted) {
            log_->event(text(Aid::kName, " ", port.sample, " (", Aid::kName, ".time = ", port.time,
                             " s) rejected: ", reason(refusal), and_others(*omitted).c_str()));
        }
        return true;
    };
    const Vector<Aid::kChannels> measured = Aid::measured(port);
    Vector<Aid::kChannels> sigma;
    sigma.array() = port.sigma;
    const auto present = !measured.array().isNaN();
    if (!std::isfinite(port.time) || !present.any() || measured.array().isInf().any() ||
        !present.select(sigma.array(), 0.0).isFinite().all()) {
        return refuse(Refusal::not_finite);
    }
    if (!Aid::possible(measured) || (present.select(sigma.array(), 0.0) < 0.0).any()) {
        return refuse(Refusal::impossible);
    }
    sigma = (sigma.array() > 0.0).select(sigma, aid.sigma).eval();
    sigma = aid.with_errors(sigma, measured);
    const double period = imu_.increment().dt;
    const auto verdict = memory.clock.read(
        port.time, {.now = imu_.time() + imu_.silent_for(), .offset = imu_.offset(), .slack = period});
    if (verdict != StampClock::Verdict::accepted) {
        return refuse(verdict == StampClock::Verdict::backwards ? Refusal::backwards : Refusal::future);
    }
    // What lies within an IMU period of the newest sample counts as of then.
    memory.heard = clock_;
    const double valid_at = memory.clock.valid_at();
    if (valid_at > imu_.time() + std::max(period, StampClock::kAhead) + kTimeTolerance) {
        return refuse(Refusal::uncovered);
    }
    const auto then = history_.at(std::min(valid_at, imu_.time()));
    if (!then) {
        return refuse(Refusal::too_old);
    }
    predict();
    if (status_.faulted()) {
        return true;
    }
    const auto refusal = std::visit(
        [&](auto& engine) { return correct_by(engine, aid, measured, sigma, *then, memory); }, engine_);
    return refusal ? refuse(*refusal) : true;
}

// Whether no fix has been used of late.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::alone() const {
    return clock_ - gnss_used_ > parameters.coasting.delay;
}

// The prediction is blamed for what an aid measures.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::blame(E& engine, const Uncertainty& more, const char* aid) {
    engine.add_uncertainty(more);
    ledger_.doubt(more.attitude.diagonal());
    recovery_.doubt(clock_);
    if (!log_->listens()) {
        return;
    }
    if (const auto omitted = told_notices_.tell(Notice::doubted, clock_)) {
        log_->event(text("the gate refused ", parameters.gate.patience, " measurements in a row of ", aid,
                         " until ", rounded(clock_),
                         " s (gate.patience), without fixes that say otherwise: the prediction is blamed",
                         and_others(*omitted).c_str()));
    }
}

// What of a velocity in body axes a model leaves out whose vertical velocity is no state: that may be any.
template <class E, class Aid>
Matrix<Aid::kChannels> unmodelled(const Eigen::Quaterniond& q_bn) {
    if constexpr (Aid::kBindsVelocity && E::Where::velocity.count < 3) {
        const Eigen::Vector3d up = q_bn.conjugate() * Eigen::Vector3d::UnitZ();
        return kAnyVelocity * kAnyVelocity * up * up.transpose();
    } else {
        return Matrix<Aid::kChannels>::Zero();
    }
}

// Of a difference in body axes, what is vertical and no state of the model [m/s]; not a number if one axis
// is.
template <class E, class Aid>
double vertical_velocity(const Eigen::Quaterniond& q_bn, const Vector<Aid::kChannels>& difference) {
    if constexpr (Aid::kBindsVelocity && E::Where::velocity.count < 3) {
        return (q_bn * difference).z();
    } else {
        return 0.0;
    }
}

// What a model has no states for is taken as it is measured, as that of a fix is.
template <class Interface, class... Engines>
template <class E, class Aid>
void InertialFilter<Interface, Engines...>::take_as_it_is(E& engine, const Eigen::Quaterniond& q_bn,
                                                          const Vector<Aid::kChannels>& difference) {
    if constexpr (!E::kFindsPosition) {
        const auto up = [](double size) { return Eigen::Vector3d(0.0, 0.0, size); };
        const double climb = vertical_velocity<E, Aid>(q_bn, difference);
        const double lift = Aid::kIsHeight ? difference(0) : 0.0;
        if (alone() && std::isfinite(climb)) {
            engine.move(up(-climb), up(-lift));
            history_.shift(up(-climb), up(-lift));
        }
    }
}

template <class Interface, class... Engines>
template <class Aid>
void InertialFilter<Interface, Engines...>::note_use_of(AidMemory& memory,
                                                        const Vector<Aid::kChannels>& measured) {
    ++memory.used;
    memory.last = clock_;
    if constexpr (Aid::kBindsVelocity) {
        if (!measured.template head<2>().array().isNaN().all()) {
            status_.use_fix(clock_);
        }
    }
}

// Why the measurement was not used, if it was not.
template <class Interface, class... Engines>
template <class E, class Aid, int K>
std::optional<Refusal> InertialFilter<Interface, Engines...>::correct_by(E& engine, const Aid& aid,
                                                                         const Vector<K>& measured,
                                                                         const Vector<K>& sigma,
                                                                         const AntennaState& then,
                                                                         AidMemory& memory) {
    if (engine.is_coarse()) {
        return Refusal::coarse;
    }
    const Eigen::Vector3d to_imu = -(then.q_bn * parameters.gnss.lever_arm);
    const aiding::Moment moment{
        .state = engine.estimated({.q_bn = then.q_bn,
                                   .velocity = then.velocity - then.lever_velocity,
                                   .position = earth::displaced(then.position, to_imu)}),
        .omega_eb_b = then.omega_eb_b};
    const Eigen::Quaterniond& q_bn = moment.state.q_bn;
    const auto observation = aid.observe(moment, measured);
    if constexpr (Aid::kIsHeight && !E::kFindsPosition) {
        if (!alone()) {
            return Refusal::no_channel;
        }
    } else {
        const auto innovation = aiding::innovation_of(observation, sigma, engine.navigation_errors(),
                                                      engine.estimator.covariance, unmodelled<E, Aid>(q_bn));
        if (const auto refusal = correct_with(engine, innovation, memory)) {
            // Fixes that are used speak for the prediction, and against the aid.
            if (alone() && memory.out_of_patience(parameters.gate.patience)) {
                memory.forgive();
                blame(engine, Aid::doubt(innovation.residual), Aid::kName);
            }
            return refusal;
        }
    }
    take_as_it_is<E, Aid>(engine, q_bn, observation.difference);
    note_use_of<Aid>(memory, measured);
    return std::nullopt;
}

// The standard update, if the gate admits it.
template <class Interface, class... Engines>
template <class E, int N, int K>
std::optional<Refusal> InertialFilter<Interface, Engines...>::correct_with(E& engine,
                                                                           const Innovation<N, K>& innovation,
                                                                           AidMemory& memory) {
    const int channels = innovation.channels();
    if (channels == 0) {
        return Refusal::no_channel;
    }
    const double nis = truenorth::nis(innovation);
    if (!memory.admits(engine.corrector.gate, nis, channels)) {
        return Refusal::beyond_gate;
    }
    memory.window.add(imu_.time(), nis, channels);
    const auto correction = Standard().correct(engine.estimator.covariance, innovation);
    typename E::Correction update{};
    update.deviation = correction.deviation;
    update.covariance = correction.covariance;
    const Change change = engine.apply(update);
    if (change.finite) {
        follow(change);
    } else {
        fault("the correction is not finite");
    }
    return std::nullopt;
}

}  // namespace truenorth
