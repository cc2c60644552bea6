// Error models whose state is a vector: how they move over an interval.
//
// Such a model gives rate(points, interval), dx/dt of every column, and jacobian(x, interval); a linear one
// the second alone. `discretisation` says how they are integrated.
#pragma once

#include "estimation/gaussian.hpp"
#include "estimation/integration.hpp"

namespace truenorth {

// Moves the centre x and every deviation from it.
template <class Model, class Set>
void propagate_vectors(const Model& model, typename Model::State& x, Set& deviations,
                       const typename Model::Interval& interval) {
    const Set start = deviations.colwise() + x;
    const Set end = integrate(
        start, [&](const Set& points) { return model.rate(points, interval); }, interval.dt,
        model.discretisation);
    x = end.col(0);
    deviations = end.colwise() - x;
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
