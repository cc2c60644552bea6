// Random matrices for property tests, and the arithmetic of the oracles that they are compared with, in dense
// matrices of any size that are compiled once; the same seed gives the same matrices.
#pragma once

#include <Eigen/Core>
#include <random>

#include "estimation/gaussian.hpp"

namespace truenorth {

using Dense = Eigen::MatrixXd;

class RandomCovariance {
  public:
    explicit RandomCovariance(unsigned seed) : generator_(seed) {}

    [[nodiscard]] Dense normal(int rows, int cols);

    // Q diag(eigenvalues) Q^T with a random orthogonal Q and eigenvalues spread evenly in the logarithm.
    [[nodiscard]] Dense covariance(int size, double smallest, double largest);

    template <int Rows, int Cols>
    [[nodiscard]] Matrix<Rows, Cols> normal() {
        return normal(Rows, Cols);
    }

    template <int N>
    [[nodiscard]] Matrix<N> covariance(double smallest, double largest) {
        return covariance(N, smallest, largest);
    }

  private:
    std::mt19937 generator_;
};

// Largest difference of two matrices in units of the largest coefficient of the second.
double relative_difference(const Dense& a, const Dense& b);

double smallest_eigenvalue(const Dense& P);

// Of a symmetric matrix, ascending.
Eigen::VectorXd eigenvalues(const Dense& P);

Dense inverse(const Dense& A);

// What a filter that predicts with H from the covariance P makes of a residual.
template <int N, int M>
Innovation<N, M> innovation_of(const Matrix<N>& P, const Matrix<M, N>& H, const Matrix<M>& R,
                               const Vector<M>& residual) {
    const Matrix<N, M> cross = P * H.transpose();
    return {residual, H * cross, R, cross};
}

}  // namespace truenorth
