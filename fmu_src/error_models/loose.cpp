#include "error_models/loose.hpp"

#include "estimation/model.hpp"

namespace truenorth {

static_assert(ErrorModel<Loose>);

using navigation_error::kCount;

Loose::Interval::Interval(const IntervalAverage& average, const earth::Position& position, const State& x)
    : NavigationInterval(average, position, x.segment<3>(kVelocity)) {}

Matrix<Loose::kStates> Loose::jacobian(const State& /*x*/, const Interval& interval) {
    Matrix<kStates> F = Matrix<kStates>::Zero();
    F.topLeftCorner<kCount, kCount>() = navigation_error::jacobian(interval);
    F.block<3, 3>(kPhi, kGyro) = -interval.C_bn;
    F.block<3, 3>(kVelocity, kAccelerometer) = interval.C_bn;
    return F;
}

Matrix<Loose::kStates> Loose::transition(const State& x, const Interval& interval) const {
    return vector_transition(*this, x, interval);
}

Matrix<Loose::kStates> Loose::process_noise(const State& /*x*/, const Interval& interval) const {
    State variance;
    variance.head<kCount>() = navigation_error::random_walk_variance(noise.angle_random_walk,
                                                                     noise.velocity_random_walk, interval.dt);
    variance.segment<3>(kGyro).setConstant(interval.dt * noise.gyro_random_walk * noise.gyro_random_walk);
    variance.segment<3>(kAccelerometer)
        .setConstant(interval.dt * noise.accelerometer_random_walk * noise.accelerometer_random_walk);
    return variance.asDiagonal();
}

Vector<Loose::kMeasurements> Loose::residual(const State& x, const Fix& fix) {
    Vector<kMeasurements> difference;
    difference << fix.position_difference, fix.velocity_difference;
    return difference - measurement_matrix(x, fix) * x;
}

Matrix<Loose::kMeasurements, Loose::kStates> Loose::measurement_matrix(const State& /*x*/, const Fix& fix) {
    Matrix<kMeasurements, kStates> H = Matrix<kMeasurements, kStates>::Zero();
    H.leftCols<kCount>() = fix.antenna.error_of_navigation();
    H.block<3, 3>(3, kGyro) = fix.antenna.velocity_error_of_gyro_bias();
    return H;
}

Matrix<Loose::kMeasurements> Loose::measurement_noise(const State& /*x*/, const Fix& /*fix*/) const {
    return fix_covariance(noise.position_sigma, noise.velocity_sigma);
}

NavigationState Loose::corrected(const NavigationState& computed, const State& x) {
    return navigation_error::retract(computed, -x.head<kCount>());
}

Matrix<Loose::kStates> Loose::reset_jacobian(const State& x) {
    Matrix<kStates> G = Matrix<kStates>::Identity();
    G.topLeftCorner<kCount, kCount>() = navigation_error::correction_jacobian(x.head<kCount>());
    return G;
}

}  // namespace truenorth
