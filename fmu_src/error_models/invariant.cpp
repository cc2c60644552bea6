#include "error_models/invariant.hpp"

#include <Eigen/LU>
#include <cmath>

#include "elementary/exponential.hpp"
#include "error_models/antenna.hpp"
#include "estimation/model.hpp"
#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

static_assert(ErrorModel<Invariant<false>> && NonlinearMeasurement<Invariant<false>>);
static_assert(ErrorModel<Invariant<true>> && NonlinearMeasurement<Invariant<true>>);

namespace {

// Mean over an interval of a Gauss-Markov process that starts at 1.
double mean_of_decay(double dt, double correlation_time) {
    const double ratio = dt / correlation_time;
    return std::abs(ratio) < 1e-9 ? 1.0 : -exponential_minus_one(-ratio) / ratio;
}

}  // namespace

template <bool coloured>
auto Invariant<coloured>::State::of(const NavigationState& navigation) -> State {
    const Eigen::Matrix3d C_ne = earth::C_en(navigation.position).transpose();
    const Eigen::Vector3d position = earth::ecef(navigation.position);
    return {.pose = {.attitude = Eigen::Quaterniond(C_ne) * navigation.q_bn,
                     .velocity = C_ne * navigation.velocity + earth::earth_fixed_rate().cross(position),
                     .position = position}};
}

template <bool coloured>
NavigationState Invariant<coloured>::State::navigation() const {
    const earth::Position position = earth::geodetic(pose.position);
    const Eigen::Matrix3d C_en = earth::C_en(position);
    return {.q_bn = Eigen::Quaterniond(C_en) * pose.attitude,
            .velocity = C_en * (pose.velocity - earth::earth_fixed_rate().cross(pose.position)),
            .position = position};
}

template <bool coloured>
auto Invariant<coloured>::retract(const State& x, const Deviation& deviation) -> State {
    const Eigen::Matrix3d J = left_jacobian(-deviation.template segment<3>(kRotation));
    State corrected{.pose = x.pose * ExtendedPose::exponential(deviation.template head<kGyro>()),
                    .sensors = x.sensors};
    for (int i = 0; i < kSensors; i += 3) {
        corrected.sensors.template segment<3>(i) += J * deviation.template segment<3>(kGyro + i);
    }
    return corrected;
}

template <bool coloured>
auto Invariant<coloured>::local(const State& x, const State& other) -> Deviation {
    Deviation deviation;
    deviation << (x.pose.inverse() * other.pose).logarithm(), other.sensors - x.sensors;
    const Eigen::Matrix3d J_inverse = left_jacobian(-deviation.template segment<3>(kRotation)).inverse();
    for (int i = kGyro; i < kStates; i += 3) {
        deviation.template segment<3>(i) = (J_inverse * deviation.template segment<3>(i)).eval();
    }
    return deviation;
}

template <bool coloured>
Matrix<Invariant<coloured>::kStates> Invariant<coloured>::transport(const State& from, const State& to) {
    const Vector<kSensors> learnt = to.sensors - from.sensors;
    const Eigen::Vector3d up = body_to_navigation(from).row(2);
    const Eigen::Matrix3d level = Eigen::Matrix3d::Identity() - up * up.transpose();
    Matrix<kStates> J = Matrix<kStates>::Identity();
    for (int i = 0; i < kSensors; i += 6) {
        const Eigen::Vector3d force = learnt.template segment<3>(i + 3);
        J.template block<3, 3>(kGyro + i, kRotation) = skew(learnt.template segment<3>(i));
        J.template block<3, 3>(kGyro + i + 3, kRotation) = skew(force) * level;
        J.template block<3, 3>(kRotation, kRotation) -=
            level * force * up.transpose() / earth::kStandardGravity;
    }
    return J;
}

template <bool coloured>
Eigen::Matrix3d Invariant<coloured>::body_to_navigation(const State& x) {
    return earth::C_en(earth::geodetic(x.pose.position)) * x.pose.attitude.toRotationMatrix();
}

template <bool coloured>
ExtendedPose Invariant<coloured>::felt(const State& x, const Interval& interval) const {
    if constexpr (coloured) {
        const double T = interval.duration;
        Vector<6> error = x.sensors.template head<6>();
        error.head<3>() += mean_of_decay(T, noise.gyro.correlation_time) * x.sensors.template segment<3>(6);
        error.tail<3>() +=
            mean_of_decay(T, noise.accelerometer.correlation_time) * x.sensors.template tail<3>();
        return interval.corrected(error);
    } else {
        return interval.corrected(x.sensors);
    }
}

template <bool coloured>
auto Invariant<coloured>::moved(const State& x, const Interval& interval) const -> State {
    const double T = interval.duration;
    State end = x;
    end.pose = carried(x.pose, felt(x, interval), T);
    if constexpr (coloured) {
        end.sensors.template segment<3>(6) *= exponential(-T / noise.gyro.correlation_time);
        end.sensors.template tail<3>() *= exponential(-T / noise.accelerometer.correlation_time);
    }
    return end;
}

