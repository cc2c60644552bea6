// Square root of a covariance, with a defined outcome when rounding has spoilt it.
#pragma once

#include <Eigen/Cholesky>
#include <optional>

#include "estimation/bounded.hpp"
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

// A of a finite covariance that is not positive definite; none if its eigenvalues are not found.
std::optional<BoundedMatrix> root_of_nearest(const BoundedMatrix& covariance);

template <int N>
SquareRoot<N> square_root(const Matrix<N>& covariance) {
    static_assert(N <= kMostStates);
    const Eigen::LLT<Matrix<N>> cholesky(covariance);
    if (cholesky.info() == Eigen::Success && covariance.allFinite()) {
        return {cholesky.matrixL()};
    }
    if (covariance.allFinite()) {
        if (const auto root = root_of_nearest(covariance)) {
            return {*root, true, true};
        }
    }
    return {Matrix<N>::Zero(), false, false};
}

}  // namespace truenorth
