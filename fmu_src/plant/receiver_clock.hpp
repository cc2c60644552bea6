// The clock of a GNSS receiver, in units of range: the bias b adds to every pseudorange, the drift d to every
// range rate;
//
//     b' = d + bias_noise w_b,    d' = drift_noise w_d,    w white noises of density 1.
//
// Discretised exactly: a period T adds noise of covariance
//     [q_b T + q_d T^3 / 3, q_d T^2 / 2; q_d T^2 / 2, q_d T],    q the squares of the densities.
#pragma once

#include <cmath>
#include <cstdint>

#include "plant/noise_stream.hpp"

namespace truenorth::plant {

class ReceiverClock {
  public:
    struct State {
        double bias = 0.0;   // [m]
        double drift = 0.0;  // [m/s]

        template <class Archive>
        void serialize(Archive& archive) {
            archive(bias, drift);
        }
    };

    struct Noise {
        double bias = 0.0;   // density [m/s^0.5]
        double drift = 0.0;  // density [m/s^1.5]
    };

    ReceiverClock(const Noise& noise, double period, NoiseStream stream)
        : period_(period),
          drift_sigma_(noise.drift * std::sqrt(period)),
          bias_sigma_(std::sqrt(
              period * (noise.bias * noise.bias + noise.drift * noise.drift * period * period / 12.0))),
          stream_(stream) {}

    // To fix number `fix` (1, 2, ...) from the one before.
    void advance(State& state, std::uint64_t fix) const {
        const Eigen::Vector3d normal = stream_.normal(fix);
        const double drift_change = drift_sigma_ * normal[0];
        state.bias += period_ * (state.drift + 0.5 * drift_change) + bias_sigma_ * normal[1];
        state.drift += drift_change;
    }

  private:
    double period_;       // of the fixes [s]
    double drift_sigma_;  // of a period [m/s]
    double bias_sigma_;   // of a period, of the part that is independent of the drift [m]
    NoiseStream stream_;
};

}  // namespace truenorth::plant
