#include "aiding/standstill.hpp"

#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth::aiding {

Observation standing(const Moment& moment) {
    const NavigationState& state = moment.state;
    const Eigen::Matrix3d C_nb = state.q_bn.toRotationMatrix().transpose();
    const Eigen::Vector3d velocity = C_nb * state.velocity;
    Observation observation{.difference = velocity, .is_velocity = true, .turns = velocity};
    observation.sensitivity.block<3, 3>(0, kMisalignment) = -C_nb * skew(state.velocity);
    observation.sensitivity.block<3, 3>(0, kVelocity) = C_nb;
    return observation;
}

Observation not_turning(const Moment& moment, const Eigen::Vector3d& rate) {
    const Eigen::Matrix3d C_nb = moment.state.q_bn.toRotationMatrix().transpose();
    const Eigen::Vector3d omega_ie = earth::rate(moment.state.position.latitude);
    const Eigen::Vector3d earth_rate = C_nb * omega_ie;
    Observation observation{.difference = earth_rate + moment.gyro_bias - rate, .turns = earth_rate};
    observation.sensitivity.block<3, 3>(0, kMisalignment) = -C_nb * skew(omega_ie);
    observation.sensitivity.block<3, 3>(0, kGyro) = -Eigen::Matrix3d::Identity();
    return observation;
}

}  // namespace truenorth::aiding
