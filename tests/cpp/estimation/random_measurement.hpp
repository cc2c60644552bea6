// Random priors and measurements for the tests of correctors, and the update they are compared with: the
// textbook's, in dense matrices of any size.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "estimation/random_covariance.hpp"

namespace truenorth {

constexpr int kStates = 6;
constexpr int kChannels = 3;
using Prior = Matrix<kStates>;
using Channels = Vector<kChannels>;

// One prior and one measurement; `size` scales the residual, in standard deviations of the innovation.
struct RandomMeasurement {
    RandomMeasurement(RandomCovariance& random, double size)
        : P(random.covariance<kStates>(0.05, 5.0)),
          H(random.normal<kChannels, kStates>()),
          R(random.normal<kChannels, 1>().cwiseAbs2() + Channels::Constant(0.05)) {
        const Matrix<kChannels> S = H * P * H.transpose() + Matrix<kChannels>(R.asDiagonal());
        residual = size * (Matrix<kChannels>(S.llt().matrixL()) * random.normal<kChannels, 1>());
    }

    [[nodiscard]] Innovation<kStates, kChannels> innovation() const {
        return innovation_of<kStates, kChannels>(P, H, R.asDiagonal(), residual);
    }

    Prior P;
    Matrix<kChannels, kStates> H;
    Channels R;  // variances of the noise
    Channels residual;
};

struct DenseUpdate {
    // Only the rows of H that are listed have been measured.
    DenseUpdate(const Eigen::MatrixXd& P, const Eigen::MatrixXd& H, const Eigen::VectorXd& R,
                const Eigen::VectorXd& residual, const std::vector<int>& rows) {
        const Eigen::MatrixXd h = H(rows, Eigen::all);
        const Eigen::VectorXd v = residual(rows);
        const Eigen::VectorXd r = R(rows);
        S = h * P * h.transpose();
        S.diagonal() += r;
        const Eigen::MatrixXd K = P * h.transpose() * S.inverse();
        deviation = K * v;
        covariance = P - K * S * K.transpose();
    }

    Eigen::MatrixXd S;
    Eigen::VectorXd deviation;
    Eigen::MatrixXd covariance;
};

// What holds of every correction.
template <class Correction>
bool is_sound(const Correction& correction) {
    return correction.covariance == correction.covariance.transpose() &&
           smallest_eigenvalue<kStates>(correction.covariance) > 0.0 &&
           (correction.weight.array() >= 0.0).all() && (correction.weight.array() <= 1.0).all() &&
           correction.alpha > 0.0 && correction.alpha <= 1.0;
}

template <class Correction>
bool same_estimate(const Correction& a, const Correction& b) {
    return a.deviation == b.deviation && a.covariance == b.covariance && a.weight == b.weight &&
           a.noise == b.noise;
}

}  // namespace truenorth
