// Wave-band noise, three independent axes: white noise through the second-order band-pass filter
//
//     H(s) = K s / (s^2 + 2 zeta w s + w^2),    w = 2 pi / period,
//
// K such that the noise has the sigma named. With the states (p, q), q the noise and p = w integral of q,
// both have that sigma, they are uncorrelated, and (p, q)' = w [0 1; -1 -2 zeta] (p, q) + (0, white noise).
// Discretised exactly, and stationary from the first sample on.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "plant/noise_stream.hpp"

namespace truenorth::plant {

class WaveNoise {
  public:
    using State = Eigen::Matrix<double, 2, 3>;  // rows p, q; a column an axis

    // sigma in the unit of the noise; period of the peak and sampling period in s; 0 < damping < 1.
    WaveNoise(double sigma, double peak_period, double damping, double period, NoiseStream stream);

    [[nodiscard]] State begin() const { return sigma_ * draw(0); }

    // To sample number `sample` (1, 2, ...) from the one before.
    void advance(State& state, std::uint64_t sample) const {
        if (sigma_ > 0.0) {
            state = transition_ * state + drive_ * draw(sample);
        }
    }

    [[nodiscard]] static Eigen::Vector3d noise(const State& state) { return state.row(1); }

  private:
    [[nodiscard]] State draw(std::uint64_t sample) const;

    double sigma_;
    Eigen::Matrix2d transition_;
    Eigen::Matrix2d drive_;  // Cholesky factor of the covariance that a sample adds
    NoiseStream stream_;
};

}  // namespace truenorth::plant
