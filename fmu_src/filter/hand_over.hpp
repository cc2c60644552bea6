// The covariance that one filter hands to another: twelve states, whatever the models have besides, in the
// order attitude, velocity (east, north, up), gyro bias, accelerometer bias (right, forward, up).
#pragma once

#include <array>

#include "filter/adapter.hpp"

namespace truenorth {

inline constexpr int kHandedStates = 12;
using HandedCovariance = Matrix<kHandedStates>;

// Where a model has each of them; -1: it has not.
template <class Where>
constexpr std::array<int, kHandedStates> handed_states() {
    std::array<int, kHandedStates> states{};
    const std::array<Block, 4> blocks{Where::attitude, Where::velocity, Where::gyro, Where::accelerometer};
    for (int i = 0; i < kHandedStates; ++i) {
        const Block block = blocks[i / 3];
        states[i] = i % 3 < block.count ? block.first + i % 3 : -1;
    }
    return states;
}

// Of a filter whose covariance is P; what its model lacks is as uncertain as the prior says.
template <class Where, int N, class Parameters>
HandedCovariance handed_covariance(const Matrix<N>& P, const Parameters& p) {
    constexpr auto states = handed_states<Where>();
    const std::array<double, 4> prior{0.0, p.prior.velocity_sigma, p.prior.gyro_bias_sigma,
                                      p.prior.accelerometer_bias_sigma};
    HandedCovariance handed = HandedCovariance::Zero();
    for (int i = 0; i < kHandedStates; ++i) {
        if (states[i] < 0) {
            handed(i, i) = prior[i / 3] * prior[i / 3];
            continue;
        }
        for (int j = 0; j < kHandedStates; ++j) {
            handed(i, j) = states[j] < 0 ? 0.0 : P(states[i], states[j]);
        }
    }
    return handed;
}

// Into the covariance P of a filter; the states that are not handed over keep what they have.
template <class Where, int N>
void take_covariance(Matrix<N>& P, const HandedCovariance& handed) {
    constexpr auto states = handed_states<Where>();
    for (int i = 0; i < kHandedStates; ++i) {
        for (int j = 0; j < kHandedStates; ++j) {
            if (states[i] >= 0 && states[j] >= 0) {
                P(states[i], states[j]) = 0.5 * (handed(i, j) + handed(j, i));
            }
        }
    }
}

}  // namespace truenorth
