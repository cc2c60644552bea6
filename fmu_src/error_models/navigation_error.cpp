#include "error_models/navigation_error.hpp"

namespace truenorth::navigation_error {

using Eigen::Matrix3d;
using Eigen::Vector3d;

NavigationState retract(const NavigationState& x, const Error& error) {
    return {.q_bn = (quaternion(-error.segment<3>(kPhi)) * x.q_bn).normalized(),
            .velocity = x.velocity + error.segment<3>(kVelocity),
            .position = earth::displaced(x.position, error.segment<3>(kPosition))};
}

Error local(const NavigationState& x, const NavigationState& computed) {
    Error error;
    error << -rotation_vector(computed.q_bn * x.q_bn.conjugate()), computed.velocity - x.velocity,
        earth::displacement(x.position, computed.position);
    return error;
}

Matrix<kCount> jacobian(const NavigationInterval& interval) {
    const Vector3d& v = interval.velocity;
    const Vector3d& w_ie = interval.omega_ie;
    const Vector3d& w_en = interval.omega_en;
    const Matrix3d T = interval.transport();
    const double per_R_M = interval.per_meridian_radius;
    const double per_R_N = interval.per_prime_vertical_radius;
    const double tan = interval.tan_latitude;

    // dw_ie and dw_en of a displacement.
    const Matrix3d earth_rate = skew(w_ie) * T;
    Matrix3d transport_rate = Matrix3d::Zero();  // dT v
    transport_rate.col(2) << v.y() * per_R_M * per_R_M, -v.x() * per_R_N * per_R_N,
        -v.x() * tan * per_R_N * per_R_N;
    transport_rate(2, 1) = v.x() * (1.0 + tan * tan) * per_R_N * per_R_M;

    Matrix<kCount> F = Matrix<kCount>::Zero();
    F.block<3, 3>(kPhi, kPhi) = -skew(w_ie + w_en);
    F.block<3, 3>(kPhi, kVelocity) = T;
    F.block<3, 3>(kPhi, kPosition) = earth_rate + transport_rate;
    F.block<3, 3>(kVelocity, kPhi) = skew(interval.force);
    F.block<3, 3>(kVelocity, kVelocity) = interval.coriolis();
    F.block<3, 3>(kVelocity, kPosition) = skew(v) * (2.0 * earth_rate + transport_rate);
    F(kVelocity + 2, kPosition + 2) += 2.0 * interval.gravity * per_R_M;
    F.block<3, 3>(kPosition, kVelocity).setIdentity();
    F.block<3, 3>(kPosition, kPosition) = -skew(w_en) - skew(v) * T;
    return F;
}

Error random_walk_variance(double angle_random_walk, double velocity_random_walk, double dt) {
    Error variance = Error::Zero();
    variance.segment<3>(kPhi).setConstant(dt * angle_random_walk * angle_random_walk);
    variance.segment<3>(kVelocity).setConstant(dt * velocity_random_walk * velocity_random_walk);
    return variance;
}

// exp(r x) = exp((phi + d) x) exp(-phi x) = exp((J d) x). A phi of more than half a turn, of which these
// equations know nothing, counts as the rotation that it is: J comes near to singular at whole turns, and
// would make certain what is lost.
Matrix<kCount> correction_jacobian(const Error& error) {
    Matrix<kCount> G = Matrix<kCount>::Identity();
    G.block<3, 3>(kPhi, kPhi) = left_jacobian(rotation_vector(quaternion(error.segment<3>(kPhi))));
    return G;
}

}  // namespace truenorth::navigation_error
