// Tightly coupled integration, 20 states: the model of Chen 2019, eqs. 1-3.
//
// Misalignment, velocity and position errors move by the equations of navigation_error.hpp, which Chen 2019
// lists in the other order; gyro errors are a constant (or a random walk) and a first-order Markov process,
// accelerometer errors a constant (or a random walk), the receiver's clock a bias b and a drift d in units of
// range, b' = d + w_b, d' = w_d. Errors are computed (measured) minus
// true. For satellite s with position r_s, velocity v_s in Earth-fixed axes, and the antenna at r, v:
//
//     pseudorange  |r_s - r| + clock bias
//     range rate   u . (v_s - v) + clock drift,        u = (r_s - r) / |r_s - r|
//
// the true r and v being those of the mechanisation less their errors. Lines of sight are resolved in ENU at
// the mechanised antenna. The distance is taken in Earth-fixed axes at the time of the fix: a receiver's
// satellite positions must be corrected for the signal's travel time beforehand.
//
// Chen 2019, eq. 2, has a nonlinear f, which it does not print. `Propagation::nonlinear` is that of the
// mechanisation, without approximation for errors of any size: with C = C_n^{n'} = exp(-phi x), primes on
// what is computed, and what is true at the position and velocity that the errors leave,
//
//     phi' = J_r(phi)^-1 (w_in' - C w_in - C_b^{n'} (eps_b + eps_r))
//     dv'  = f' - C^T (f' - C_b^{n'} nabla) + g' - g - (2 w_ie' + w_en') x v' + (2 w_ie + w_en) x v
//     dp'  = dv - w_en x dp + (T dp) x v
//
// `Propagation::linear` is its first order, F, which is also the Jacobian of the linearised predictor.
#pragma once

#include <array>

#include "error_models/antenna.hpp"
#include "error_models/vector_model.hpp"

namespace truenorth {

class Tight {
  public:
    enum StateIndex {  // blocks: the first of three components, east, north, up or right, forward, up
        kPhi = navigation_error::kPhi,            // misalignment [rad]
        kVelocity = navigation_error::kVelocity,  // [m/s]
        kPosition = navigation_error::kPosition,  // [m]
        kGyro = 9,                                // eps_b, body [rad/s]
        kGyroMarkov = 12,                         // eps_r, body [rad/s]
        kAccelerometer = 15,                      // nabla, body [m/s2]
        kClockBias = 18,                          // [m]
        kClockDrift = 19,                         // [m/s]
        kStates = 20
    };
    static constexpr int kChannels = 12;
    static constexpr int kMeasurements = 2 * kChannels;  // all pseudoranges, then all range rates
    using State = Vector<kStates>;
    using Mask = Eigen::Array<bool, kMeasurements, 1>;

    struct Noise {
        double angle_random_walk = 0.0;          // gyro [rad/s^0.5]
        double velocity_random_walk = 0.0;       // accelerometer [m/s^1.5]
        double gyro_random_walk = 0.0;           // of eps_b [rad/s^1.5]; 0: constant
        double gyro_markov_sigma = 0.0;          // of eps_r, stationary [rad/s]
        double gyro_markov_time = 3600.0;        // [s]
        double accelerometer_random_walk = 0.0;  // of nabla [m/s^2.5]; 0: constant
        double clock_bias_random_walk = 0.0;     // [m/s^0.5]
        double clock_drift_random_walk = 0.0;    // [m/s^1.5]
        double pseudorange_sigma = 0.0;          // [m]
        double range_rate_sigma = 0.0;           // [m/s]
    };

    // How states and deviations move between fixes.
    enum class Propagation { linear, nonlinear };

    // The trusted velocity is that of the mechanisation less the estimate of its error.
    struct Interval : NavigationInterval {
        Interval(const IntervalAverage& average, const earth::Position& position, const State& x);

        earth::Position computed_position;
        Eigen::Vector3d computed_velocity;  // [m/s]
    };

    struct Channel {
        bool valid = false;
        double pseudorange = 0.0;                                      // [m]
        double range_rate = 0.0;                                       // [m/s]
        Eigen::Vector3d satellite_position = Eigen::Vector3d::Zero();  // Earth-fixed [m]
        Eigen::Vector3d satellite_velocity = Eigen::Vector3d::Zero();  // [m/s]
    };

    // What the receiver measured, and where the mechanisation had the antenna then.
    struct Fix {
        std::array<Channel, kChannels> channels;
        earth::Position position;  // of the antenna
        Eigen::Vector3d velocity;  // of the antenna, ENU [m/s]
        Antenna antenna;
    };