template <bool coloured>
Matrix<Invariant<coloured>::kStates> Invariant<coloured>::transition(const State& x,
                                                                     const Interval& interval) const {
    const double T = interval.duration;
    const ExtendedPose change = felt(x, interval);
    const Eigen::Matrix3d back = change.attitude.conjugate().toRotationMatrix();
    Matrix<kStates> Phi = Matrix<kStates>::Identity();
    Phi.template block<3, 3>(kRotation, kRotation) = back;
    Phi.template block<3, 3>(kVelocity, kRotation) = -back * skew(change.velocity);
    Phi.template block<3, 3>(kVelocity, kVelocity) = back;
    Phi.template block<3, 3>(kPosition, kRotation) = -back * skew(change.position);
    Phi.template block<3, 3>(kPosition, kVelocity) = T * back;
    Phi.template block<3, 3>(kPosition, kPosition) = back;

    Matrix<9, 6> bias = interval.bias_jacobian;
    bias.template middleRows<3>(kVelocity) = (back * bias.template middleRows<3>(kVelocity)).eval();
    bias.template middleRows<3>(kPosition) = (back * bias.template middleRows<3>(kPosition)).eval();
    Phi.template block<9, 6>(0, kGyro) = bias;
    if constexpr (coloured) {
        const auto append = [&](int state, int column, double correlation_time) {
            Phi.template block<9, 3>(0, state) =
                mean_of_decay(T, correlation_time) * bias.template middleCols<3>(column);
            Phi.template block<3, 3>(state, state).diagonal().setConstant(exponential(-T / correlation_time));
        };
        append(kGyroMarkov, 0, noise.gyro.correlation_time);
        append(kAccelerometerMarkov, 3, noise.accelerometer.correlation_time);
    }
    return Phi;
}

template <bool coloured>
Matrix<Invariant<coloured>::kStates> Invariant<coloured>::carried_covariance(const Matrix<kStates>& P,
                                                                             const Matrix<kStates>& Phi,
                                                                             const Interval& interval) const {
    Deviation density = Deviation::Zero();
    const auto set = [&](int first, double value) {
        density.template segment<3>(first).setConstant(value * value);
    };
    set(kRotation, noise.angle_random_walk);
    set(kVelocity, noise.velocity_random_walk);
    set(kGyro, noise.gyro_random_walk);
    set(kAccelerometer, noise.accelerometer_random_walk);
    if constexpr (coloured) {
        set(kGyroMarkov, noise.gyro.sigma * std::sqrt(2.0 / noise.gyro.correlation_time));
        set(kAccelerometerMarkov,
            noise.accelerometer.sigma * std::sqrt(2.0 / noise.accelerometer.correlation_time));
    }
    // Noise by Simpson's rule over the time at which it arrives: at the start, with which P goes the whole
    // way, half-way, at the end. Of the pose, the transition from half-way on is the mean of start and end: a
    // turn within the interval loses a little of the white noise, 2 % at 20 deg. Of the states beyond the
    // pose each drives itself and the pose, no other, which spares half of the products.
    const Deviation sixth = interval.duration / 6.0 * density;
    Matrix<kStates> start = P;
    start.diagonal() += sixth;
    const Matrix<kGyro, kStates> pose = Phi.template topRows<kGyro>();
    const Matrix<kGyro, kStates> driven = product(pose, start);
    const Vector<kSensors> decay = Phi.diagonal().template tail<kSensors>();

    Matrix<kGyro, kStates> half_way = 0.5 * pose;
    half_way.diagonal().array() += 0.5;
    const Vector<kSensors> half_decay = decay.cwiseSqrt();
    const Matrix<kGyro, kStates> arriving = half_way * (4.0 * sixth).asDiagonal();

    Matrix<kStates> end;
    end.template topLeftCorner<kGyro, kGyro>() =
        product(driven, pose.transpose()) + product(arriving, half_way.transpose());
    end.template topRightCorner<kGyro, kSensors>() =
        driven.template rightCols<kSensors>() * decay.asDiagonal();
    end.template topRightCorner<kGyro, kSensors>() +=
        arriving.template rightCols<kSensors>() * half_decay.asDiagonal();
    end.template bottomLeftCorner<kSensors, kGyro>() =
        end.template topRightCorner<kGyro, kSensors>().transpose();
    end.template bottomRightCorner<kSensors, kSensors>() =
        decay.asDiagonal() * start.template bottomRightCorner<kSensors, kSensors>() * decay.asDiagonal();
    end.diagonal().template tail<kSensors>() +=
        4.0 * sixth.template tail<kSensors>().cwiseProduct(half_decay.cwiseAbs2());
    end.diagonal() += sixth;
    symmetrise(end);
    return end;
}

