#include "error_models/tight.hpp"

#include <cmath>

#include "elementary/exponential.hpp"
#include "estimation/model.hpp"

namespace truenorth {

static_assert(ErrorModel<Tight> && NoiseInside<Tight>);

using Eigen::Vector3d;
using navigation_error::kCount;

Tight::Interval::Interval(const IntervalAverage& average, const earth::Position& position, const State& x)
    : NavigationInterval(average, position, x.segment<3>(kVelocity)),
      computed_position(position),
      computed_velocity(average.velocity()) {}

Tight::State Tight::rate_of(const State& x, const Interval& interval) const {
    const Vector3d phi = x.segment<3>(kPhi);
    const Vector3d dv = x.segment<3>(kVelocity);
    const Vector3d dp = x.segment<3>(kPosition);
    const Eigen::Matrix3d C = quaternion(-phi).toRotationMatrix();

    const earth::Position& computed = interval.computed_position;
    const Vector3d computed_v = interval.computed_velocity;
    const Vector3d computed_ie = earth::rate(computed.latitude);
    const Vector3d computed_en = earth::transport_rate(computed, computed_v);

    const earth::Position position = earth::displaced(computed, -dp);
    const Vector3d v = computed_v - dv;
    const Vector3d w_ie = earth::rate(position.latitude);
    const Vector3d w_en = earth::transport_rate(position, v);
    const double gravity_error = earth::gravity(computed.latitude, computed.height) -
                                 earth::gravity(position.latitude, position.height);

    const Vector3d turn = computed_ie + computed_en - C * (w_ie + w_en) -
                          interval.C_bn * (x.segment<3>(kGyro) + x.segment<3>(kGyroMarkov));
    const Vector3d true_force =
        C.transpose() * (interval.force - interval.C_bn * x.segment<3>(kAccelerometer));

    State rate = State::Zero();
    rate.segment<3>(kPhi) = left_jacobian(-phi).inverse() * turn;  // J_r(phi) = J_l(-phi)
    rate.segment<3>(kVelocity) = interval.force - true_force - gravity_error * Vector3d::UnitZ() -
                                 (2.0 * computed_ie + computed_en).cross(computed_v) +
                                 (2.0 * w_ie + w_en).cross(v);
    rate.segment<3>(kPosition) = dv - w_en.cross(dp) + earth::transport_rate(position, dp).cross(v);
    rate.segment<3>(kGyroMarkov) = -x.segment<3>(kGyroMarkov) / noise.gyro_markov_time;
    rate(kClockBias) = x(kClockDrift);
    return rate;
}

Matrix<Tight::kStates> Tight::jacobian(const State& /*x*/, const Interval& interval) const {
    Matrix<kStates> F = Matrix<kStates>::Zero();
    F.topLeftCorner<kCount, kCount>() = navigation_error::jacobian(interval);
    F.block<3, 3>(kPhi, kGyro) = -interval.C_bn;
    F.block<3, 3>(kPhi, kGyroMarkov) = -interval.C_bn;
    F.block<3, 3>(kVelocity, kAccelerometer) = interval.C_bn;
    F.diagonal().segment<3>(kGyroMarkov).setConstant(-1.0 / noise.gyro_markov_time);
    F(kClockBias, kClockDrift) = 1.0;
    return F;
}

// Exact for the Markov process and the clock, whose drift reaches its bias within the interval.
Matrix<Tight::kStates> Tight::transition(const State& x, const Interval& interval) const {
    return vector_transition(*this, x, interval);
}

Matrix<Tight::kStates> Tight::process_noise(const State& /*x*/, const Interval& interval) const {
    const double dt = interval.dt;
    const auto squared = [](double value) { return value * value; };
    Matrix<kStates> Q = Matrix<kStates>::Zero();
    auto variance = Q.diagonal();
    variance.head<kCount>() =
        navigation_error::random_walk_variance(noise.angle_random_walk, noise.velocity_random_walk, dt);
    variance.segment<3>(kGyro).setConstant(dt * squared(noise.gyro_random_walk));
    variance.segment<3>(kGyroMarkov)
        .setConstant(-squared(noise.gyro_markov_sigma) *
                     exponential_minus_one(-2.0 * dt / noise.gyro_markov_time));
    variance.segment<3>(kAccelerometer).setConstant(dt * squared(noise.accelerometer_random_walk));
    const double drift = squared(noise.clock_drift_random_walk);
    variance(kClockBias) = dt * squared(noise.clock_bias_random_walk) + drift * dt * dt * dt / 3.0;
    variance(kClockDrift) = drift * dt;
    Q(kClockBias, kClockDrift) = Q(kClockDrift, kClockBias) = drift * dt * dt / 2.0;
    return Q;
}

Tight::Mask Tight::present(const Fix& fix) {
    Mask mask;
    for (int i = 0; i < kChannels; ++i) {
        mask(i) = mask(kChannels + i) = fix.channels[i].valid;
    }
    return mask;
}

Matrix<6, Tight::kStates> Tight::antenna_error(const Fix& fix) {
    Matrix<6, kStates> A = Matrix<6, kStates>::Zero();
    A.leftCols<kCount>() = fix.antenna.error_of_navigation();
    A.block<3, 3>(3, kGyro) = fix.antenna.velocity_error_of_gyro_bias();
    A.block<3, 3>(3, kGyroMarkov) = A.block<3, 3>(3, kGyro);
    // A displacement turns the ENU axes, and the velocity that is resolved in them.
    for (int i = 0; i < 3; ++i) {
        A.block<3, 1>(3, kPosition + i) =
            earth::transport_rate(fix.position, Vector3d::Unit(i)).cross(fix.velocity);
    }
    return A;
}

std::array<Tight::Sight, Tight::kChannels> Tight::sights(const State& x, const Fix& fix) {
    const Vector<6> error = antenna_error(fix) * x;
    const Eigen::Matrix3d C_en = earth::C_en(fix.position);
    const Vector3d antenna = earth::ecef(fix.position);
    std::array<Sight, kChannels> sights;
    for (int i = 0; i < kChannels; ++i) {
        const Channel& channel = fix.channels[i];
        sights[i] = {.line = C_en * (channel.satellite_position - antenna) + error.head<3>(),
                     .velocity = C_en * channel.satellite_velocity - fix.velocity + error.tail<3>()};
    }
    return sights;
}

Vector<Tight::kMeasurements> Tight::residual(const State& x, const Fix& fix) {
    const std::array<Sight, kChannels> all = sights(x, fix);
    Vector<kMeasurements> residual = Vector<kMeasurements>::Zero();
    for (int i = 0; i < kChannels; ++i) {
        const Channel& channel = fix.channels[i];
        if (channel.valid) {
            const double range = all[i].line.norm();
            residual(i) = channel.pseudorange - (range + x(kClockBias));
            residual(kChannels + i) =
                channel.range_rate - (all[i].line.dot(all[i].velocity) / range + x(kClockDrift));
        }
    }
    return residual;
}

Matrix<Tight::kMeasurements, Tight::kStates> Tight::measurement_matrix(const State& x, const Fix& fix) {
    const Matrix<6, kStates> antenna = antenna_error(fix);
    const std::array<Sight, kChannels> all = sights(x, fix);
    Matrix<kMeasurements, kStates> H = Matrix<kMeasurements, kStates>::Zero();
    for (int i = 0; i < kChannels; ++i) {
        if (fix.channels[i].valid) {
            const double range = all[i].line.norm();
            const Vector3d u = all[i].line / range;
            const Vector3d across = all[i].velocity - u.dot(all[i].velocity) * u;
            H.row(i) = u.transpose() * antenna.topRows<3>();
            H(i, kClockBias) = 1.0;
            H.row(kChannels + i) =
                across.transpose() / range * antenna.topRows<3>() + u.transpose() * antenna.bottomRows<3>();
            H(kChannels + i, kClockDrift) = 1.0;
        }
    }
    return H;
}

Matrix<Tight::kMeasurements> Tight::measurement_noise(const State& /*x*/, const Fix& /*fix*/) const {
    Vector<kMeasurements> variance;
    variance.head<kChannels>().setConstant(noise.pseudorange_sigma * noise.pseudorange_sigma);
    variance.tail<kChannels>().setConstant(noise.range_rate_sigma * noise.range_rate_sigma);
    return variance.asDiagonal();
}

NavigationState Tight::corrected(const NavigationState& computed, const State& x) {
    return navigation_error::retract(computed, -x.head<kCount>());
}

Tight::State Tight::remaining(const State& x) {
    State rest = x;
    rest.head<kGyroMarkov>().setZero();
    rest.segment<3>(kAccelerometer).setZero();
    return rest;
}

Matrix<Tight::kStates> Tight::reset_jacobian(const State& x) {
    Matrix<kStates> G = Matrix<kStates>::Identity();
    G.topLeftCorner<kCount, kCount>() = navigation_error::correction_jacobian(x.head<kCount>());
    return G;
}

}  // namespace truenorth