    Propagation propagation = Propagation::linear;
    Discretisation discretisation = Discretisation::runge_kutta;
    Noise noise{};

    [[nodiscard]] static State retract(const State& x, const State& deviation) { return x + deviation; }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Interval& interval) const {
        if (propagation == Propagation::linear) {
            propagate_linearly(*this, x, deviations, interval);
        } else {
            propagate_vectors(*this, x, deviations, interval);
        }
    }

    // Noise adds to what moves linearly; so does that of the clock, which is exact for the end of the
    // interval.
    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Points<kStates, Count>& noise,
                   const Interval& interval) const {
        if (propagation == Propagation::linear) {
            propagate_linearly(*this, x, deviations, interval);
            deviations += noise;
        } else {
            Points<kStates, Count> inside = noise;
            inside.row(kClockBias).setZero();
            inside.row(kClockDrift).setZero();
            propagate_vectors(*this, x, deviations, inside, interval);
            deviations += noise - inside;
        }
    }

    [[nodiscard]] Matrix<kStates> transition(const State& x, const Interval& interval) const;

    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    // Which measurements the fix has; the others are predicted as zero.
    [[nodiscard]] static Mask present(const Fix& fix);
    [[nodiscard]] static Vector<kMeasurements> residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Matrix<kMeasurements> measurement_noise(const State& x, const Fix& fix) const;

    // The predicted measurement of retract(x, d) minus that of x for every column d: differences of ranges
    // without their 2e7 m.
    template <class Set>
    [[nodiscard]] static auto predicted(const State& x, const Set& deviations, const Fix& fix);

    // The nonlinear dx/dt of every column of x.
    template <class Set>
    [[nodiscard]] Set rate(const Set& x, const Interval& interval) const {
        Set rate;
        for (int i = 0; i < Set::ColsAtCompileTime; ++i) {
            rate.col(i) = rate_of(x.col(i), interval);
        }
        return rate;
    }

    // F of the linear x' = F x.
    [[nodiscard]] Matrix<kStates> jacobian(const State& x, const Interval& interval) const;

    // The navigation state corrected by the estimate.
    [[nodiscard]] static NavigationState corrected(const NavigationState& computed, const State& x);

    // What the estimate becomes when `corrected` and the biases have been fed back (Markov process
    // and clock stay in the filter), and the Jacobian of the remaining errors with respect to the errors.
    [[nodiscard]] static State remaining(const State& x);
    [[nodiscard]] static Matrix<kStates> reset_jacobian(const State& x);

  private:
    [[nodiscard]] State rate_of(const State& x, const Interval& interval) const;

    // From the antenna to a satellite, ENU at the mechanised antenna.
    struct Sight {
        Eigen::Vector3d line;      // [m]
        Eigen::Vector3d velocity;  // of the satellite relative to the antenna, Earth-fixed axes [m/s]
    };

    // Error of the antenna's position and velocity in Earth-fixed axes, resolved in ENU, of the state (6 x
    // 20).
    [[nodiscard]] static Matrix<6, kStates> antenna_error(const Fix& fix);
    [[nodiscard]] static std::array<Sight, kChannels> sights(const State& x, const Fix& fix);
};

template <class Set>
auto Tight::predicted(const State& x, const Set& deviations, const Fix& fix) {
    constexpr int count = Set::ColsAtCompileTime;
    const Points<6, count> antenna = antenna_error(fix).lazyProduct(deviations);
    const std::array<Sight, kChannels> all = sights(x, fix);

    Points<kMeasurements, count> difference = Points<kMeasurements, count>::Zero();
    for (int i = 0; i < kChannels; ++i) {
        if (!fix.channels[i].valid) {
            continue;
        }
        const Sight& sight = all[i];
        const double range = sight.line.norm();
        const Eigen::Vector3d u = sight.line / range;
        for (int k = 0; k < count; ++k) {
            const Eigen::Vector3d shift = antenna.col(k).template head<3>();
            const Eigen::Vector3d velocity_shift = antenna.col(k).template tail<3>();
            // |a + d| - |a| = d (2 a + d) / (|a + d| + |a|)
            const double new_range = (sight.line + shift).norm();
            const double stretch = shift.dot(2.0 * sight.line + shift) / (new_range + range);
            const Eigen::Vector3d turn = (shift - stretch * u) / new_range;  // of u
            difference(i, k) = stretch + deviations(kClockBias, k);
            difference(kChannels + i, k) = turn.dot(sight.velocity + velocity_shift) + u.dot(velocity_shift) +
                                           deviations(kClockDrift, k);
        }
    }
    return difference;
}

}  // namespace truenorth
