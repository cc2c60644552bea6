// What an aid says of a navigation state, whatever the model that estimates its errors: by how much its
// measurement differs, how that depends on the errors of the state, and how good it is. A model says how its
// states make these errors; the aid then is a measurement of the model.
//
// Errors are computed minus true: misalignment phi, C_b^{n'} = (I - phi x) C_b^n [rad], velocity [m/s] and
// position [m], east, north, up; then what gyros [rad/s] and accelerometers [m/s2] measure too much, body.
#pragma once

#include <cmath>
#include <limits>

#include "estimation/appended.hpp"
#include "estimation/gaussian.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth::aiding {

enum NavigationErrors : int {  // the first of three components
    kMisalignment = 0,
    kVelocity = 3,
    kPosition = 6,
    kGyro = 9,
    kAccelerometer = 12,
    kErrors = 15
};

// Constant errors of the sensors, which are estimated beside the states of the model.
enum SensorErrors : int {
    kScale = 0,        // of body_velocity [-]
    kBoresight = 1,    // its axes against the body's, about right, forward, up [rad]
    kHeadingBias = 4,  // [rad]
    kHeightBias = 5,   // [m]
    kSensorErrors = 6
};
static_assert(kSensorErrors == Appended::kCount);

// The state of the IMU at the time of a measurement.
struct Moment {
    NavigationState state;
    Eigen::Vector3d omega_eb_b = Eigen::Vector3d::Zero();       // body rate relative to the Earth [rad/s]
    Appended::Constants sensors = Appended::Constants::Zero();  // errors of the sensors, as they are known
    Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();        // likewise of the gyros [rad/s]
};

// What one measurement has at most; what has fewer leaves the last out, as not measured.
inline constexpr int kChannels = 3;

struct Observation {
    Vector<kChannels> difference = not_measured();  // predicted minus measured
    // Of the prediction, to the errors of the state.
    Matrix<kChannels, kErrors> sensitivity = Matrix<kChannels, kErrors>::Zero();
    // Of the difference, to what the errors of the sensors are more than they are known to be.
    Matrix<kChannels, kSensorErrors> own = Matrix<kChannels, kSensorErrors>::Zero();
    bool is_velocity = false;  // in body axes
    // What of the prediction turns with the misalignment, in body axes: it is linear in small ones alone.
    Eigen::Vector3d turns = Eigen::Vector3d::Zero();

    static Vector<kChannels> not_measured() {
        return Vector<kChannels>::Constant(std::numeric_limits<double>::quiet_NaN());
    }

    // A measurement of one channel.
    static Vector<kChannels> single(double value) {
        Vector<kChannels> measured = not_measured();
        measured(0) = value;
        return measured;
    }
};

// As a measurement of N states of a model, and of constants of the sensor besides.
template <int N>
struct Sight {
    Innovation<N, kChannels> innovation;
    Matrix<kSensorErrors, kChannels> own;  // covariance of the constants and the prediction
};

// N states of the model, of covariance P, make the errors `errors` times the states. `unmodelled`: covariance
// of what else is in the difference. A component that is not a number has not been measured.
template <int N>
Sight<N> sight_of(const Observation& observation, const Vector<kChannels>& sigma,
                  const Matrix<kErrors, N>& errors, const Matrix<N>& P, const Appended& sensors,
                  const Matrix<kChannels>& unmodelled = Matrix<kChannels>::Zero()) {
    const Matrix<kChannels, N> H = observation.sensitivity * errors;
    const Matrix<kChannels, kSensorErrors>& L = observation.own;
    const Matrix<N, kSensorErrors> C = sensors.cross<N>();
    const Matrix<N, kChannels> cross = P * H.transpose() + C * L.transpose();
    Sight<N> sight{.innovation = {observation.difference, H * cross, unmodelled, cross},
                   .own = C.transpose() * H.transpose() + sensors.covariance() * L.transpose()};
    sight.innovation.spread += L * sight.own;
    symmetrise(sight.innovation.spread);
    sight.innovation.noise.diagonal() += sigma.cwiseAbs2();
    for (int i = 0; i < kChannels; ++i) {
        if (std::isnan(observation.difference(i))) {
            sight.innovation.remove(i);
            sight.own.col(i).setZero();
        }
    }
    return sight;
}

}  // namespace truenorth::aiding
