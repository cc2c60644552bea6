// Error models whose state is a vector: how they move over an interval.
//
// Such a model gives rate(points, interval), dx/dt of every column, and jacobian(x, interval); a linear one
// the second alone. `discretisation` says how they are integrated.
#pragma once

#include "estimation/gaussian.hpp"
#include "estimation/integration.hpp"

namespace truenorth {

// Moves the centre x and every deviation from it at the given rate of points.
template <class Model, class Set, class Rate>
void propagate_at(const Rate& rate, const Model& model, typename Model::State& x, Set& deviations,
                  double dt) {
    const Set start = deviations.colwise() + x;
    const Set end = integrate(start, rate, dt, model.discretisation);
    x = end.col(0);
    deviations = end.colwise() - x;
}

template <class Model, class Set>
void propagate_vectors(const Model& model, typename Model::State& x, Set& deviations,
                       const typename Model::Interval& interval) {
    const auto rate = [&](const Set& points) { return model.rate(points, interval); };
    propagate_at(rate, model, x, deviations, interval.dt);
}

// The same with a noise that acts on each point, spread evenly over the interval.
template <class Model, class Set>
void propagate_vectors(const Model& model, typename Model::State& x, Set& deviations, const Set& noise,
                       const typename Model::Interval& interval) {
    const Set drive = noise / interval.dt;
    const auto rate = [&](const Set& points) { return Set(model.rate(points, interval) + drive); };
    propagate_at(rate, model, x, deviations, interval.dt);
}

template <class Model>
Matrix<Model::kStates> vector_transition(const Model& model, const typename Model::State& x,
                                         const typename Model::Interval& interval) {
    return transition(model.jacobian(x, interval), interval.dt, model.discretisation);
}

// Of a linear model: what the integration of x' = F x would give, from its transition matrix.
template <class Model, class Set>
void propagate_linearly(const Model& model, typename Model::State& x, Set& deviations,
                        const typename Model::Interval& interval) {
    const Matrix<Model::kStates> Phi = model.transition(x, interval);
    x = (Phi * x).eval();
    deviations = (Phi * deviations).eval();
}

}  // namespace truenorth
