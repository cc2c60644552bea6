#include "estimation/random_covariance.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

namespace truenorth {

Dense RandomCovariance::normal(int rows, int cols) {
    std::normal_distribution<double> normal;
    return Dense::NullaryExpr(rows, cols, [&] { return normal(generator_); });
}

Dense RandomCovariance::covariance(int size, double smallest, double largest) {
    std::uniform_real_distribution<double> exponent(std::log(smallest), std::log(largest));
    Eigen::VectorXd spread(size);
    for (double& value : spread) {
        value = std::exp(exponent(generator_));
    }
    const Dense Q = Eigen::HouseholderQR<Dense>(normal(size, size)).householderQ();
    const Dense P = Q * spread.asDiagonal() * Q.transpose();
    return 0.5 * (P + P.transpose());
}

double relative_difference(const Dense& a, const Dense& b) {
    return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

Eigen::VectorXd eigenvalues(const Dense& P) {
    return Eigen::SelfAdjointEigenSolver<Dense>(P, Eigen::EigenvaluesOnly).eigenvalues();
}

double smallest_eigenvalue(const Dense& P) { return eigenvalues(P)(0); }

Dense inverse(const Dense& A) { return A.inverse(); }

}  // namespace truenorth
