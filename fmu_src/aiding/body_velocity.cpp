#include "aiding/body_velocity.hpp"

#include "inertial/attitude.hpp"

namespace truenorth::aiding {

Observation body_velocity(const Moment& moment, const Eigen::Vector3d& lever_arm,
                          const Eigen::Vector3d& measured) {
    const NavigationState& state = moment.state;
    const Eigen::Matrix3d C_nb = state.q_bn.toRotationMatrix().transpose();
    const double scale = 1.0 + moment.sensors(kScale);
    const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity() - skew(moment.sensors.segment<3>(kBoresight));
    const Eigen::Matrix3d sensed = scale * axes;
    const Eigen::Vector3d w = C_nb * state.velocity + moment.omega_eb_b.cross(lever_arm);
    Observation observation{.difference = sensed * w - measured,
                            .is_velocity = true,
                            .turns = state.q_bn.conjugate() * state.velocity};
    observation.sensitivity.block<3, 3>(0, kMisalignment) = -sensed * C_nb * skew(state.velocity);
    observation.sensitivity.block<3, 3>(0, kVelocity) = sensed * C_nb;
    observation.sensitivity.block<3, 3>(0, kGyro) = -sensed * skew(lever_arm);
    observation.own.col(kScale) = -axes * w;
    observation.own.block<3, 3>(0, kBoresight) = -scale * skew(w);
    return observation;
}

}  // namespace truenorth::aiding
