// What inertial_filter.hpp does with the measurements of its aids.
#pragma once

#include "contract/count_up.hpp"
#include "filter/aids.hpp"
#include "filter/inertial_filter_run.hpp"
#include "inertial/attitude.hpp"

namespace truenorth {

// What a rung of the way back does without fixes.
inline const char* deed_without_fixes(int rung, bool stays, bool keeps_heading) {
    if (rung < Recovery::kSensors) {
        return "";
    }
    if (rung < Recovery::kAttitude) {
        return ", the sensors are in doubt with it";
    }
    if (rung < Recovery::kRestart) {
        return ", attitude and sensors are in doubt with it";
    }
    if (!stays) {
        return ", and the filter starts again, level as the force says, with any heading";
    }
    return keeps_heading || rung < Recovery::kLast
               ? ", and the filter starts again where it is, with any heading"
               : ", and the filter starts again, with another heading";
}

// Whether anything came; `sampled`: with a sample of the IMU, or one that was refused.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::take_aids(bool sampled) {
    OwnMotion motion{.clock = clock_};
    if (sampled) {
        watch_for_standstill();
        motion.stood = standstill_.ended() && standstill_.stands();
        motion.mean_rate = standstill_.mean().template head<3>();
    }
    bool anything = false;
    aids_.each([&]<class Aid>(std::type_identity<Aid>, AidMemory& memory) {
        const Aid aid = Aid::of(parameters);
        if constexpr (Aid::kHasPort) {
            anything = take_aid(aid, memory) || anything;
        } else if (sampled) {
            anything = take_own(aid, motion, memory) || anything;
        }
    });
    return anything;
}

// Looks at the sample of the IMU that came, if standing is an aid.
template <class Interface, class... Engines>
void InertialFilter<Interface, Engines...>::watch_for_standstill() {
    const auto& p = parameters.standstill;
    if (p.velocity_sigma <= 0.0 && p.rate_sigma <= 0.0) {
        standstill_.interrupt();
        return;
    }
    if (imu_.finding() != ImuInput::Finding::none || imu_.gap() > 0 || imu_.blind_for() > 0.0) {
        standstill_.interrupt();
        return;
    }
    const auto of_sensors = [](double rate, double force) {
        Standstill::Rates both;
        both << Eigen::Array3d::Constant(rate), Eigen::Array3d::Constant(force);
        return both;
    };
    standstill_.add(imu_.increment(), {.window = p.window,
                                       .noise = of_sensors(parameters.process.angle_random_walk,
                                                           parameters.process.velocity_random_walk),
                                       .deviation = of_sensors(p.rate_deviation, p.force_deviation)});
    if (standstill_.ended()) {
        standstill_.decide(may_stand());
    }
}

// What the IMU cannot tell from standing: a constant velocity, which the estimate must exclude as far as it
// knows itself; and a turn that is even, beyond what the gyros may be off by.
template <class Interface, class... Engines>
bool InertialFilter<Interface, Engines...>::may_stand() const {
    constexpr double kSigmasOfSpeed = 3.0;
    constexpr double kSigmasOfRate = 4.0;  // beyond it are three axes together once in a thousand
    return std::visit(
        [this]<class E>(const E& engine) {
            constexpr auto velocity = E::Where::velocity;
            const auto& covariance = engine.covariance();  // by value or by reference, as the engine has it
            const double variance =
                covariance.diagonal().template segment<velocity.count>(velocity.first).maxCoeff();
            const double speed = engine.best().velocity.template head<velocity.count>().norm() +
                                 kSigmasOfSpeed * std::sqrt(std::max(variance, 0.0));
            const Eigen::Vector3d measured = standstill_.mean().template head<3>();
            const double turns = (measured - engine.gyro_bias()).norm() - earth::kRate;
            const double off = Eigen::Vector2d(gyros().bias, standstill_.mean_sigma()(0)).norm();
            return speed <= parameters.standstill.largest_speed && turns <= kSigmasOfRate * off;
        },
        engine_);
}

inline constexpr double kLeastRateSigma = 1e-10;  // as kLeastSigma, of a rate [rad/s]

// What the filter knows without a sensor is a measurement of now.
template <class Interface, class... Engines>
template <class Aid>
bool InertialFilter<Interface, Engines...>::take_own(const Aid& aid, const OwnMotion& motion,
                                                     AidMemory& memory) {
    if (status_.faulted() || aid.sigma <= 0.0 || !aid.is_due(motion, memory)) {
        return false;
    }
    memory.hear(clock_);
    const double least = Aid::kIsRate ? kLeastRateSigma : kLeastSigma;
    const Eigen::Vector3d sigma = Eigen::Vector3d::Constant(std::max(aid.sigma, least));
    const auto refusal = use_aid(aid, Aid::measured(motion), sigma, antenna(), memory);
    return !refusal ||
           refuse_aid(memory, *refusal, [this] { return text(Aid::kName, " at ", rounded(clock_), " s"); });
}

