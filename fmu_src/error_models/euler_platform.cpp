#include "error_models/euler_platform.hpp"

#include "estimation/model.hpp"

namespace truenorth {

static_assert(ErrorModel<EulerPlatform> && NoiseInside<EulerPlatform>);

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Matrix3d inverse_euler_rate_matrix(Misalignment form, const Vector3d& alpha) {
    if (form != Misalignment::large) {
        return Matrix3d::Identity();
    }
    return euler_rate_matrix(alpha).inverse();
}

// d(C_w^-1 turn)/d alpha for a constant `turn`.
Matrix3d derivative_of_euler_rates(const Vector3d& alpha, const Vector3d& turn) {
    const auto [sx, cx] = sincos(alpha.x());
    const auto [sy, cy] = sincos(alpha.y());
    const double tx = sx / cx;
    const double about_x = cy * turn.x() + sy * turn.z();
    const double about_z = cy * turn.z() - sy * turn.x();
    Matrix3d derivative;
    derivative << 0.0, about_z, 0.0,              //
        -about_z / (cx * cx), tx * about_x, 0.0,  //
        about_z * tx / cx, -about_x / cx, 0.0;
    return derivative;
}

}  // namespace

EulerPlatform::Interval::Interval(const IntervalAverage& average, const earth::Position& position,
                                  const State& /*x*/)
    : NavigationInterval(average, position, average.velocity()) {}

Matrix<EulerPlatform::kStates> EulerPlatform::transition(const State& x, const Interval& interval) const {
    return vector_transition(*this, x, interval);
}

Matrix<EulerPlatform::kStates> EulerPlatform::process_noise(const State& x, const Interval& interval) const {
    const Matrix3d rates = inverse_euler_rate_matrix(form, x.segment<3>(kAlphaX));
    Matrix<kStates> Q = Matrix<kStates>::Zero();
    Q.block<3, 3>(kAlphaX, kAlphaX) =
        interval.dt * noise.angle_random_walk * noise.angle_random_walk * rates * rates.transpose();
    Q.diagonal()
        .segment<3>(kVelocityEast)
        .setConstant(interval.dt * noise.velocity_random_walk * noise.velocity_random_walk);
    return Q;
}

Vector3d EulerPlatform::residual(const State& x, const Fix& fix) {
    return fix.velocity - x.segment<3>(kVelocityEast);
}

Matrix<EulerPlatform::kMeasurements, EulerPlatform::kStates> EulerPlatform::measurement_matrix(
    const State& /*x*/, const Fix& /*fix*/) {
    Matrix<kMeasurements, kStates> H = Matrix<kMeasurements, kStates>::Zero();
    H.middleCols<3>(kVelocityEast).setIdentity();
    return H;
}

Matrix3d EulerPlatform::measurement_noise(const State& /*x*/, const Fix& /*fix*/) const {
    return noise.velocity_sigma * noise.velocity_sigma * Matrix3d::Identity();
}

Matrix<EulerPlatform::kStates> EulerPlatform::jacobian(const State& x, const Interval& interval) const {
    const Vector3d alpha = x.segment<3>(kAlphaX);
    const Vector3d dv = x.segment<3>(kVelocityEast);
    const Vector3d w = interval.omega_ie + interval.omega_en;
    const Matrix3d T = interval.transport();
    const Matrix3d rates = inverse_euler_rate_matrix(form, alpha);

    Matrix<kStates> F;
    F.block<3, 3>(kAlphaX, kAlphaX) = -rates * derivative_of_product(form, alpha, w);
    if (form == Misalignment::large) {
        const Vector3d turn = w - misalignment_matrix(form, alpha) * w + T * dv;
        F.block<3, 3>(kAlphaX, kAlphaX) += derivative_of_euler_rates(alpha, turn);
    }
    F.block<3, 3>(kAlphaX, kVelocityEast) = rates * T;
    F.block<3, 3>(kVelocityEast, kAlphaX) =
        velocity_form == VelocityForm::vertical_force
            ? derivative_of_product(form, alpha, {0.0, 0.0, interval.gravity})
            : Matrix3d(-derivative_of_transposed_product(form, alpha, interval.force));
    F.block<3, 3>(kVelocityEast, kVelocityEast) = interval.coriolis(dv);
    return F;
}

NavigationState EulerPlatform::corrected(const NavigationState& computed, const State& x) {
    NavigationState state = realigned(computed, x.segment<3>(kAlphaX));
    state.velocity -= x.segment<3>(kVelocityEast);
    return state;
}

Matrix<EulerPlatform::kStates> EulerPlatform::reset_jacobian(const State& x) {
    Matrix<kStates> G = Matrix<kStates>::Identity();
    G.block<3, 3>(kAlphaX, kAlphaX) = realignment_jacobian(x.segment<3>(kAlphaX));
    return G;
}

void EulerPlatform::damp(NavigationState& computed, State& x) {
    computed.velocity -= x.segment<3>(kVelocityEast);
    x.segment<3>(kVelocityEast).setZero();
}

}  // namespace truenorth
