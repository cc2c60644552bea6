// The measurement of an aid and the estimate of an engine: how the one is seen from the other, and the
// correction. For every model of a filter alike; compiled once a model, in the source file of its adapter.
#pragma once

#include "aiding/observation.hpp"
#include "estimation/innovation_gate.hpp"
#include "estimation/standard.hpp"
#include "filter/change.hpp"

namespace truenorth {

inline constexpr double kAnyVelocity = 100.0;  // sigma of a velocity of which nothing is known [m/s]

template <class E>
struct AidUpdate {
    static constexpr int kStates = E::kStates;
    using Sight = aiding::Sight<kStates>;

    // What is observed of a navigation state, with the sigmas of the measurement.
    static Sight sight(const E& engine, const NavigationState& state, const aiding::Observation& observation,
                       const Vector<aiding::kChannels>& sigma);

    static double nis(const Sight& sight);

    // The standard update. What the sensors are off by is learned from it, or considered (Schmidt 1966).
    static Change correct(E& engine, const Sight& sight, bool learns);

  private:
    static Matrix<aiding::kChannels> unmodelled(const NavigationState& state);
    static Matrix<aiding::kChannels> curvature(const E& engine, const Eigen::Vector3d& turns);
};

// What of a velocity in body axes a model leaves out whose vertical velocity is no state: that may be any.
template <class E>
Matrix<aiding::kChannels> AidUpdate<E>::unmodelled(const NavigationState& state) {
    if constexpr (E::Where::velocity.count < 3) {
        const Eigen::Vector3d up = state.q_bn.conjugate() * Eigen::Vector3d::UnitZ();
        return kAnyVelocity * kAnyVelocity * up * up.transpose();
    } else {
        return Matrix<aiding::kChannels>::Zero();
    }
}

// What a measurement leaves out that is linear in the misalignment: to second order a vector turned by phi is
// shorter by |phi|^2 / 2, whose second moment is 3/4 of the square of its variance. Ten degrees that nobody
// knows make 0.26 m/s of 10 m/s, far beyond the noise of a log.
template <class E>
Matrix<aiding::kChannels> AidUpdate<E>::curvature(const E& engine, const Eigen::Vector3d& turns) {
    constexpr int attitude = E::Where::attitude.first;
    const auto& covariance = engine.covariance();
    const double variance = covariance.template block<3, 3>(attitude, attitude).trace();
    const Eigen::Vector3d shorter = variance * turns;
    return 0.75 * shorter * shorter.transpose();
}

template <class E>
auto AidUpdate<E>::sight(const E& engine, const NavigationState& state,
                         const aiding::Observation& observation, const Vector<aiding::kChannels>& sigma)
    -> Sight {
    Matrix<aiding::kChannels> left_out = curvature(engine, observation.turns);
    if (observation.is_velocity) {
        left_out += unmodelled(state);
    }
    return aiding::sight_of<kStates>(observation, sigma, engine.navigation_errors(),
                                     engine.estimator.covariance, engine.estimator.appended, left_out);
}

template <class E>
double AidUpdate<E>::nis(const Sight& sight) {
    return truenorth::nis(sight.innovation);
}

template <class E>
Change AidUpdate<E>::correct(E& engine, const Sight& sight, bool learns) {
    const auto correction = Standard().correct(engine.estimator.covariance, sight.innovation);
    typename E::Correction update{};
    update.deviation = correction.deviation;
    update.covariance = correction.covariance;
    const Appended& before = engine.estimator.appended;
    const Appended sensors =
        learns ? before.after(sight.innovation, sight.own) : before.considered(sight.innovation, sight.own);
    Change change = engine.apply(update, &sensors);
    change.finite = change.finite && sensors.finite();
    return change;
}

}  // namespace truenorth
