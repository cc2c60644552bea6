// Random matrices for property tests; the same seed gives the same ones.
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "estimation/gaussian.hpp"

namespace truenorth {

class RandomCovariance {
  public:
    explicit RandomCovariance(unsigned seed) : generator_(seed) {}

    template <int Rows, int Cols>
    Matrix<Rows, Cols> normal() {
        std::normal_distribution<double> normal;
        return Matrix<Rows, Cols>::NullaryExpr([&] { return normal(generator_); });
    }

    // Q diag(eigenvalues) Q^T with a random orthogonal Q and eigenvalues spread evenly in the logarithm.
    template <int N>
    Matrix<N> covariance(double smallest, double largest) {
        std::uniform_real_distribution<double> exponent(std::log(smallest), std::log(largest));
        Vector<N> eigenvalues;
        for (double& value : eigenvalues) value = std::exp(exponent(generator_));
        const Matrix<N> Q = Eigen::HouseholderQR<Matrix<N>>(normal<N, N>()).householderQ();
        Matrix<N> P = Q * eigenvalues.asDiagonal() * Q.transpose();
        symmetrise(P);
        return P;
    }

  private:
    std::mt19937 generator_;
};

// What a filter that predicts with H from the covariance P makes of a residual.
template <int N, int M>
Innovation<N, M> innovation_of(const Matrix<N>& P, const Matrix<M, N>& H, const Matrix<M>& R,
                               const Vector<M>& residual) {
    const Matrix<N, M> cross = P * H.transpose();
    return {residual, H * cross, R, cross};
}

// Largest difference of two matrices in units of the largest coefficient of the second.
template <class A, class B>
double relative_difference(const A& a, const B& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

template <int N>
double smallest_eigenvalue(const Matrix<N>& P) {
    return Eigen::SelfAdjointEigenSolver<Matrix<N>>(P, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

}  // namespace truenorth
