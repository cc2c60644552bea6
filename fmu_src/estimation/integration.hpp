// Steps of ordinary differential equations x' = rate(x), x a vector or a set of points, rate constant in
// time.
#pragma once

#include "settings/prediction.hpp"

namespace truenorth {

using settings::Discretisation;

template <class State, class Rate>
State integrate(const State& x, const Rate& rate, double dt, Discretisation discretisation) {
    const State k1 = rate(x);
    if (discretisation == Discretisation::euler) {
        return x + dt * k1;
    }
    const State k2 = rate(State(x + 0.5 * dt * k1));
    const State k3 = rate(State(x + 0.5 * dt * k2));
    const State k4 = rate(State(x + dt * k3));
    return x + (dt / 6.0) * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

// The Jacobian of such a step for rate(x) = F x: the Taylor polynomial of exp(F dt) of the method's order.
template <class Matrix>
Matrix transition(const Matrix& F, double dt, Discretisation discretisation) {
    const Matrix identity = Matrix::Identity();
    if (discretisation == Discretisation::euler) {
        return identity + dt * F;
    }
    const Matrix A = dt * F;
    return identity + A * (identity + A * (identity + A * (identity + A / 4.0) / 3.0) / 2.0);
}

}  // namespace truenorth
