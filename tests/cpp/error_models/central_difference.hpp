// Jacobian of f at x by central differences: error of the order step^2, plus rounding over the step.
#pragma once

#include "estimation/gaussian.hpp"

namespace truenorth {

template <int Rows, int N, class Function>
Matrix<Rows, N> central_difference(const Function& f, const Vector<N>& x, double step) {
    Matrix<Rows, N> J;
    for (int j = 0; j < N; ++j) {
        const Vector<N> h = step * Vector<N>::Unit(j);
        J.col(j) = (f(Vector<N>(x + h)) - f(Vector<N>(x - h))) / (2.0 * step);
    }
    return J;
}

}  // namespace truenorth
