// Robust corrector of Zhou 2011: H-infinity filtering as a Kalman filter in Krein space.
//
// The linear combination L x is to be estimated with an error energy below gamma^2 times the energy of the
// disturbances. The gain is the standard one; the posterior loses information at every update,
//
//     P_k = (P_post^-1 - gamma^-2 L^T L)^-1,   P_post the standard posterior,
//
// which is Zhou 2011 eq. 11 (with eqs. 8-9 inserted) by the matrix inversion lemma; in the paper R = I and
// the process noise is Gamma Gamma^T because its system is noise-normalised, here R and Q keep their units.
// Misprint of Zhou 2011: the L_k at the end of eq. 10 is one too many, M_k of eq. 11 being K_Z L_k.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>
#include <optional>

#include "estimation/gaussian.hpp"
#include "estimation/standard.hpp"

namespace truenorth {

template <int N>
class HInfinity {
  public:
    // Bounds what an update may forget: in units of `sigma`, no eigenvalue of the posterior grows beyond
    // about `limit` (1.2 times it at worst, see forget_below).
    struct Ceiling {
        Vector<N> sigma;
        double limit;
    };

    // An eigenvalue of L P_post L / gamma^2 beyond this counts as infeasible: it would grow a thousandfold.
    static constexpr double kLargestRatio = 0.999;

    double gamma = 2.0;
    Vector<N> scale = Vector<N>::Ones();  // the diagonal of L; 0 leaves a state out
    std::optional<Ceiling> ceiling = std::nullopt;

    template <int M>
    [[nodiscard]] Correction<N, M> correct(const Matrix<N>& prior, const Innovation<N, M>& innovation) const {
        Correction<N, M> result = Standard().correct(prior, innovation);
        result.feasible = ceiling ? forget_below(*ceiling, result.covariance) : forget(result.covariance);
        // Backing off means to forget nothing at this update. A gamma that is just feasible would instead let
        // what the measurement does not see grow without bound from update to update.
        result.gamma_effective = result.feasible ? gamma : std::numeric_limits<double>::infinity();
        symmetrise(result.covariance);
        return result;
    }

  private:
    // With L P_post L = U diag(lambda) U^T,
    //     P_k = P_post + P_post L U diag(1 / (gamma^2 - lambda_i)) U^T L P_post,
    // feasible while every lambda_i < gamma^2. Returns false, and changes nothing, if it is not.
    bool forget(Matrix<N>& posterior) const {
        const Matrix<N> scaled = scale.asDiagonal() * posterior * scale.asDiagonal();
        const Eigen::SelfAdjointEigenSolver<Matrix<N>> eigen(scaled);
        const Vector<N>& lambda = eigen.eigenvalues();
        const double gamma2 = gamma * gamma;
        if (lambda.maxCoeff() > kLargestRatio * gamma2) {
            return false;
        }
        const Vector<N> growth = (gamma2 - lambda.array()).inverse();
        const Matrix<N> projection = posterior * scale.asDiagonal() * eigen.eigenvectors();
        posterior += projection * growth.asDiagonal() * projection.transpose();
        return true;
    }

    // The information matrix in units of sigma, J = S (P_post^-1 - gamma^-2 L^T L) S, keeps every eigenvalue
    // above 1 / limit: feasible for any gamma. Clipping turns the axes a little and would shrink some
    // directions below P_post; of the change only what adds variance is kept, because an update may forget
    // but not learn here, at the price of passing the limit a little. Returns false, and changes nothing, if
    // P_post has no inverse.
    bool forget_below(const Ceiling& bound, Matrix<N>& posterior) const {
        const Vector<N>& sigma = bound.sigma;
        const Vector<N> inverse = sigma.cwiseInverse();
        const Matrix<N> normalised = inverse.asDiagonal() * posterior * inverse.asDiagonal();
        const Eigen::LLT<Matrix<N>> cholesky(normalised);
        if (cholesky.info() != Eigen::Success) {
            return false;
        }
        Matrix<N> J = cholesky.solve(Matrix<N>::Identity());
        J.diagonal() -= scale.cwiseProduct(sigma).cwiseAbs2() / (gamma * gamma);
        symmetrise(J);
        const Eigen::SelfAdjointEigenSolver<Matrix<N>> information(J);
        const Vector<N> variance = information.eigenvalues().cwiseMax(1.0 / bound.limit).cwiseInverse();
        const Matrix<N>& U = information.eigenvectors();
        Matrix<N> change = U * variance.asDiagonal() * U.transpose() - normalised;
        symmetrise(change);
        const Eigen::SelfAdjointEigenSolver<Matrix<N>> growth(change);
        const Matrix<N> axes = sigma.asDiagonal() * growth.eigenvectors();
        posterior += axes * growth.eigenvalues().cwiseMax(0.0).asDiagonal() * axes.transpose();
        return true;
    }
};

}  // namespace truenorth