template <bool coloured>
Matrix<Invariant<coloured>::kStates> Invariant<coloured>::process_noise(const State& x,
                                                                        const Interval& interval) const {
    return carried_covariance(Matrix<kStates>::Zero(), transition(x, interval), interval);
}

template <bool coloured>
auto Invariant<coloured>::Fix::of(const earth::Position& position, const Eigen::Vector3d& velocity,
                                  const Eigen::Vector3d& lever_arm, const Eigen::Vector3d& omega_ib_b)
    -> Fix {
    const Eigen::Matrix3d C_en = earth::C_en(position);
    const Eigen::Vector3d ecef = earth::ecef(position);
    return {.C_en = C_en,
            .position = ecef,
            .velocity = C_en.transpose() * velocity + earth::earth_fixed_rate().cross(ecef),
            .lever_arm = lever_arm,
            .position_arm = lever_arm,
            .velocity_arm = omega_ib_b.cross(lever_arm)};
}

template <bool coloured>
auto Invariant<coloured>::Fix::after(const ExtendedPose& change, double duration) const -> Fix {
    const Eigen::Quaterniond back = change.attitude.conjugate();
    const ExtendedPose fallen = carried({.velocity = velocity, .position = position}, {}, duration);
    Fix later = *this;
    later.velocity = fallen.velocity;
    later.position = fallen.position;
    later.lever_arm = back * lever_arm;
    later.position_arm = back * (position_arm + duration * velocity_arm - change.position);
    later.velocity_arm = back * (velocity_arm - change.velocity);
    return later;
}

template <bool coloured>
Vector<Invariant<coloured>::kMeasurements> Invariant<coloured>::residual(const State& x, const Fix& fix) {
    const ExtendedPose& pose = x.pose;
    Vector<kMeasurements> residual;
    residual << fix.C_en * (fix.position - (pose.position + pose.attitude * fix.position_arm)),
        fix.C_en * (fix.velocity - (pose.velocity + pose.attitude * fix.velocity_arm));
    return residual;
}

template <bool coloured>
auto Invariant<coloured>::measurement_matrix(const State& x, const Fix& fix)
    -> Matrix<kMeasurements, kStates> {
    const Eigen::Matrix3d C_bn = body_to_navigation(x, fix);
    const Eigen::Matrix3d gyro = C_bn * skew(fix.lever_arm);
    Matrix<kMeasurements, kStates> H = Matrix<kMeasurements, kStates>::Zero();
    H.template block<3, 3>(0, kRotation) = -C_bn * skew(fix.position_arm);
    H.template block<3, 3>(0, kPosition) = C_bn;
    H.template block<3, 3>(3, kRotation) = -C_bn * skew(fix.velocity_arm);
    H.template block<3, 3>(3, kVelocity) = C_bn;
    H.template block<3, 3>(3, kGyro) = gyro;
    if constexpr (coloured) {
        H.template block<3, 3>(3, kGyroMarkov) = gyro;
    }
    return H;
}

template <bool coloured>
Eigen::Vector3d Invariant<coloured>::position_sigma(const Fix& fix) const {
    return (fix.position_sigma.array() > 0.0).select(fix.position_sigma, noise.position_sigma);
}

template <bool coloured>
Eigen::Vector3d Invariant<coloured>::velocity_sigma(const Fix& fix) const {
    return (fix.velocity_sigma.array() > 0.0).select(fix.velocity_sigma, noise.velocity_sigma);
}

template <bool coloured>
Matrix<Invariant<coloured>::kMeasurements> Invariant<coloured>::measurement_noise(const State& /*x*/,
                                                                                  const Fix& fix) const {
    return fix_covariance(position_sigma(fix), velocity_sigma(fix));
}

template <bool coloured>
Matrix<Invariant<coloured>::kStates> Invariant<coloured>::navigation_errors(const State& x) {
    const Eigen::Matrix3d C_bn = body_to_navigation(x);
    // The computed attitude is exp(-C_bn xi_R) times the true one, and so is phi.
    Matrix<kStates> J = Matrix<kStates>::Identity();
    J.template block<3, 3>(kRotation, kRotation) = C_bn;
    J.template block<3, 3>(kVelocity, kVelocity) = -C_bn;
    J.template block<3, 3>(kPosition, kPosition) = -C_bn;
    return J;
}

template <bool coloured>
Matrix<Invariant<coloured>::kStates> Invariant<coloured>::turned(const Eigen::Matrix3d& C_bn,
                                                                 Matrix<kStates> P) {
    turn(C_bn, P);
    P.transposeInPlace();
    turn(C_bn, P);
    symmetrise(P);
    return P;
}

template class Invariant<false>;
template class Invariant<true>;

}  // namespace truenorth
