// Square root of a covariance, with a defined outcome when rounding has spoilt it.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "estimation/gaussian.hpp"

namespace truenorth {

// A A^T = covariance. `repaired`: the covariance was not positive definite, and A A^T is the nearest one to
// it with its negative eigenvalues (of the correlation matrix) set to zero. `valid`: false when it holds a
// value that is not finite, and A is meaningless.
template <int N>
struct SquareRoot {
    Matrix<N> factor;
    bool repaired = false;
    bool valid = true;
};

template <int N>
SquareRoot<N> square_root(const Matrix<N>& covariance) {
    const Eigen::LLT<Matrix<N>> cholesky(covariance);
    if (cholesky.info() == Eigen::Success && covariance.allFinite()) {
        return {cholesky.matrixL()};
    }
    if (!covariance.allFinite()) {
        return {Matrix<N>::Zero(), false, false};
    }
    // States differ by many orders of magnitude, so the repair happens on the correlation matrix.
    const Vector<N> sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    const Vector<N> inverse = sigma.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
    const Eigen::SelfAdjointEigenSolver<Matrix<N>> eigen(inverse.asDiagonal() * covariance *
                                                         inverse.asDiagonal());
    const Vector<N> root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    return {sigma.asDiagonal() * eigen.eigenvectors() * root.asDiagonal(), true,
            eigen.info() == Eigen::Success};
}

}  // namespace truenorth
