// Left-invariant error on SE_2(3), 15 or 21 states: alignment from any heading.
//
// The state is the navigation state itself, as the extended pose X = (R, v, p) in Earth-fixed axes: R turns
// body into Earth-fixed components, v is the velocity relative to an *inertial* frame, v = v_e + w_ie x p,
// and p the position from the Earth's centre. With this v the equations of motion on the rotating Earth are
// group affine (Brossard et al. 2021), and the left-invariant error xi,
//
//     X = X^ exp(xi)        true = estimated, X^, after a motion in body axes,
//
// moves by an equation that holds for errors of any size and contains nothing but IMU data (Barrau and
// Bonnabel 2017). Over an interval of length T, with dR, dv, dp of preintegration.hpp,
//
//     xi_R+ = dR^T xi_R,    xi_v+ = dR^T (xi_v + xi_R x dv),    xi_p+ = dR^T (xi_p + T xi_v + xi_R x dp).
//
// No attitude enters, so a wrong one cannot make the covariance wrong, and no misalignment is too large.
// Appended are the errors of constant gyro and accelerometer biases and, if `coloured`, of first-order
// Gauss-Markov processes besides. The measurement is the position and velocity of
// the antenna in ENU axes; of the error it sees, in body axes, (exp(xi_R) - I) l + J(xi_R) xi_p and the like,
// which is linear for small xi_R alone (`predicted` has the whole of it).
//
// A bias b of which the estimate is b^ acts in the true body axes, E = exp(xi_R) from the computed ones. In
// these it is off by beta = E b - b^, and the velocity by
//
//     (E - I) f - beta,    f the specific force as measured, with its bias:
//
// again exact for errors of any size, and nothing in it is estimated (the two-frame group of Barrau and
// Bonnabel 2022). Only where the body rolls and pitches does beta move, by (E+ - E) b. The plain difference b
// - b^ would make psi b of horizontal acceleration out of a heading that is unknown by psi.
//
// The deviation xi_b has beta = J(xi_R) (xi_b + xi_R x b^). To first order it is the difference, true minus
// estimated: its covariance is that of the biases, its transition that of increments without b^. But what is
// known of it hangs on b^, and when a correction changes that by c, xi_b + c x xi_R takes its place
// (`transport`). The heading is the exception: a turn about the vertical changes no accelerometer. It stays a
// turn about the vertical, which c moves in the body by -c / g.
//
// A correction replaces X^ by X^ exp(xi) and leaves the covariance as it is. A reset Jacobian, that of
// log(exp(-xi) exp(.)), would turn it by half the correction; but what ties tilt to accelerometer bias is
// fixed in the body, whatever the heading turns out to be.
//
// Neglected: the gradient of gravitation, 3e-6 / s^2 times the position error.
#pragma once

#include "estimation/gaussian.hpp"
#include "inertial/attitude.hpp"
#include "inertial/preintegration.hpp"

namespace truenorth {

template <bool coloured>
class Invariant {
  public:
    enum StateIndex {         // the first of three components
        kRotation = 0,        // xi_R, body axes [rad]
        kVelocity = 3,        // xi_v, body axes [m/s]
        kPosition = 6,        // xi_p, body axes [m]
        kGyro = 9,            // constant bias, body [rad/s]
        kAccelerometer = 12,  // [m/s2]
        kGyroMarkov = 15,     // Gauss-Markov processes, if `coloured`
        kAccelerometerMarkov = 18,
        kStates = coloured ? 21 : 15
    };
    static constexpr int kMeasurements = 6;
    static constexpr int kSensors = kStates - kGyro;
    using Deviation = Vector<kStates>;

    struct State {
        ExtendedPose pose;
        Vector<kSensors> sensors = Vector<kSensors>::Zero();  // biases, then Gauss-Markov processes

        // Of a navigation state, sensors without error, and back.
        static State of(const NavigationState& navigation);
        [[nodiscard]] NavigationState navigation() const;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(pose, sensors);
        }
    };

