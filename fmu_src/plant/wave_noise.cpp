#include "plant/wave_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "elementary/exponential.hpp"
#include "elementary/sincos.hpp"

namespace truenorth::plant {

WaveNoise::WaveNoise(double sigma, double peak_period, double damping, double period, NoiseStream stream)
    : sigma_(sigma), stream_(stream) {
    const double angle = 2.0 * std::numbers::pi * period / peak_period;
    const double damped_angle = angle * std::sqrt(1.0 - damping * damping);
    // Phi = exp(A dt), A dt = angle [0 1; -1 -2 damping] = -damping angle I + N with N^2 = -damped_angle^2 I.
    Eigen::Matrix2d N;
    N << damping * angle, angle, -angle, -damping * angle;
    const auto [sine, cosine] = sincos(damped_angle);
    transition_ =
        exponential(-damping * angle) * (cosine * Eigen::Matrix2d::Identity() + (sine / damped_angle) * N);
    // Stationary covariance sigma^2 I = Phi sigma^2 I Phi' + D D'. Short samples leave little of it, hence
    // max.
    const Eigen::Matrix2d added = Eigen::Matrix2d::Identity() - transition_ * transition_.transpose();
    const double q = std::sqrt(added(1, 1));
    const double p_with_q = added(0, 1) / q;
    drive_ << std::sqrt(std::max(0.0, added(0, 0) - p_with_q * p_with_q)), p_with_q, 0.0, q;
    drive_ *= sigma;
}

WaveNoise::State WaveNoise::draw(std::uint64_t sample) const {
    State normal;
    normal << stream_.normal(2 * sample).transpose(), stream_.normal(2 * sample + 1).transpose();
    return normal;
}

}  // namespace truenorth::plant
