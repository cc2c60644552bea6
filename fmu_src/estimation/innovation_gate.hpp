// Chi-square test of an innovation; stands before any corrector.
#pragma once

#include <Eigen/Cholesky>

#include "estimation/gaussian.hpp"

namespace truenorth {

// Normalised innovation squared, r^T (H P H^T + R)^-1 r: chi-square with M degrees of freedom when the filter
// is consistent.
template <int N, int M>
double nis(const Innovation<N, M>& innovation) {
    const Matrix<M> S = innovation.spread + innovation.noise;
    return innovation.residual.dot(S.llt().solve(innovation.residual));
}

struct InnovationGate {
    bool enabled = true;
    double threshold = 16.0;

    [[nodiscard]] bool admits(double nis) const { return !enabled || nis <= threshold; }
};

}  // namespace truenorth