    // A first-order Gauss-Markov process.
    struct Markov {
        double sigma;             // of the stationary process
        double correlation_time;  // [s]
    };

    struct Noise {
        double angle_random_walk = 0.0;          // gyro [rad/s^0.5]
        double velocity_random_walk = 0.0;       // accelerometer [m/s^1.5]
        double gyro_random_walk = 0.0;           // of the gyro bias [rad/s^1.5]; 0: constant
        double accelerometer_random_walk = 0.0;  // of the accelerometer bias [m/s^2.5]; 0: constant
        Markov gyro;                             // [rad/s]; none unless `coloured`
        Markov accelerometer;                    // [m/s2]
        Eigen::Vector3d position_sigma;          // GNSS, east, north, up [m]
        Eigen::Vector3d velocity_sigma;          // [m/s]
    };

    using Interval = Preintegration;

    // A GNSS position and velocity of the antenna, in Earth-fixed axes as the pose is. By the state they are
    // p + R position_arm and v + R velocity_arm.
    struct Fix {
        Eigen::Matrix3d C_en;          // into the axes of the measurement
        Eigen::Vector3d position;      // from the Earth's centre [m]
        Eigen::Vector3d velocity;      // relative to an inertial frame [m/s]
        Eigen::Vector3d lever_arm;     // body [m]
        Eigen::Vector3d position_arm;  // body: l [m]
        Eigen::Vector3d velocity_arm;  // body: omega x l [m/s]
        // As this fix tells them, east, north, up [m], [m/s]; 0: those of `noise`.
        Eigen::Vector3d position_sigma = Eigen::Vector3d::Zero();
        Eigen::Vector3d velocity_sigma = Eigen::Vector3d::Zero();

        // From a position, a velocity relative to the Earth (ENU) [m/s], the lever arm [m] and the body rate
        // less the estimate of the gyros' error [rad/s].
        static Fix of(const earth::Position& position, const Eigen::Vector3d& velocity,
                      const Eigen::Vector3d& lever_arm, const Eigen::Vector3d& omega_ib_b);

