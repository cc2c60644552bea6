#include "error_models/large_azimuth.hpp"

#include "estimation/model.hpp"

namespace truenorth {

static_assert(ErrorModel<LargeAzimuth> && NoiseInside<LargeAzimuth>);

LargeAzimuth::Interval::Interval(const IntervalAverage& average, const earth::Position& position,
                                 const State& x)
    : NavigationInterval(average, position, {x(kVelocityEast), x(kVelocityNorth), 0.0}) {}

Matrix<LargeAzimuth::kStates> LargeAzimuth::transition(const State& x, const Interval& interval) const {
    return vector_transition(*this, x, interval);
}

Matrix<LargeAzimuth::kStates> LargeAzimuth::process_noise(const State& /*x*/,
                                                          const Interval& interval) const {
    State variance = State::Zero();
    variance.segment<2>(kVelocityEast).setConstant(noise.velocity_random_walk * noise.velocity_random_walk);
    variance.segment<3>(kPhiEast).setConstant(noise.angle_random_walk * noise.angle_random_walk);
    return (interval.dt * variance).asDiagonal();
}

Eigen::Vector2d LargeAzimuth::residual(const State& x, const Fix& fix) {
    const Eigen::Matrix3d C = misalignment_matrix(Misalignment::large_azimuth, x.segment<3>(kPhiEast));
    const Eigen::Vector3d lever = fix.lever_velocity - C.transpose() * fix.lever_velocity;
    return fix.velocity_difference - (x.segment<2>(kVelocityEast) + lever.head<2>());
}

Matrix<LargeAzimuth::kMeasurements, LargeAzimuth::kStates> LargeAzimuth::measurement_matrix(const State& x,
                                                                                            const Fix& fix) {
    Matrix<kMeasurements, kStates> H = Matrix<kMeasurements, kStates>::Zero();
    H.middleCols<2>(kVelocityEast).setIdentity();
    H.middleCols<3>(kPhiEast) = -derivative_of_transposed_product(Misalignment::large_azimuth,
                                                                  x.segment<3>(kPhiEast), fix.lever_velocity)
                                     .topRows<2>();
    return H;
}

Eigen::Matrix2d LargeAzimuth::measurement_noise(const State& /*x*/, const Fix& /*fix*/) const {
    return noise.velocity_sigma * noise.velocity_sigma * Eigen::Matrix2d::Identity();
}

Shear<LargeAzimuth::kStates> LargeAzimuth::hindsight(const Matrix<kStates>& prior,
                                                     const State& correction) const {
    Shear<kStates> shear{.along = kPhiUp};
    if (velocity_form == VelocityForm::vertical_force) {  // no horizontal force shows it the heading
        return shear;
    }
    // The regression P_vc P_cc^-1 of the velocity errors on their causes c, misalignment and accelerometer
    // biases: eliminating c from the equations (P_vc, 0; P_cc, d_c) leaves what d_c has made of v, negative.
    constexpr int count = kGyroX - kPhiEast;
    Matrix<2 + count, count + 1> equations;
    equations.leftCols<count>() = prior.block<2 + count, count>(kVelocityEast, kPhiEast);
    equations.col(count) << 0.0, 0.0, correction.segment<count>(kPhiEast);
    for (int j = 0; j < count; ++j) {
        const double pivot = equations(2 + j, j);
        if (!(pivot > 0.0)) {
            return shear;
        }
        for (int k = j + 1; k <= count; ++k) {
            equations.col(k) -= (equations(2 + j, k) / pivot) * equations.col(j);
        }
    }
    shear.by.segment<2>(kVelocityEast) << equations(1, count), -equations(0, count);
    return shear;
}

Matrix<LargeAzimuth::kStates> LargeAzimuth::jacobian(const State& x, const Interval& interval) const {
    constexpr auto form = Misalignment::large_azimuth;
    const Eigen::Vector3d phi = x.segment<3>(kPhiEast);
    const Eigen::Vector3d w = interval.omega_ie + interval.omega_en;
    const Eigen::Vector3d& f = interval.force;

    Matrix<kStates> F = Matrix<kStates>::Zero();
    F.block<3, 3>(kPhiEast, kPhiEast) = -derivative_of_product(form, phi, w);
    F.block<3, 2>(kPhiEast, kVelocityEast) = interval.transport().leftCols<2>();
    F.block<3, 3>(kPhiEast, kGyroX) = -interval.C_bn;

    Eigen::Matrix3d force = Eigen::Matrix3d::Zero();
    Matrix<3, 2> bias = interval.C_bn.leftCols<2>();
    switch (velocity_form) {
        case VelocityForm::transposed: {
            const Eigen::Vector3d nabla = bias * x.segment<2>(kAccelerometerX);
            force = -derivative_of_transposed_product(form, phi, f - nabla);
            bias = (misalignment_matrix(form, phi).transpose() * bias).eval();
            break;
        }
        case VelocityForm::computed_force:
            force = derivative_of_product(form, phi, f);
            break;
        case VelocityForm::vertical_force:
            force = derivative_of_product(form, phi, {0.0, 0.0, f.z()});
            break;
        case VelocityForm::printed:
            force = derivative_of_product(form, phi, f);
            force(0, 1) += f.z();
            break;
    }
    F.block<2, 3>(kVelocityEast, kPhiEast) = force.topRows<2>();
    F.block<2, 2>(kVelocityEast, kAccelerometerX) = bias.topRows<2>();
    F.block<2, 2>(kVelocityEast, kVelocityEast) =
        interval.coriolis({x(kVelocityEast), x(kVelocityNorth), 0.0}).topLeftCorner<2, 2>();
    return F;
}

NavigationState LargeAzimuth::corrected(const NavigationState& computed, const State& x) {
    NavigationState state = realigned(computed, x.segment<3>(kPhiEast));
    state.velocity.head<2>() -= x.segment<2>(kVelocityEast);
    return state;
}

Matrix<LargeAzimuth::kStates> LargeAzimuth::reset_jacobian(const State& x) {
    Matrix<kStates> G = Matrix<kStates>::Identity();
    G.block<3, 3>(kPhiEast, kPhiEast) = realignment_jacobian(x.segment<3>(kPhiEast));
    return G;
}

}  // namespace truenorth
