// The quantities that pass between the three phases of a filter step: predict, innovate, correct.
//
// Means and covariances are over *deviations*, vectors of N components that a model applies to its state
// (`retract`); a model whose state is a vector simply adds them.
#pragma once

#include <Eigen/Core>

namespace truenorth {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

template <int Rows, int Cols = Rows>
using Matrix = Eigen::Matrix<double, Rows, Cols>;

// A set of deviations or states, one a column. Stored by rows, so that one component of all points lies in
// consecutive memory and a model's arithmetic vectorises across points.
template <int N, int Count>
using Points = Eigen::Matrix<double, N, Count, (N > 1 && Count == 1) ? Eigen::ColMajor : Eigen::RowMajor>;

// The prior of a measurement of M components, seen from the N states.
template <int N, int M>
struct Innovation {
    Vector<M> residual;  // measurement minus its prediction
    Matrix<M> spread;    // covariance of the prediction, H P H^T
    Matrix<M> noise;     // covariance of the measurement noise, R
    Matrix<N, M> cross;  // covariance of states and prediction, P H^T
};

// What a corrector makes of an innovation.
template <int N, int M>
struct Correction {
    Vector<N> deviation;   // to be applied to the state
    Matrix<N> covariance;  // posterior
};

// A + factor sum_k x_k x_k^T over the columns of X, for symmetric A: exactly symmetric, and twice as fast as
// the general product at these sizes.
template <int N, class Set>
Matrix<N> rank_update(const Matrix<N>& A, const Set& X, double factor) {
    Matrix<N> sum;
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j <= i; ++j) {
            sum(i, j) = A(i, j) + factor * X.row(i).dot(X.row(j));
            sum(j, i) = sum(i, j);
        }
    }
    return sum;
}

template <int N>
void symmetrise(Matrix<N>& matrix) {
    matrix = 0.5 * (matrix + matrix.transpose()).eval();
}

}  // namespace truenorth
