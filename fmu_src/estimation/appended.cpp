#include "estimation/appended.hpp"

#include <algorithm>
#include <cmath>

namespace truenorth {

void Appended::forget(int first, int count, double least_sigma) {
    covariance_.middleRows(first, count).setZero();
    covariance_.middleCols(first, count).setZero();
    for (int i = first; i < first + count; ++i) {
        const double sigma = prior_sigma(i) > 0.0 ? std::max(prior_sigma(i), least_sigma) : 0.0;
        covariance_(i, i) = sigma * sigma;
    }
    mean_.segment(first, count).setZero();
    cross_.middleCols(first, count).setZero();
}

double Appended::deviate(int first, int count) const {
    double largest = 0.0;
    for (int i = first; i < first + count; ++i) {
        if (prior_sigma(i) > 0.0) {
            largest = std::max(largest, std::abs(mean_(i)) / prior_sigma(i));
        }
    }
    return largest;
}

void Appended::regress(const Rows& prior, const Rows& posterior,
                       const Eigen::Ref<const Eigen::VectorXd>& deviation) {
    using Regression =
        Eigen::Matrix<double, Eigen::Dynamic, kCount, Eigen::ColMajor, kMostStates, kCount>;  // G^T
    const Eigen::Index n = prior.rows();
    const Eigen::LDLT<BoundedMatrix> P{BoundedMatrix(prior)};
    Regression G = P.solve(Regression(cross_.topRows(n)));
    // Sigma points may carry the covariance otherwise than the Jacobian carried the cross covariance: the
    // states can tell no more of a constant than all of it.
    for (int i = 0; i < kCount; ++i) {
        const double told = G.col(i).dot(cross_.col(i).head(n));
        if (!(told >= 0.0)) {  // rounding has left a covariance that is none
            part();
            return;
        }
        if (told > covariance_(i, i)) {
            const double less = std::sqrt(covariance_(i, i) / told);
            G.col(i) *= less;
            cross_.col(i) *= less;
        }
    }
    const Regression changed = BoundedMatrix(posterior - prior).lazyProduct(G);
    mean_ += G.transpose().lazyProduct(deviation);
    covariance_ += G.transpose().lazyProduct(changed);
    symmetrise(covariance_);
    cross_.topRows(n) += changed;
}

}  // namespace truenorth
