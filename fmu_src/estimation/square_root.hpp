// Square root of a covariance, with a defined outcome when rounding has spoilt it.
#pragma once

#include <Eigen/Core>
#include <cmath>
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

// Lower triangle L, L L^T = covariance; none of what is not positive definite. Whole columns are subtracted,
// whose length a compiler knows, from one that it can keep in registers: what is above the diagonal comes to
// zero but for rounding.
template <int N>
std::optional<Matrix<N>> cholesky(const Matrix<N>& covariance) {
    std::optional<Matrix<N>> lower(std::in_place);
    Matrix<N>& L = *lower;
    for (int k = 0; k < N; ++k) {
        Vector<N> column = covariance.col(k);
        for (int j = 0; j < k; ++j) {
            column -= L(k, j) * L.col(j);
        }
        if (!(column(k) > 0.0)) {
            lower.reset();
            return lower;
        }
        L.col(k) = (1.0 / std::sqrt(column(k))) * column;
    }
    L.template triangularView<Eigen::StrictlyUpper>().setZero();
    return lower;
}

template <int N>
SquareRoot<N> square_root(const Matrix<N>& covariance) {
    static_assert(N <= kMostStates);
    if (const auto lower = cholesky<N>(covariance); lower && covariance.allFinite()) {
        return {*lower};
    }
    if (covariance.allFinite()) {
        if (const auto root = root_of_nearest(covariance)) {
            return {*root, true, true};
        }
    }
    return {Matrix<N>::Zero(), false, false};
}

}  // namespace truenorth
