#include "estimation/forgetting.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace truenorth::forgetting {

namespace {

void symmetrise(Matrix& matrix) { matrix = (0.5 * (matrix + matrix.transpose())).eval(); }

}  // namespace

bool forget(Matrix& posterior, const Vector& scale, double gamma) {
    const Matrix scaled = scale.asDiagonal() * posterior * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
    const Vector& lambda = eigen.eigenvalues();
    const double gamma2 = gamma * gamma;
    if (lambda.maxCoeff() > kLargestRatio * gamma2) {
        return false;
    }
    const Vector growth = (gamma2 - lambda.array()).inverse();
    const Matrix weighted = posterior * scale.asDiagonal();
    const Matrix projection = weighted.lazyProduct(eigen.eigenvectors());
    const Matrix grown = projection * growth.asDiagonal();
    posterior += grown.lazyProduct(projection.transpose());
    return true;
}

bool forget_below(Matrix& posterior, const Vector& scale, double gamma, const Vector& sigma, double limit) {
    const Vector inverse = sigma.cwiseInverse();
    const Matrix normalised = inverse.asDiagonal() * posterior * inverse.asDiagonal();
    const Eigen::LLT<Matrix> cholesky(normalised);
    if (cholesky.info() != Eigen::Success) {
        return false;
    }
    Matrix J = Matrix::Identity(posterior.rows(), posterior.cols());
    cholesky.solveInPlace(J);
    J.diagonal() -= scale.cwiseProduct(sigma).cwiseAbs2() / (gamma * gamma);
    symmetrise(J);
    const Eigen::SelfAdjointEigenSolver<Matrix> information(J);
    const Vector variance = information.eigenvalues().cwiseMax(1.0 / limit).cwiseInverse();
    const Matrix& U = information.eigenvectors();
    const Matrix clipped = U * variance.asDiagonal();
    Matrix change = clipped.lazyProduct(U.transpose());
    change -= normalised;
    symmetrise(change);
    const Eigen::SelfAdjointEigenSolver<Matrix> growth(change);
    const Matrix axes = sigma.asDiagonal() * growth.eigenvectors();
    const Vector gained = growth.eigenvalues().cwiseMax(0.0);
    const Matrix grown = axes * gained.asDiagonal();
    posterior += grown.lazyProduct(axes.transpose());
    return true;
}

}  // namespace truenorth::forgetting
