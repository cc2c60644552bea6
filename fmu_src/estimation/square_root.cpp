#include "estimation/square_root.hpp"

#include <Eigen/Eigenvalues>

namespace truenorth {

std::optional<BoundedMatrix> root_of_nearest(const BoundedMatrix& covariance) {
    // States differ by many orders of magnitude, so the repair happens on the correlation matrix.
    const BoundedVector sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    const BoundedVector inverse = sigma.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
    const BoundedMatrix correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<BoundedMatrix> eigen(correlation);
    if (eigen.info() != Eigen::Success) {
        return std::nullopt;
    }
    const BoundedVector root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    return sigma.asDiagonal() * eigen.eigenvectors() * root.asDiagonal();
}

}  // namespace truenorth