// Returns true: something came. `subject()` says what.
template <class Interface, class... Engines>
template <class Subject>
bool InertialFilter<Interface, Engines...>::refuse_aid(AidMemory& memory, Refusal refusal,
                                                       const Subject& subject) {
    count_up(memory.rejected);
    const auto omitted = log_->listens() ? memory.told.tell(refusal, clock_) : std::nullopt;
    if (omitted) {
        log_->event(text(subject().c_str(), " rejected: ", reason(refusal), and_others(*omitted).c_str()));
    }
    return true;
}

template <class Interface, class... Engines>
template <class Aid>
bool InertialFilter<Interface, Engines...>::take_aid(const Aid& aid, AidMemory& memory) {
    const auto& port = Aid::port(inputs);
    if (status_.faulted()) {
        return false;
    }
    const Eigen::Vector3d measured = Aid::measured(port);
    const int sample = memory.arrival.number(port.sample, port.time, measured, uncounted());
    if (sample == memory.sample) {
        return false;
    }
    memory.sample = sample;
    const auto refuse = [&](Refusal refusal) {
        return refuse_aid(memory, refusal, [&port] {
            return text(Aid::kName, " ", port.sample, " (", Aid::kName, ".time = ", port.time, " s)");
        });
    };
    Eigen::Vector3d sigma = Aid::sigma_of(port);
    const auto present = !measured.array().isNaN();
    if (!std::isfinite(port.time) || !present.any() || measured.array().isInf().any() ||
        !present.select(sigma.array(), 0.0).isFinite().all()) {
        return refuse(Refusal::not_finite);
    }
    if (!Aid::possible(measured) || (present.select(sigma.array(), 0.0) < 0.0).any()) {
        return refuse(Refusal::impossible);
    }
    sigma = (sigma.array() > 0.0).select(sigma, aid.sigma).cwiseMax(kLeastSigma).eval();
    const double period = imu_.increment().dt;
    const auto verdict = memory.clock.read(port.time, moment(period));
    if (verdict != StampClock::Verdict::accepted) {
        return refuse(refusal_of(verdict));
    }
    // What lies within an IMU period of the newest sample counts as of then.
    memory.hear(clock_);
    const double valid_at = memory.clock.valid_at();
    if (valid_at > imu_.time() + std::max(period, StampClock::kAhead) + kTimeTolerance) {
        return refuse(Refusal::uncovered);
    }
    const auto then = history_.at(std::min(valid_at, imu_.time()));
    if (!then) {
        return refuse(Refusal::too_old);
    }
    const auto refusal = use_aid(aid, measured, sigma, *then, memory);
    return refusal ? refuse(*refusal) : true;
}

// Why the measurement was not used, if it was not.
template <class Interface, class... Engines>
template <class Aid>
std::optional<Refusal> InertialFilter<Interface, Engines...>::use_aid(const Aid& aid,
                                                                      const Eigen::Vector3d& measured,
                                                                      const Eigen::Vector3d& sigma,
                                                                      const AntennaState& then,
                                                                      AidMemory& memory) {
    if constexpr (Aid::kBindsVelocity && Aid::kHasPort) {
        const Eigen::Vector3d predicted = then.q_bn.conjugate() * (then.velocity - then.lever_velocity);
        const Eigen::Vector3d at_imu = measured - then.omega_eb_b.cross(aid.lever_arm);
        const Eigen::Vector3d told = at_imu.array().isNaN().select(predicted, at_imu);
        leveller_.add(then, then.q_bn * told + then.lever_velocity, sigma.maxCoeff());
    }
    predict();
    if (status_.faulted()) {
        return std::nullopt;
    }
    return std::visit([&](auto& engine) { return correct_by(engine, aid, measured, sigma, then, memory); },
                      engine_);
}

// Of the position; nothing for a model that has none.
template <class E>
Eigen::Matrix3d position_variance(const E& engine) {
    constexpr auto where = E::Where::position;
    if constexpr (where.count == 3) {
        const auto& covariance = engine.covariance();  // by value or by reference, as the engine has it
        return covariance.template block<3, 3>(where.first, where.first);
    } else {
        return Eigen::Matrix3d::Zero();
    }
}

