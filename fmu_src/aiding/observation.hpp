// What an aid says of a navigation state, whatever the model that estimates its errors: by how much its
// measurement differs, how that depends on the errors of the state, and how good it is. A model says how its
// states make these errors; the aid then is a measurement of the model.
//
// Errors are computed minus true: misalignment phi, C_b^{n'} = (I - phi x) C_b^n [rad], velocity [m/s] and
// position [m], east, north, up; then what gyros [rad/s] and accelerometers [m/s2] measure too much, body.
#pragma once

#include <cmath>

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

// The state of the IMU at the time of a measurement.
struct Moment {
    NavigationState state;
    Eigen::Vector3d omega_eb_b = Eigen::Vector3d::Zero();  // body rate relative to the Earth [rad/s]
};

template <int K>
struct Observation {
    Vector<K> difference;            // predicted minus measured
    Matrix<K, kErrors> sensitivity;  // of the prediction, to the errors of the state
};

// As a measurement of a model whose N states, of covariance P, make the errors `errors` times the states.
// `unmodelled`: covariance of what else is in the difference. A component that is not a number has not been
// measured.
template <int N, int K>
Innovation<N, K> innovation_of(const Observation<K>& observation, const Vector<K>& sigma,
                               const Matrix<kErrors, N>& errors, const Matrix<N>& P,
                               const Matrix<K>& unmodelled = Matrix<K>::Zero()) {
    const Matrix<K, N> H = observation.sensitivity * errors;
    const Matrix<N, K> cross = P * H.transpose();
    Matrix<K> spread = H * cross;
    symmetrise(spread);
    Matrix<K> noise = unmodelled;
    noise.diagonal() += sigma.cwiseAbs2();
    Innovation<N, K> innovation{observation.difference, spread, noise, cross};
    for (int i = 0; i < K; ++i) {
        if (std::isnan(observation.difference(i))) {
            innovation.remove(i);
        }
    }
    return innovation;
}

}  // namespace truenorth::aiding
