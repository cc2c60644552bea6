// A triad of gyros or of accelerometers: true increments in, measured increments out.
//
//     measured = (I + diag(scale_factor)) C_b^s true
//              + (bias + random walk + bias step + Gauss-Markov + wave-band) T
//              + white_noise sqrt(T) N(0, 1),  then quantised
//
// over one sampling period T. C_b^s = exp(-[misalignment x]): the sensor axes s are the body axes turned by
// the rotation vector `misalignment`. Units: u is rad for gyros, m/s for accelerometers.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "plant/gauss_markov.hpp"
#include "plant/noise_stream.hpp"
#include "plant/wave_noise.hpp"

namespace truenorth::plant {

class InertialSensor {
  public:
    struct Errors {
        Eigen::Vector3d bias = Eigen::Vector3d::Zero();  // [u/s]
        double bias_sigma = 0.0;                         // of the part that is drawn for each run [u/s]
        double bias_limit = 0.0;                         // of a part that is drawn uniformly within it [u/s]
        double bias_random_walk = 0.0;                   // of the bias, from 0 on [u/s^1.5]
        double white_noise = 0.0;                        // density [u/s^0.5]
        double markov_sigma = 0.0;                       // [u/s]
        double markov_time = 1.0;                        // [s]
        double wave_sigma = 0.0;                         // [u/s]
        double wave_period = 1.0;                        // [s]
        double wave_damping = 0.1;
        Eigen::Vector3d scale_factor = Eigen::Vector3d::Zero();
        Eigen::Vector3d misalignment = Eigen::Vector3d::Zero();  // [rad]
        double quantisation = 0.0;                               // one count of the increments [u]; 0: off
        Eigen::Vector3d bias_step = Eigen::Vector3d::Zero();     // [u/s]
        double bias_step_time = 0.0;                             // [s]
        double bias_step_duration = 0.0;                         // [s]; 0: for ever
    };

    struct Streams {
        NoiseStream bias, walk, white, markov, wave;
    };

    struct State {
        Eigen::Vector3d walk = Eigen::Vector3d::Zero();  // of the bias [u/s]
        GaussMarkov::State markov = GaussMarkov::State::Zero();
        WaveNoise::State wave = WaveNoise::State::Zero();
        Eigen::Vector3d remainder = Eigen::Vector3d::Zero();  // what the quantiser has not put out yet [u]

        template <class Archive>
        void serialize(Archive& archive) {
            archive(walk, markov, wave, remainder);
        }
    };

    InertialSensor(const Errors& errors, double period, const Streams& streams);

    [[nodiscard]] State begin() const {
        return {.walk = Eigen::Vector3d::Zero(),
                .markov = markov_.begin(),
                .wave = wave_.begin(),
                .remainder = Eigen::Vector3d::Zero()};
    }

    // Measured increment [u] of sample number `sample` (1, 2, ...), which ends at `time`.
    [[nodiscard]] Eigen::Vector3d measure(State& state, std::uint64_t sample, double time,
                                          const Eigen::Vector3d& true_increment) const;

    // What is slow in the error [u/s], mean over the sample that ends at `time`: fixed and drawn bias and
    // their random walk, bias step, Gauss-Markov noise.
    [[nodiscard]] Eigen::Vector3d slow_error(const State& state, double time) const;

  private:
    // Share of the sample that ends at `time` in which the bias step is on.
    [[nodiscard]] double stepped(double time) const;

    Eigen::Matrix3d gain_;
    Eigen::Vector3d bias_;
    Eigen::Vector3d bias_step_;
    double bias_step_time_;
    double bias_step_duration_;
    double period_;
    double walk_sigma_;   // of a sample [u/s]
    double white_sigma_;  // of an increment
    double quantisation_;
    NoiseStream walk_;
    NoiseStream white_;
    GaussMarkov markov_;
    WaveNoise wave_;
};

}  // namespace truenorth::plant
