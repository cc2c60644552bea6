#include "estimation/forgetting.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace truenorth::forgetting {

namespace {

void symmetrise(BoundedMatrix& matrix) { matrix = (0.5 * (matrix + matrix.transpose())).eval(); }

}  // namespace

bool forget(BoundedMatrix& posterior, const BoundedVector& scale, double gamma) {
    const BoundedMatrix scaled = scale.asDiagonal() * posterior * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<BoundedMatrix> eigen(scaled);
    const BoundedVector& lambda = eigen.eigenvalues();
    const double gamma2 = gamma * gamma;
    if (lambda.maxCoeff() > kLargestRatio * gamma2) {
        return false;
    }
    const BoundedVector growth = (gamma2 - lambda.array()).inverse();
    const BoundedMatrix weighted = posterior * scale.asDiagonal();
    const BoundedMatrix projection = weighted.lazyProduct(eigen.eigenvectors());
    const BoundedMatrix grown = projection * growth.asDiagonal();
    posterior += grown.lazyProduct(projection.transpose());
    return true;
}

bool forget_below(BoundedMatrix& posterior, const BoundedVector& scale, double gamma,
                  const BoundedVector& sigma, double limit) {
    const BoundedVector inverse = sigma.cwiseInverse();
    const BoundedMatrix normalised = inverse.asDiagonal() * posterior * inverse.asDiagonal();
    const Eigen::LLT<BoundedMatrix> cholesky(normalised);
    if (cholesky.info() != Eigen::Success) {
        return false;
    }
    BoundedMatrix J = BoundedMatrix::Identity(posterior.rows(), posterior.cols());
    cholesky.solveInPlace(J);
    J.diagonal() -= scale.cwiseProduct(sigma).cwiseAbs2() / (gamma * gamma);
    symmetrise(J);
    const Eigen::SelfAdjointEigenSolver<BoundedMatrix> information(J);
    const BoundedVector variance = information.eigenvalues().cwiseMax(1.0 / limit).cwiseInverse();
    const BoundedMatrix& U = information.eigenvectors();
    const BoundedMatrix clipped = U * variance.asDiagonal();
    BoundedMatrix change = clipped.lazyProduct(U.transpose());
    change -= normalised;
    symmetrise(change);
    const Eigen::SelfAdjointEigenSolver<BoundedMatrix> growth(change);
    const BoundedMatrix axes = sigma.asDiagonal() * growth.eigenvectors();
    const BoundedVector gained = growth.eigenvalues().cwiseMax(0.0);
    const BoundedMatrix grown = axes * gained.asDiagonal();
    posterior += grown.lazyProduct(axes.transpose());
    return true;
}

}  // namespace truenorth::forgetting
