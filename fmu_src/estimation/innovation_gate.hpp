// Chi-square test of an innovation; stands before any corrector.
#pragma once

#include <Eigen/Cholesky>

#include "estimation/chi_square.hpp"
#include "estimation/gaussian.hpp"
#include "settings/correction.hpp"

namespace truenorth {

// Normalised innovation squared, r^T (H P H^T + R)^-1 r: chi-square with as many degrees of freedom as there
// are channels when the filter is consistent.
template <int N, int M>
double nis(const Innovation<N, M>& innovation) {
    const Eigen::LLT<Matrix<M>> S(innovation.spread + innovation.noise);
    return Vector<M>(S.matrixL().solve(innovation.residual)).squaredNorm();
}

// `threshold` is that of two channels, where it admits 1 - exp(-threshold / 2).
struct InnovationGate : settings::Gate {
    using settings::Gate::operator=;

    [[nodiscard]] bool admits(double nis, int channels) const { return !enabled || explains(nis, channels); }

    // A covariance explains an innovation of this NIS.
    [[nodiscard]] bool explains(double nis, int channels) const { return nis <= threshold_for(channels); }

    // The threshold of the same confidence for any number of channels.
    [[nodiscard]] double threshold_for(int channels) const {
        if (channels == 2 || channels == 0) {
            return threshold;
        }
        return chi_square_beyond(normal_deviate(threshold, 2), channels);
    }
};

}  // namespace truenorth
