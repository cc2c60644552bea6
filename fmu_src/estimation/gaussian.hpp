// The quantities that pass between the three phases of a filter step: predict, innovate, correct.
//
// Means and covariances are over *deviations*, vectors of N components that a model applies to its state
// (`retract`); a model whose state is a vector simply adds them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

namespace truenorth {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

template <int Rows, int Cols = Rows>
using Matrix = Eigen::Matrix<double, Rows, Cols>;

// A set of deviations or states, one a column. Stored by rows, so that one component of all points lies in
// consecutive memory and a model's arithmetic vectorises across points.
template <int N, int Count>
using Points = Eigen::Matrix<double, N, Count, (N > 1 && Count == 1) ? Eigen::ColMajor : Eigen::RowMajor>;

// The components of a vector in space; Row holds one of them for every point of a set.
template <class Row>
using Components = std::array<Row, 3>;

// The prior of a measurement of M components, its channels, seen from the N states.
//
// M is fixed, but a channel may be absent in an epoch (a satellite below the horizon). An absent channel is
// marked in `present` and holds what makes it neutral in the linear algebra: residual 0, no correlation with
// anything, noise 1. So a corrector is right without looking, and only what counts channels, or learns from
// them, consults the mask.
template <int N, int M>
struct Innovation {
    using Mask = Eigen::Array<bool, M, 1>;

    Vector<M> residual;  // measurement minus its prediction
    Matrix<M> spread;    // covariance of the prediction, H P H^T
    Matrix<M> noise;     // covariance of the measurement noise, R
    Matrix<N, M> cross;  // covariance of states and prediction, P H^T
    Mask present = Mask::Constant(true);

    // Degrees of freedom.
    [[nodiscard]] int channels() const { return static_cast<int>(present.count()); }

    // From here on the channel has not been measured.
    void remove(int channel) {
        residual(channel) = 0.0;
        spread.row(channel).setZero();
        spread.col(channel).setZero();
        noise.row(channel).setZero();
        noise.col(channel).setZero();
        noise(channel, channel) = 1.0;
        cross.col(channel).setZero();
        present(channel) = false;
    }

    // Its noise becomes so many times larger; correlations stay what they are.
    void inflate(int channel, double growth) {
        noise.row(channel) *= growth;
        noise.col(channel) *= growth;
    }

    // Standardised innovation u_i = |v_i| / sqrt(S_ii), S = H P H^T + R.
    [[nodiscard]] Vector<M> standardised() const {
        return residual.cwiseAbs().cwiseQuotient((spread + noise).diagonal().cwiseSqrt());
    }
};

// What a corrector makes of an innovation, and what it did to it.
template <int N, int M>
struct Correction {
    Vector<N> deviation;   // to be applied to the state
    Matrix<N> covariance;  // posterior
    Vector<M> weight;      // of a channel: 1 used in full, 0 absent or removed
    Matrix<M> noise;       // the R that was used; of a channel without weight, 1
    double alpha = 1.0;    // the prior covariance was divided by this
    double gamma_effective = std::numeric_limits<double>::infinity();  // of H-infinity, as used
    bool feasible = true;   // false: the gamma asked for was infeasible and the update backed off
    double nis = 0.0;       // of the innovation as it was predicted
    double nis_used = 0.0;  // and as the correction used it: with its R and its alpha, of so many channels
    int channels_used = 0;

    [[nodiscard]] bool used() const { return (weight.array() > 0.0).any(); }
};

// The innovation as the correction used it: with its R and its alpha, without the channels that lost their
// weight.
template <int N, int M>
Innovation<N, M> as_used(Innovation<N, M> innovation, const Correction<N, M>& correction) {
    innovation.spread /= correction.alpha;
    innovation.cross /= correction.alpha;
    innovation.noise = correction.noise;
    for (int i = 0; i < M; ++i) {
        if (correction.weight(i) == 0.0) {
            innovation.remove(i);
        }
    }
    return innovation;
}

// A + factor sum_k x_k x_k^T over the columns of X, for symmetric A: exactly symmetric, and twice as fast as
// the general product at these sizes.
template <int N, class Set>
Matrix<N> rank_update(const Matrix<N>& A, const Set& X, double factor) {
    Matrix<N> sum;
    for (int i = 0; i < N; ++i) {
        const Eigen::Matrix<double, 1, Set::ColsAtCompileTime> row = X.row(i);  // aligned, as a set is not
        for (int j = 0; j <= i; ++j) {
            sum(i, j) = A(i, j) + factor * row.dot(X.row(j));
            sum(j, i) = sum(i, j);
        }
    }
    return sum;
}

template <int N>
void symmetrise(Matrix<N>& matrix) {
    matrix = 0.5 * (matrix + matrix.transpose()).eval();
}

// A B, a column after the other: at these sizes it takes some 60 % of the instructions of Eigen's general
// product, which is made for larger ones.
template <class A, class B>
auto product(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
    Matrix<A::RowsAtCompileTime, B::ColsAtCompileTime> result;
    for (int j = 0; j < B::ColsAtCompileTime; ++j) {
        Vector<A::RowsAtCompileTime> sum = a.col(0) * b(0, j);
        for (int k = 1; k < A::ColsAtCompileTime; ++k) {
            sum += a.col(k) * b(k, j);
        }
        result.col(j) = sum;
    }
    return result;
}

// F P F^T of a covariance P, exactly symmetric. One product after the other: a compiler has less to do than
// with all of them in one expression.
template <int N>
Matrix<N> transformed(const Matrix<N>& F, const Matrix<N>& P) {
    const Matrix<N> carried = product(F, P);
    Matrix<N> covariance = product(carried, F.transpose());
    symmetrise(covariance);
    return covariance;
}

}  // namespace truenorth
