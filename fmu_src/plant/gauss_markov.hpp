// First-order Gauss-Markov noise, three independent axes: autocovariance sigma^2 exp(-|tau| / time).
// Discretised exactly, and stationary from the first sample on.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "elementary/exponential.hpp"
#include "plant/noise_stream.hpp"

namespace truenorth::plant {

class GaussMarkov {
  public:
    using State = Eigen::Vector3d;  // the noise itself

    // sigma in the unit of the noise; correlation time and sampling period in s.
    GaussMarkov(double sigma, double correlation_time, double period, NoiseStream stream)
        : sigma_(sigma),
          decay_(exponential(-period / correlation_time)),
          // sigma sqrt(1 - decay^2) without the cancellation
          drive_(sigma * std::sqrt(-exponential_minus_one(-2.0 * period / correlation_time))),
          stream_(stream) {}

    [[nodiscard]] State begin() const { return sigma_ * stream_.normal(0); }

    // To sample number `sample` (1, 2, ...) from the one before.
    void advance(State& noise, std::uint64_t sample) const {
        if (sigma_ > 0.0) {
            noise = decay_ * noise + drive_ * stream_.normal(sample);
        }
    }

  private:
    double sigma_;
    double decay_;
    double drive_;
    NoiseStream stream_;
};

}  // namespace truenorth::plant
