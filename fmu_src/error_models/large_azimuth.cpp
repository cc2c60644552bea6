#include "error_models/large_azimuth.hpp"

#include <cmath>

#include "estimation/model.hpp"

namespace truenorth {

static_assert(ErrorModel<LargeAzimuth>);

namespace {

using Index = LargeAzimuth::StateIndex;

// Derivative of the horizontal rows of C^T g with respect to (phi_e, phi_n, phi_u).
Matrix<2, 3> transposed_derivative(const LargeAzimuth::State& x, const Eigen::Vector3d& g) {
    const double c = std::cos(x(Index::kPhiUp));
    const double s = std::sin(x(Index::kPhiUp));
    const double C31 = x(Index::kPhiNorth) * c + x(Index::kPhiEast) * s;
    const double C32 = x(Index::kPhiNorth) * s - x(Index::kPhiEast) * c;
    Matrix<2, 3> D;
    D << s * g.z(), c * g.z(), -s * g.x() - c * g.y() - C32 * g.z(),  //
        -c * g.z(), s * g.z(), c * g.x() - s * g.y() + C31 * g.z();
    return D;
}

// The horizontal rows of C^T, eq. 13.
Matrix<2, 3> transposed_rows(const LargeAzimuth::State& x) {
    const double c = std::cos(x(Index::kPhiUp));
    const double s = std::sin(x(Index::kPhiUp));
    Matrix<2, 3> rows;
    rows << c, -s, x(Index::kPhiNorth) * c + x(Index::kPhiEast) * s,  //
        s, c, x(Index::kPhiNorth) * s - x(Index::kPhiEast) * c;
    return rows;
}

}  // namespace

LargeAzimuth::Interval::Interval(const IntervalAverage& average, const earth::Position& position,
                                 const State& x)
    : dt(average.duration()),
      C_bn(average.C_bn()),
      force(average.force()),
      velocity(average.velocity() - Eigen::Vector3d(x(kVelocityEast), x(kVelocityNorth), 0.0)),
      omega_ie(earth::rate(position.latitude)),
      omega_en(earth::transport_rate(position, velocity)),
      per_meridian_radius(1.0 / (earth::radii(position.latitude).meridian + position.height)),
      per_prime_vertical_radius(1.0 / (earth::radii(position.latitude).prime_vertical + position.height)),
      tan_latitude(std::tan(position.latitude)) {}

Matrix<LargeAzimuth::kStates> LargeAzimuth::process_noise(const State& /*x*/,
                                                          const Interval& interval) const {
    State variance = State::Zero();
    variance.segment<2>(kVelocityEast).setConstant(noise.velocity_random_walk * noise.velocity_random_walk);
    variance.segment<3>(kPhiEast).setConstant(noise.angle_random_walk * noise.angle_random_walk);
    return (interval.dt * variance).asDiagonal();
}

Eigen::Vector2d LargeAzimuth::residual(const State& x, const Fix& fix) {
    const Eigen::Vector2d lever = fix.lever_velocity.head<2>() - transposed_rows(x) * fix.lever_velocity;
    return fix.velocity_difference - (x.segment<2>(kVelocityEast) + lever);
}

Matrix<LargeAzimuth::kMeasurements, LargeAzimuth::kStates> LargeAzimuth::measurement_matrix(const State& x,
                                                                                            const Fix& fix) {
    Matrix<kMeasurements, kStates> H = Matrix<kMeasurements, kStates>::Zero();
    H.middleCols<2>(kVelocityEast).setIdentity();
    H.middleCols<3>(kPhiEast) = -transposed_derivative(x, fix.lever_velocity);
    return H;
}

Eigen::Matrix2d LargeAzimuth::measurement_noise(const State& /*x*/, const Fix& /*fix*/) const {
    return noise.velocity_sigma * noise.velocity_sigma * Eigen::Matrix2d::Identity();
}

Matrix<LargeAzimuth::kStates> LargeAzimuth::jacobian(const State& x, const Interval& interval) const {
    const double phi_e = x(kPhiEast);
    const double phi_n = x(kPhiNorth);
    const double c = std::cos(x(kPhiUp));
    const double s = std::sin(x(kPhiUp));
    const Eigen::Vector3d w = interval.omega_ie + interval.omega_en;
    const Eigen::Vector3d& f = interval.force;
    const Eigen::Vector3d& v = interval.velocity;

    // dw_en = transport * (dv_e, dv_n)
    Matrix<3, 2> transport;
    transport << 0.0, -interval.per_meridian_radius,  //
        interval.per_prime_vertical_radius, 0.0,      //
        interval.per_prime_vertical_radius * interval.tan_latitude, 0.0;

    Matrix<kStates> F = Matrix<kStates>::Zero();

    Eigen::Matrix3d misalignment;
    misalignment << 0.0, w.z(), s * w.x() - c * w.y(),  //
        -w.z(), 0.0, c * w.x() + s * w.y(),             //
        -s * w.x() + c * w.y(), -c * w.x() - s * w.y(),
        (phi_n * s - phi_e * c) * w.x() - (phi_n * c + phi_e * s) * w.y();
    F.block<3, 3>(kPhiEast, kPhiEast) = misalignment;
    F.block<3, 2>(kPhiEast, kVelocityEast) = transport;
    F.block<3, 3>(kPhiEast, kGyroX) = -interval.C_bn;

    Matrix<2, 3> force = Matrix<2, 3>::Zero();
    Matrix<2, 2> bias = interval.C_bn.topLeftCorner<2, 2>();
    switch (velocity_form) {
        case VelocityForm::transposed: {
            const Eigen::Vector3d nabla = interval.C_bn.leftCols<2>() * x.segment<2>(kAccelerometerX);
            force = -transposed_derivative(x, f - nabla);
            bias = transposed_rows(x) * interval.C_bn.leftCols<2>();
            break;
        }
        case VelocityForm::computed_force:
            force << 0.0, -f.z(), -s * f.x() + c * f.y(),  //
                f.z(), 0.0, -c * f.x() - s * f.y();
            break;
        case VelocityForm::vertical_force:
            force << 0.0, -f.z(), 0.0,  //
                f.z(), 0.0, 0.0;
            break;
        case VelocityForm::printed:
            force << 0.0, 0.0, -s * f.x() + c * f.y(),  //
                f.z(), 0.0, -c * f.x() - s * f.y();
            break;
    }
    F.block<2, 3>(kVelocityEast, kPhiEast) = force;
    F.block<2, 2>(kVelocityEast, kAccelerometerX) = bias;

    const double W_u = 2.0 * interval.omega_ie.z() + interval.omega_en.z();
    Matrix<2, 3> cross_v;  // horizontal rows of dw -> dw x v
    cross_v << 0.0, v.z(), -v.y(), -v.z(), 0.0, v.x();
    F.block<2, 2>(kVelocityEast, kVelocityEast) = -cross_v * transport;
    F(kVelocityEast, kVelocityNorth) += W_u;
    F(kVelocityNorth, kVelocityEast) -= W_u;
    return F;
}

Eigen::Matrix3d LargeAzimuth::misalignment_matrix(const State& x) {
    // Passive rotations: the transposes of the active ones about the same axes.
    using Eigen::AngleAxisd;
    using Eigen::Vector3d;
    return (AngleAxisd(-x(kPhiNorth), Vector3d::UnitY()) * AngleAxisd(-x(kPhiEast), Vector3d::UnitX()) *
            AngleAxisd(-x(kPhiUp), Vector3d::UnitZ()))
        .toRotationMatrix();
}

NavigationState LargeAzimuth::corrected(const NavigationState& computed, const State& x) {
    NavigationState state = computed;
    state.q_bn = Eigen::Quaterniond(misalignment_matrix(x).transpose()) * computed.q_bn;
    state.q_bn.normalize();
    state.velocity.head<2>() -= x.segment<2>(kVelocityEast);
    return state;
}

Matrix<LargeAzimuth::kStates> LargeAzimuth::reset_jacobian(const State& x) {
    // A change d of the error angles turns n' by C_w d (Zhao 2012 eq. 6), which C^T resolves in n''.
    const double sx = std::sin(x(kPhiEast));
    const double cx = std::cos(x(kPhiEast));
    const double sy = std::sin(x(kPhiNorth));
    const double cy = std::cos(x(kPhiNorth));
    Eigen::Matrix3d C_w;
    C_w << cy, 0.0, -sy * cx,  //
        0.0, 1.0, sx,          //
        sy, 0.0, cy * cx;
    Matrix<kStates> G = Matrix<kStates>::Identity();
    G.block<3, 3>(kPhiEast, kPhiEast) = misalignment_matrix(x).transpose() * C_w;
    return G;
}

}  // namespace truenorth