// Starts again level, as a log that measured the acceleration says, with any heading and the position that
// there is.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::start_again_level(E& engine, double angle) {
    const Eigen::Matrix3d place = position_variance(engine);
    const Eigen::Vector3d velocity = engine.best().velocity;
    Change proposal;
    if constexpr (!E::kStartsWhereItIs) {
        proposal.rotation = leveller_.upright(angle);
    } else if constexpr (!E::kKeepsHeading) {
        proposal.rotation = about_up(angle);
    }
    proposal.velocity = proposal.rotation * velocity - velocity;
    const Discrepancy nowhere{.position = Eigen::Vector3d::Zero(), .velocity = Eigen::Vector3d::Zero()};
    const Change change = engine.start_again(
        proposal, {Recovery::kTilt, Recovery::kTilt, Recovery::kAnyHeading}, nowhere, false);
    engine.add_uncertainty({.position = place});
    turn(change.rotation);
    history_.shift(change.velocity, change.displacement);
}

// An aid has been refused so often in a row that something else is to be blamed. While fixes are used they
// speak for the prediction, and the sensor's constant errors are in doubt. Without them a log climbs the
// ladder of recovery.hpp; what does not bear the navigation is believed of what it measures, and no more.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::recover_by(E& engine, const AidDoubt& doubt, AidMemory& memory) {
    memory.lose_count();
    if (!alone()) {
        engine.estimator.appended.forget(doubt.own, doubt.own_count, doubt.own_least);
        if (log_->listens()) {
            log_->event(text("the gate refused ", parameters.gate.patience, " measurements in a row of ",
                             doubt.name, " until ", rounded(clock_),
                             " s (gate.patience) while fixes were used: its constant errors are in doubt"));
        }
        return;
    }
    memory.forgive();
    if (!recovery_.under_way(clock_)) {
        astray_ = 0.0;
    }
    int rung = 1;
    if (doubt.binds_velocity) {
        if (astray_ == 0.0) {
            astray_at_ = std::max(memory.last, gnss_used_);
        }
        rung = recovery_.climb(clock_, parameters.gate.patience, was_sure_);
    } else {
        recovery_.doubt(clock_);
        engine.estimator.appended.forget(doubt.own, doubt.own_count, doubt.own_least);
    }
    was_sure_ = was_sure_ && rung < Recovery::kAttitude;
    if (log_->listens()) {
        log_->event(text("the gate refused ", parameters.gate.patience, " measurements in a row of ",
                         doubt.name, " until ", rounded(clock_),
                         " s (gate.patience), without fixes that say otherwise: the prediction is blamed",
                         deed_without_fixes(rung, E::kStartsWhereItIs, E::kKeepsHeading)));
    }
    if (rung >= Recovery::kRestart) {
        const NavigationState& state = E::kStartsWhereItIs ? engine.mechanisation().state : engine.best();
        const double now = euler_angles(state.q_bn.toRotationMatrix()).heading;
        start_again_level(engine, rung == Recovery::kLast ? now - recovery_.next_heading() : 0.0);
    }
    Uncertainty more = doubt.prediction;
    // The velocity that there is without fixes has turned with the heading.
    const Eigen::Vector3d velocity = engine.best().velocity;
    const Eigen::Vector3d across(-velocity.y(), velocity.x(), 0.0);
    more.velocity += more.attitude(2, 2) * across * across.transpose();
    if (rung >= Recovery::kSensors && rung < Recovery::kRestart) {
        more.sensors = 1.0;
    }
    if (rung == Recovery::kAttitude) {
        const Eigen::Vector3d sigma(Recovery::kTilt, Recovery::kTilt, Recovery::kHeading);
        more.attitude.diagonal() += sigma.cwiseAbs2();
    }
    if (rung >= Recovery::kAttitude) {
        const double heading = rung == Recovery::kAttitude ? Recovery::kHeading : Recovery::kAnyHeading;
        const double turned = heading * velocity.norm();
        more.velocity += turned * turned * Eigen::Matrix3d::Identity();
        doubt_sensors(engine);
    }
    engine.add_uncertainty(more);
    if (doubt.binds_velocity) {
        go_astray(engine);
    }
    if (rung >= Recovery::kSensors) {
        open_ledger(engine);
    } else {
        ledger_.doubt(more.attitude.diagonal());
    }
}