        // The same fix, `duration` [s] late, for a state that the increments have carried on since: what was
        // measured is let fall, and what the IMU felt lies between there and the antenna.
        [[nodiscard]] Fix after(const ExtendedPose& change, double duration) const;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(C_en, position, velocity, lever_arm, position_arm, velocity_arm, position_sigma,
                    velocity_sigma);
        }
    };

    Noise noise{};

    // Of a fix, east, north, up [m], [m/s].
    [[nodiscard]] Eigen::Vector3d position_sigma(const Fix& fix) const;
    [[nodiscard]] Eigen::Vector3d velocity_sigma(const Fix& fix) const;

    [[nodiscard]] static State retract(const State& x, const Deviation& deviation);
    [[nodiscard]] static Deviation local(const State& x, const State& other);
    [[nodiscard]] static Matrix<kStates> transport(const State& from, const State& to);

    template <int Count>
    void propagate(State& x, Points<kStates, Count>& deviations, const Interval& interval) const {
        const Matrix<kStates> Phi = transition(x, interval);
        deviations.template topRows<kGyro>() = Phi.template topRows<kGyro>().lazyProduct(deviations).eval();
        if constexpr (coloured) {  // of the states beyond the pose each drives itself
            deviations.template bottomRows<kSensors>().array().colwise() *=
                Phi.diagonal().template tail<kSensors>().array();
        }
        x = moved(x, interval);
    }

    [[nodiscard]] State moved(const State& x, const Interval& interval) const;
    [[nodiscard]] Matrix<kStates> transition(const State& x, const Interval& interval) const;
    [[nodiscard]] Matrix<kStates> carried_covariance(const Matrix<kStates>& P, const Matrix<kStates>& Phi,
                                                     const Interval& interval) const;
    [[nodiscard]] Matrix<kStates> process_noise(const State& x, const Interval& interval) const;

    [[nodiscard]] static Vector<kMeasurements> residual(const State& x, const Fix& fix);
    [[nodiscard]] static Matrix<kMeasurements, kStates> measurement_matrix(const State& x, const Fix& fix);
    [[nodiscard]] Matrix<kMeasurements> measurement_noise(const State& x, const Fix& fix) const;

    template <int Count>
    [[nodiscard]] Points<kMeasurements, Count> predicted(const State& x,
                                                         const Points<kStates, Count>& deviations,
                                                         const Fix& fix) const {
        const Eigen::Matrix3d C_bn = body_to_navigation(x, fix);
        Points<kMeasurements, Count> images;
        for (int i = 0; i < Count; ++i) {
            const Deviation d = deviations.col(i);
            const Eigen::Vector3d rotation = d.template segment<3>(kRotation);
            const Eigen::Matrix3d J = left_jacobian(rotation);  // (exp(xi_R) - I) l = J (xi_R x l)
            const Eigen::Vector3d bias_velocity = fix.lever_arm.cross(J.transpose() * gyro_part(d));
            images.col(i).template head<3>() =
                C_bn * J * (rotation.cross(fix.position_arm) + d.template segment<3>(kPosition));
            images.col(i).template tail<3>() =
                C_bn *
                (J * (rotation.cross(fix.velocity_arm + bias_velocity) + d.template segment<3>(kVelocity)) +
                 bias_velocity);
        }
        return images;
    }

    // Errors of gyros [rad/s] and accelerometers [m/s2], biases and processes together.
    [[nodiscard]] static Vector<6> sensor_error(const State& x) {
        Vector<6> sum = x.sensors.template head<6>();
        if constexpr (coloured) {
            sum += x.sensors.template tail<6>();
        }
        return sum;
    }

    // Jacobian of the errors of a navigation state, as navigation_error.hpp has them (misalignment, velocity,
    // position; east, north, up; computed minus true), with respect to the deviation. Sensor errors remain as
    // they are. Orthogonal.
    [[nodiscard]] static Matrix<kStates> navigation_errors(const State& x);

    // J x, with the J of a state whose axes C_bn turns into level ones; J^T x with its transpose. J turns
    // blocks of three alone, and has no need of general products.
    template <class Rows>
    static void turn(const Eigen::Matrix3d& C_bn, Rows& x) {
        x.template middleRows<3>(kRotation) = C_bn.lazyProduct(x.template middleRows<3>(kRotation)).eval();
        x.template middleRows<3>(kVelocity) = -C_bn.lazyProduct(x.template middleRows<3>(kVelocity)).eval();
        x.template middleRows<3>(kPosition) = -C_bn.lazyProduct(x.template middleRows<3>(kPosition)).eval();
    }

    // Likewise J P J^T.
    [[nodiscard]] static Matrix<kStates> turned(const Eigen::Matrix3d& C_bn, Matrix<kStates> P);

    // Into the level axes where the state is.
    [[nodiscard]] static Eigen::Matrix3d body_to_navigation(const State& x);

  private:
    // Into those of a fix.
    [[nodiscard]] static Eigen::Matrix3d body_to_navigation(const State& x, const Fix& fix) {
        return fix.C_en * x.pose.attitude.toRotationMatrix();
    }

    // dR, dv, dp freed of the sensors' errors, as the estimate knows them.
    [[nodiscard]] ExtendedPose felt(const State& x, const Interval& interval) const;

    // Error of the gyros, bias and process together.
    [[nodiscard]] static Eigen::Vector3d gyro_part(const Deviation& d) {
        Eigen::Vector3d sum = d.template segment<3>(kGyro);
        if constexpr (coloured) {
            sum += d.template segment<3>(kGyroMarkov);
        }
        return sum;
    }
};

extern template class Invariant<false>;
extern template class Invariant<true>;

}  // namespace truenorth
