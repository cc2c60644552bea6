// Error models whose state is a vector: how they move over an interval.
//
// Such a model gives rate(points, interval), dx/dt of every column, and jacobian(x, interval); a linear one
// the second alone. `discretisation` says how they are integrated.
#pragma once

#include <algorithm>

#include "estimation/gaussian.hpp"
#include "estimation/integration.hpp"

namespace truenorth {

// Moves the centre x and every deviation from it; rate(points, first) is that of some of the points, the
// first of which is in column `first`. A few of them go all the way at a time, so that little leaves the
// registers.
template <class Model, class Set, class Rate>
void propagate_at(const Rate& rate, const Model& model, typename Model::State& x, Set& deviations,
                  double dt) {
    constexpr int count = Set::ColsAtCompileTime;
    constexpr int few = std::min(count, 8);
    using Few = Points<Model::kStates, few>;
    Set end;
    for (int next = 0; next < count; next += few) {
        const int first = std::min(next, count - few);  // the last ones may have been moved before
        const Few start = deviations.template middleCols<few>(first).colwise() + x;
        const auto rate_of_few = [&](const Few& points) { return rate(points, first); };
        end.template middleCols<few>(first) = integrate(start, rate_of_few, dt, model.discretisation);
    }
    x = end.col(0);
    deviations = end.colwise() - x;
}

template <class Model, class Set>
void propagate_vectors(const Model& model, typename Model::State& x, Set& deviations,
                       const typename Model::Interval& interval) {
    const auto rate = [&](const auto& points, int /*first*/) { return model.rate(points, interval); };
    propagate_at(rate, model, x, deviations, interval.dt);
}

// The same with a noise that acts on each point, spread evenly over the interval.
template <class Model, class Set>
void propagate_vectors(const Model& model, typename Model::State& x, Set& deviations, const Set& noise,
                       const typename Model::Interval& interval) {
    const auto rate = [&]<class Few>(const Few& points, int first) -> Few {
        const auto drive = noise.template middleCols<Few::ColsAtCompileTime>(first) / interval.dt;
        return model.rate(points, interval) + drive;
    };
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
