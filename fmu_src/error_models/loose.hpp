// Loosely coupled integration, 15 states: the model of Li, eqs. 19-22. Misprints there: the blocks of eqs.
// 20-22 make 18 columns, eq. 20 equates a difference of positions in radians to metres, and the differences
// are in the order north, east where the states are east, north. Position errors are metres here.
//
// Misalignment, velocity and position errors move by the equations of navigation_error.hpp, driven by
// constant gyro and accelerometer biases eps and nabla. Every error is computed (measured) minus true. The
// measurement is the antenna's position [m] and velocity by the mechanisation minus those of the GNSS
// receiver.
#pragma once

#include "error_models/antenna.hpp"
#include "error_models/vector_model.hpp"

namespace truenorth {

class Loose {
  public:
    enum StateIndex {  // the first of three components: east, north, up or right, forward, up
        kPhi = navigation_error::kPhi,            // misalignment [rad]
        kVelocity = navigation_error::kVelocity,  // [m/s]
        kPosition = navigation_error::kPosition,  // [m]
        kGyro = 9,                                // eps, body [rad/s]
        kAccelerometer = 12,                      // nabla, body [m/s2]
        kStates = 15
    };
    static constexpr int kMeasurements = 6;
    using State = Vector<kStates>;

    struct Noise {
        double angle_random_walk;          // gyro [rad/s^0.5]
        double velocity_random_walk;       // accelerometer [m/s^1.5]
        double gyro_random_walk;           // of eps [rad/s^1.5]; 0: constant
        double accelerometer_random_walk;  // of nabla [m/s^2.5]; 0: constant
        Eigen::Vector3d position_sigma;    // GNSS, east, north, up [m]
        Eigen::Vector3d velocity_sigma;    // [m/s]
    };

    // The trusted velocity is that of the mechanisation less the estimate of its error.
    struct Interval : NavigationInterval {
        Interval(const IntervalAverage& average, const earth::Position& position, const State& x);
    };

    // A GNSS position and velocity, seen from the mechanisation: of the antenna, INS minus GNSS, ENU.
    struct Fix {
        Eigen::Vector3d position_difference;  // [m]
        Eigen::Vector3d velocity_difference;  // [m/s]
        Antenna antenna;
    };

    Discretisation discretisation = Discretisation::runge_kutta;
    Noise noise{};

    [[nodiscard]] static State retract(const State& x, const State& deviation) { return x + deviation; }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Interval& interval) const {
        propagate_linearly(*this, x, deviations, interval);
    }

    [[nodiscard]] Matrix<kStates> transition(const State& x, const Interval& interval) const;

    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    [[nodiscard]] static Vector<kMeasurements> residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Matrix<kMeasurements> measurement_noise(const State& x, const Fix& fix) const;

    // F of x' = F x.
    [[nodiscard]] static Matrix<kStates> jacobian(const State& x, const Interval& interval);

    // The navigation state corrected by the estimate.
    [[nodiscard]] static NavigationState corrected(const NavigationState& computed, const State& x);

    // Jacobian of the errors that remain, when `corrected` and both biases have been fed back, with respect
    // to the errors.
    [[nodiscard]] static Matrix<kStates> reset_jacobian(const State& x);
};

}  // namespace truenorth
