// Minimum-variance corrector (Kalman).
#pragma once

#include <Eigen/Cholesky>

#include "estimation/gaussian.hpp"

namespace truenorth {

class Standard {
  public:
    // K = P H^T S^-1, posterior P - K S K^T with S = H P H^T + R (Zhou 2011, section 1, measurement update).
    template <int N, int M>
    Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        const Eigen::LLT<Matrix<M>> S(innovation.spread + innovation.noise);
        const Matrix<N, M> gain = S.solve(innovation.cross.transpose()).transpose();
        Matrix<N> posterior = prior;
        posterior.noalias() -= gain * innovation.cross.transpose();
        symmetrise(posterior);
        return {gain * innovation.residual, posterior};
    }
};

}  // namespace truenorth
