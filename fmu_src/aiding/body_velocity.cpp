#include "aiding/body_velocity.hpp"

#include "inertial/attitude.hpp"

namespace truenorth::aiding {

Observation<3> body_velocity(const Moment& moment, const Eigen::Vector3d& lever_arm,
                             const Eigen::Vector3d& measured) {
    const NavigationState& state = moment.state;
    const Eigen::Matrix3d C_nb = state.q_bn.toRotationMatrix().transpose();
    Observation<3> observation{
        .difference = C_nb * state.velocity + moment.omega_eb_b.cross(lever_arm) - measured,
        .sensitivity = Matrix<3, kErrors>::Zero()};
    observation.sensitivity.block<3, 3>(0, kMisalignment) = -C_nb * skew(state.velocity);
    observation.sensitivity.block<3, 3>(0, kVelocity) = C_nb;
    observation.sensitivity.block<3, 3>(0, kGyro) = -skew(lever_arm);
    return observation;
}

}  // namespace truenorth::aiding
