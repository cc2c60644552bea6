#include "aiding/heading.hpp"

#include "inertial/attitude.hpp"

namespace truenorth::aiding {

Eigen::RowVector3d heading_gradient(const Eigen::Quaterniond& q_bn) {
    const Eigen::Vector3d forward = q_bn * Eigen::Vector3d::UnitY();
    const double level = forward.head<2>().squaredNorm();
    if (level < 1e-12) {
        return Eigen::RowVector3d::Zero();
    }
    return {-forward.x() * forward.z() / level, -forward.y() * forward.z() / level, 1.0};
}

Observation heading(const Moment& moment, double measured) {
    const Eigen::Quaterniond& q_bn = moment.state.q_bn;
    const double difference =
        wrap_angle(euler_angles(q_bn.toRotationMatrix()).heading + moment.sensors(kHeadingBias) - measured);
    constexpr double kLevelEnough = 0.03;  // cos^2 of 80 degrees
    const bool defined = (q_bn * Eigen::Vector3d::UnitY()).head<2>().squaredNorm() > kLevelEnough;
    Observation observation;
    if (defined) {
        observation.difference = Observation::single(difference);
    }
    observation.sensitivity.block<1, 3>(0, kMisalignment) = heading_gradient(q_bn);
    observation.own(0, kHeadingBias) = -1.0;
    return observation;
}

}  // namespace truenorth::aiding
