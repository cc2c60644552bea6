// Full nonlinear model, 9 states: attitude, velocity and position driven by the IMU (Jing 2023, eqs. 1, 2).
//
// The state is the navigation state itself, and f of eq. 1 is the mechanisation: each sigma point is a
// deviation [phi, velocity, position in metres] applied to the state, mechanised, and the moved centre taken
// off again. No bias states.
//
// Jing 2023 names roll, pitch and heading as the states of attitude. Their differences jump where heading
// wraps, and lose a degree of freedom at a pitch of 90 degrees; the rotation vector phi of
// navigation_error.hpp takes their place. Nothing else changes: it describes the same attitude, the mean and
// the covariance are formed on deviations, and the measurement does not contain the attitude but by the lever
// arm. Misprint of Jing 2023: its flight starts at 29 E, 118 N (section 3), longitude and latitude swapped.
#pragma once

#include <algorithm>

#include "error_models/antenna.hpp"
#include "error_models/neighbours.hpp"
#include "estimation/integration.hpp"

namespace truenorth {

class FullState {
  public:
    enum StateIndex {                   // of deviations: the first of three components, east, north, up
        kPhi = navigation_error::kPhi,  // [rad]
        kVelocity = navigation_error::kVelocity,  // [m/s]
        kPosition = navigation_error::kPosition,  // [m]
        kStates = navigation_error::kCount
    };
    static constexpr int kMeasurements = 6;
    using State = NavigationState;
    using Deviation = Vector<kStates>;

    struct Noise {
        double angle_random_walk;        // gyro [rad/s^0.5]
        double velocity_random_walk;     // accelerometer [m/s^1.5]
        Eigen::Vector3d position_sigma;  // GNSS, east, north, up [m]
        Eigen::Vector3d velocity_sigma;  // [m/s]
    };

    // One IMU increment, and the mechanisation as the increment before has left it: its memory gives the
    // two-sample terms; the states come from the filter.
    struct Interval {
        Mechanisation mechanisation;
        ImuIncrement increment;
    };

    // A GNSS position and velocity of the antenna. One that is older than the state is to be moved by what
    // the antenna has moved since. H is that of now: that a misalignment phi makes an error phi x f L of the
    // velocity gained in the latency L is neglected, 0.035 m/s for 2 degrees, 5 m/s2 and 0.2 s.
    struct Fix {
        earth::Position position;
        Eigen::Vector3d velocity;    // ENU [m/s]
        Eigen::Vector3d lever_arm;   // body [m]
        Eigen::Vector3d omega_eb_b;  // body rate relative to the Earth [rad/s]
    };

    Noise noise{};

    [[nodiscard]] static State retract(const State& x, const Deviation& deviation) {
        return navigation_error::retract(x, deviation);
    }
    [[nodiscard]] static Deviation local(const State& x, const State& other) {
        return navigation_error::local(x, other);
    }

    [[nodiscard]] static State moved(const State& x, const Interval& interval) {
        return mechanised(x, interval).state;
    }

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Interval& interval) const {
        constexpr int few = std::min(Count, Neighbours::kLanes);
        const Neighbours neighbours(x, interval.mechanisation, interval.increment);
        const Points<kStates, Count> start = deviations;
        Neighbours::Deviations lanes = Neighbours::Deviations::Zero();
        for (int next = 0; next < Count; next += few) {
            const int first = std::min(next, Count - few);  // the last ones may have been moved before
            lanes.template leftCols<few>() = start.template middleCols<few>(first);
            deviations.template middleCols<few>(first) = neighbours.moved(lanes).template leftCols<few>();
        }
        x = neighbours.moved();
    }

    // Noise of attitude and velocity is that of the sensors: by it the increments of each point are wrong,
    // and no two of them share the motion of the body.
    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Points<kStates, Count>& noise,
                   const Interval& interval) const {
        const State start = x;
        x = mechanised(start, interval).state;
        for (int i = 0; i < Count; ++i) {
            const State point = retract(start, Deviation(deviations.col(i)));
            const Deviation wrong = noise.col(i);
            Interval noisy = interval;
            noisy.increment.delta_angle -= point.q_bn.conjugate() * wrong.segment<3>(kPhi);
            noisy.increment.delta_velocity += point.q_bn.conjugate() * wrong.segment<3>(kVelocity);
            deviations.col(i) = local(x, mechanised(point, noisy).state);
        }
    }

    [[nodiscard]] static Matrix<kStates> transition(const State& x, const Interval& interval);
    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    [[nodiscard]] static Vector<kMeasurements> residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Matrix<kMeasurements> measurement_noise(const State& x, const Fix& fix) const;

  private:
    [[nodiscard]] static Mechanisation mechanised(const State& x, const Interval& interval) {
        Mechanisation mechanisation = interval.mechanisation;
        mechanisation.state = x;
        mechanisation.advance(interval.increment);
        return mechanisation;
    }
};

}  // namespace truenorth
