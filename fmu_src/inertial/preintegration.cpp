#include "inertial/preintegration.hpp"

#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

namespace {

// Rows and columns of the bias Jacobian.
constexpr int kRotation = 0;
constexpr int kVelocity = 3;
constexpr int kPosition = 6;
constexpr int kGyro = 0;
constexpr int kAccelerometer = 3;

}  // namespace

Preintegration Preintegration::of(const ImuIncrement& previous, const ImuIncrement& increment) {
    const double dt = increment.dt;
    const BodyMotion motion = body_motion(previous, increment);
    const Eigen::Matrix3d force_impulse = skew(motion.delta_velocity);

    Preintegration sum;
    sum.duration = dt;
    sum.change = {.attitude = quaternion(motion.rotation),
                  .velocity = motion.delta_velocity,
                  .position = 0.5 * dt * motion.delta_velocity};
    auto& J = sum.bias_jacobian;
    J.block<3, 3>(kRotation, kGyro) = -dt * left_jacobian(-motion.rotation);
    J.block<3, 3>(kVelocity, kGyro) = 0.5 * dt * force_impulse;
    J.block<3, 3>(kPosition, kGyro) = dt * dt / 6.0 * force_impulse;
    // The body turns while the force acts: at half of the rotation on the mean, at a third weighted by the
    // time that is left.
    const Eigen::Matrix3d turned = skew(motion.rotation);
    J.block<3, 3>(kVelocity, kAccelerometer) = -dt * (Eigen::Matrix3d::Identity() + turned / 2.0);
    J.block<3, 3>(kPosition, kAccelerometer) = -0.5 * dt * dt * (Eigen::Matrix3d::Identity() + turned / 3.0);
    return sum;
}

Preintegration operator*(const Preintegration& a, const Preintegration& b) {
    const Eigen::Matrix3d R = a.change.attitude.toRotationMatrix();
    const auto turn = a.bias_jacobian.middleRows<3>(kRotation);
    Preintegration sum;
    sum.duration = a.duration + b.duration;
    sum.change = a.change * b.change;
    sum.change.position += b.duration * a.change.velocity;
    auto& J = sum.bias_jacobian;
    J.middleRows<3>(kRotation) =
        b.change.attitude.conjugate().toRotationMatrix() * turn + b.bias_jacobian.middleRows<3>(kRotation);
    J.middleRows<3>(kVelocity) =
        a.bias_jacobian.middleRows<3>(kVelocity) +
        R * (b.bias_jacobian.middleRows<3>(kVelocity) - skew(b.change.velocity) * turn);
    J.middleRows<3>(kPosition) =
        a.bias_jacobian.middleRows<3>(kPosition) + b.duration * a.bias_jacobian.middleRows<3>(kVelocity) +
        R * (b.bias_jacobian.middleRows<3>(kPosition) - skew(b.change.position) * turn);
    return sum;
}

ExtendedPose Preintegration::corrected(const Eigen::Matrix<double, 6, 1>& bias) const {
    const ExtendedPose::Tangent shift = bias_jacobian * bias;
    return {.attitude = change.attitude * quaternion(shift.head<3>()),
            .velocity = change.velocity + shift.segment<3>(kVelocity),
            .position = change.position + shift.tail<3>()};
}

ExtendedPose carried(const ExtendedPose& start, const ExtendedPose& change, double duration) {
    const double T = duration;
    // Gravitation is that of the middle of the path; the centres of its integrals lie T / 2 and 2 T / 3
    // before the end.
    const Eigen::Vector3d earth_velocity = start.velocity - earth::earth_fixed_rate().cross(start.position);
    const Eigen::Vector3d G = earth::gravitation(start.position + 0.5 * T * earth_velocity);
    const Eigen::Quaterniond turn = earth::turn(T);
    const ExtendedPose inertial = start * change;
    return {.attitude = (turn * inertial.attitude).normalized(),
            .velocity = turn * inertial.velocity + T * (earth::turn(T / 2.0) * G),
            .position = turn * (inertial.position + T * start.velocity) +
                        0.5 * T * T * (earth::turn(2.0 * T / 3.0) * G)};
}

}  // namespace truenorth
