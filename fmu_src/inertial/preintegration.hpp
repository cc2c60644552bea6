// IMU increments over an interval, summed up once for every start: preintegration on SE_2(3) (Brossard et al.
// 2021).
//
// In an inertial frame the extended pose (R, v, p) at the end of an interval of length T follows from that at
// its start as
//
//     R+ = R dR,    v+ = v + R dv + (gravitation),    p+ = p + T v + R dp + (gravitation),
//
// where dR, dv, dp are integrals of the IMU data alone: no attitude, place or velocity enters. Sensor biases
// enter to first order, which over a filter interval is exact to (bias T)^2.
#pragma once

#include "inertial/extended_pose.hpp"
#include "inertial/mechanisation.hpp"

namespace truenorth {

struct Preintegration {
    // Columns: gyro bias [rad/s], accelerometer bias [m/s2]. Rows: rotation, velocity, position.
    using BiasJacobian = Eigen::Matrix<double, 9, 6>;

    double duration = 0.0;                              // T [s]
    ExtendedPose change;                                // dR, dv [m/s], dp [m], for sensors without bias
    BiasJacobian bias_jacobian = BiasJacobian::Zero();  // with biases: dR exp(J_R b), dv + J_v b, dp + J_p b

    // Over one increment; `previous` is the one before it.
    static Preintegration of(const ImuIncrement& previous, const ImuIncrement& increment);

    // Over a, then b.
    friend Preintegration operator*(const Preintegration& a, const Preintegration& b);

    // dR, dv, dp as sensors with these biases should have given them.
    [[nodiscard]] ExtendedPose corrected(const Eigen::Matrix<double, 6, 1>& bias) const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(duration, change, bias_jacobian);
    }
};

// The extended pose after `duration` [s], from that at the start and the increments dR, dv, dp. Poses are in
// Earth-fixed axes: attitude from body to these, velocity relative to an inertial frame, position from the
// Earth's centre. Without increments: a body in free fall.
ExtendedPose carried(const ExtendedPose& start, const ExtendedPose& change, double duration);

}  // namespace truenorth
