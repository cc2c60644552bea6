// Robust corrector of Zhou 2011: H-infinity filtering as a Kalman filter in Krein space.
//
// The linear combination L x is to be estimated with an error energy below gamma^2 times the energy of the
// disturbances. The gain is the standard one; the posterior loses information at every update,
//
//     P_k = (P_post^-1 - gamma^-2 L^T L)^-1,   P_post the standard posterior,
//
// which is Zhou 2011 eq. 11 (with eqs. 8-9 inserted) by the matrix inversion lemma; in the paper R = I and
// the process noise is Gamma Gamma^T because its system is noise-normalised, here R and Q keep their units.
// With L diagonal and L P_post L = U diag(lambda) U^T,
//
//     P_k = P_post + P_post L U diag(1 / (gamma^2 - lambda_i)) U^T L P_post,
//
// feasible while every lambda_i < gamma^2. In the coordinates of L the update turns the eigenvalue lambda
// into lambda / (1 - lambda / gamma^2).
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"

namespace truenorth {

template <int N, int M>
struct RobustCorrection : Correction<N, M> {
    double gamma_effective = 0.0;  // the gamma that was used
    bool feasible = true;          // false: robust.gamma was infeasible and the update backed off
};

template <int N>
struct HInfinity {
    static constexpr double kNoCeiling = std::numeric_limits<double>::infinity();
    // Back-off keeps the largest lambda / gamma^2 at this value, so that no eigenvalue grows more than
    // tenfold.
    static constexpr double kLargestRatio = 0.9;

    double gamma = 2.0;
    Vector<N> scale = Vector<N>::Ones();  // the diagonal of L; 0 leaves a state out
    double ceiling = kNoCeiling;  // inflated eigenvalues are clipped here (never below the eigenvalue)

    template <int M>
    RobustCorrection<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        RobustCorrection<N, M> result{Standard().correct(prior, innovation), gamma, true};
        Matrix<N>& posterior = result.covariance;

        const Matrix<N> scaled = scale.asDiagonal() * posterior * scale.asDiagonal();
        const Eigen::SelfAdjointEigenSolver<Matrix<N>> eigen(scaled);
        const Vector<N>& lambda = eigen.eigenvalues();

        double gamma2 = gamma * gamma;
        if (ceiling == kNoCeiling && lambda.maxCoeff() > kLargestRatio * gamma2) {
            gamma2 = lambda.maxCoeff() / kLargestRatio;
            result.gamma_effective = std::sqrt(gamma2);
            result.feasible = false;
        }
        const Vector<N> growth = lambda.unaryExpr([&](double l) { return inflation(l, gamma2); });
        const Matrix<N> projection = posterior * scale.asDiagonal() * eigen.eigenvectors();
        posterior += projection * growth.asDiagonal() * projection.transpose();
        symmetrise(posterior);
        return result;
    }

  private:
    // (inflated - lambda) / lambda^2, which is 1 / (gamma^2 - lambda) where the ceiling does not bind.
    [[nodiscard]] double inflation(double lambda, double gamma2) const {
        const bool feasible = lambda < gamma2;
        if (feasible && lambda * gamma2 <= ceiling * (gamma2 - lambda)) {
            return 1.0 / (gamma2 - lambda);
        }
        return std::max(ceiling - lambda, 0.0) / (lambda * lambda);
    }
};

}  // namespace truenorth
