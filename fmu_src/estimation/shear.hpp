// Deviations to which multiples of one of them are added: the matrix I + by e_along^T.
#pragma once

#include "estimation/gaussian.hpp"

namespace truenorth {

template <int N>
struct Shear {
    int along = 0;
    Vector<N> by = Vector<N>::Zero();

    [[nodiscard]] Matrix<N> matrix() const {
        return Matrix<N>::Identity() + by * Vector<N>::Unit(along).transpose();
    }

    // Of the deviations after it, for that of those before: without products of matrices, and symmetric.
    [[nodiscard]] Matrix<N> covariance(const Matrix<N>& P) const {
        const Vector<N> half = P.col(along) + (0.5 * P(along, along)) * by;
        return P + (by.lazyProduct(half.transpose()) + half.lazyProduct(by.transpose()));
    }
};

}  // namespace truenorth