// Without fixes and on the way back the filter does not know where it goes: what it believes to go, it may
// have gone in any direction since it last trusted its log.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::go_astray(E& engine) {
    const double before = astray_;
    astray_ += engine.best().velocity.norm() * (clock_ - astray_at_);
    astray_at_ = clock_;
    const double gained = astray_ * astray_ - before * before;
    engine.add_uncertainty({.position = Eigen::Vector3d(gained, gained, 0.0).asDiagonal()});
    learned_ = true;
}

// Of a difference in body axes, what is vertical and no state of the model [m/s]; not a number if one axis
// is.
template <class E, class Aid>
double vertical_velocity(const Eigen::Quaterniond& q_bn, const Eigen::Vector3d& difference) {
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
                                                          const Eigen::Vector3d& difference) {
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
void InertialFilter<Interface, Engines...>::note_use_of(AidMemory& memory, const Eigen::Vector3d& measured) {
    count_up(memory.used);
    memory.last = clock_;
    if constexpr (Aid::kBindsVelocity) {
        if (!measured.head<2>().array().isNaN().all()) {
            status_.use_fix(clock_);
        }
    }
}

// Why the measurement was not used, if it was not.
template <class Interface, class... Engines>
template <class E, class Aid>
std::optional<Refusal> InertialFilter<Interface, Engines...>::correct_by(E& engine, const Aid& aid,
                                                                         const Eigen::Vector3d& measured,
                                                                         const Eigen::Vector3d& sigma,
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
        .omega_eb_b = then.omega_eb_b,
        .sensors = engine.estimator.appended.mean(),
        .gyro_bias = engine.gyro_bias()};
    const aiding::Observation observation = aid.observe(moment, measured);
    if constexpr (Aid::kIsRate && E::Where::gyro.count < 3) {
        return Refusal::no_channel;  // what they are off by is no state
    } else if constexpr (Aid::kIsHeight && !E::kFindsPosition) {
        if (!alone()) {
            return Refusal::no_channel;
        }
    } else {
        const auto sight = AidUpdate<E>::sight(engine, moment.state, observation, sigma);
        if (const auto refusal = correct_with(engine, sight, memory, Aid::kBindsVelocity)) {
            if (memory.out_of_patience(parameters.gate.patience)) {
                recover_by(engine, doubt_of<Aid>(sight.innovation.residual), memory);
            }
            return refusal;
        }
        if (status_.faulted()) {
            return std::nullopt;
        }
    }
    take_as_it_is<E, Aid>(engine, moment.state.q_bn, observation.difference);
    note_use_of<Aid>(memory, measured);
    return std::nullopt;
}

// A correction by an angle of many degrees, as there are on the way back, is good to first order:
// what it leaves is half the square of the angle, of the attitude and of the velocity that turns with it.
template <class Interface, class... Engines>
template <class E>
void InertialFilter<Interface, Engines...>::turned_far(E& engine, const Eigen::Matrix3d& rotation) {
    const double angle = rotation_vector(rotation).norm();
    const double left = std::min(0.5 * angle * angle, Recovery::kAnyHeading);
    const double speed = left * engine.best().velocity.norm();
    ledger_.doubt(Eigen::Vector3d::Constant(left * left));
    engine.add_uncertainty({.attitude = left * left * Eigen::Matrix3d::Identity(),
                            .velocity = speed * speed * Eigen::Matrix3d::Identity()});
}

// The update, if the gate admits it.
template <class Interface, class... Engines>
template <class E>
std::optional<Refusal> InertialFilter<Interface, Engines...>::correct_with(
    E& engine, const aiding::Sight<E::kStates>& sight, AidMemory& memory, bool binds_velocity) {
    const int channels = sight.innovation.channels();
    if (channels == 0) {
        return Refusal::no_channel;
    }
    const double nis = AidUpdate<E>::nis(sight);
    const bool on_the_way = alone() && recovery_.under_way(clock_);
    const bool open = on_the_way && binds_velocity && recovery_.open();
    if (!memory.admits(engine.corrector.gate, nis, channels, open)) {
        return Refusal::beyond_gate;
    }
    if (on_the_way && binds_velocity) {
        recovery_.pass(clock_);
        if (astray_ > 0.0) {
            go_astray(engine);
        }
    }
    memory.window.add(imu_.time(), nis, channels);
    if (!open) {
        memory.mean.add(imu_.time(), sight.innovation);
    }
    const Change change = AidUpdate<E>::correct(engine, sight, !open);
    if (!change.finite) {
        fault("the correction is not finite");
        return std::nullopt;
    }
    follow(change);
    if (on_the_way) {
        turned_far(engine, change.rotation);
    }
    return std::nullopt;
}

}  // namespace truenorth
