// Random priors and measurements for the tests of correctors, and the update they are compared with: the
// textbook's, in dense matrices of any size.
#pragma once

#include <vector>

#include "estimation/random_covariance.hpp"

namespace truenorth {

constexpr int kStates = 6;
constexpr int kChannels = 3;
using Prior = Matrix<kStates>;
using Channels = Vector<kChannels>;

// One prior and one measurement; `size` scales the residual, in standard deviations of the innovation.
struct RandomMeasurement {
    RandomMeasurement(RandomCovariance& random, double size);

    [[nodiscard]] Innovation<kStates, kChannels> innovation() const;
    [[nodiscard]] Matrix<kChannels> S() const;  // covariance of the innovation

    Prior P;
    Matrix<kChannels, kStates> H;
    Channels R;  // variances of the noise
    Channels residual;
};

struct DenseUpdate {
    // Only the rows of H that are listed have been measured.
    DenseUpdate(const Dense& P, const Dense& H, const Eigen::VectorXd& R, const Eigen::VectorXd& residual,
                const std::vector<int>& rows);

    Dense S;
    Eigen::VectorXd deviation;
    Dense covariance;
};

// What holds of every correction.
template <class Correction>
bool is_sound(const Correction& correction) {
    return correction.covariance == correction.covariance.transpose() &&
           smallest_eigenvalue(correction.covariance) > 0.0 && (correction.weight.array() >= 0.0).all() &&
           (correction.weight.array() <= 1.0).all() && correction.alpha > 0.0 && correction.alpha <= 1.0;
}

template <class Correction>
bool same_estimate(const Correction& a, const Correction& b) {
    return a.deviation == b.deviation && a.covariance == b.covariance && a.weight == b.weight &&
           a.noise == b.noise;
}

}  // namespace truenorth
