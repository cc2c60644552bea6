// Minimum-variance corrector (Kalman).
#pragma once

#include <Eigen/Cholesky>

#include "estimation/gaussian.hpp"

namespace truenorth {

class Standard {
  public:
    // K = P H^T S^-1, posterior P - K S K^T with S = H P H^T + R (Zhou 2011, section 1, measurement update).
    template <int N, int M>
    [[nodiscard]] Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        const Eigen::LLT<Matrix<M>> S(innovation.spread + innovation.noise);
        // With S = L L^T: P H^T L^-T, so that K S K^T is a sum of squares.
        const Matrix<N, M> whitened = S.matrixL().solve(innovation.cross.transpose()).transpose();
        return {whitened * S.matrixL().solve(innovation.residual), rank_update<N>(prior, whitened, -1.0),
                innovation.present.template cast<double>(), innovation.noise};
    }
};

}  // namespace truenorth
