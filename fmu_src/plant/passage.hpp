// The motion of a vehicle that is known at points in time alone, from one of them to the next. Velocity and
// attitude are cubics of the time x since the first,
//
//     v(x) = v_0 + y(x),    C_bn(x) = C_0 exp[y(x) x],    y(x) = a x + b x^2 + c x^3,
//
// that have the values and the derivatives of both points; the derivative of the rotation vector y is
// J_r(y)^-1 w_nb^b. A derivative that is not known is that of the parabola through the point before and
// these two; without a point before, of the straight line.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "inertial/earth.hpp"
#include "plant/kinematics.hpp"

namespace truenorth::plant {

// What is known of a vehicle at one instant; a derivative with a component that is not finite is not known.
struct KnownPoint {
    double time = 0.0;                                   // [s]
    earth::Position position;                            // of the IMU
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // v^n [m/s]
    Eigen::Quaterniond q_bn = Eigen::Quaterniond::Identity();
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // dv^n/dt, of the components in n [m/s2]
    Eigen::Vector3d body_rate = Eigen::Vector3d::Zero();     // w_nb^b [rad/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(time, position, velocity, q_bn, acceleration, body_rate);
    }
};

class Passage {
  public:
    // Of a vehicle of which one point is known: it goes on with the derivatives there, if they are known.
    explicit Passage(const KnownPoint& point);

    // `to` is later than `from`, and `before` earlier.
    Passage(const std::optional<KnownPoint>& before, const KnownPoint& from, const KnownPoint& to);

    [[nodiscard]] Kinematics at(double time) const;

  private:
    // a x + b x^2 + c x^3.
    struct Cubic {
        Eigen::Vector3d linear = Eigen::Vector3d::Zero();
        Eigen::Vector3d quadratic = Eigen::Vector3d::Zero();
        Eigen::Vector3d cubic = Eigen::Vector3d::Zero();

        [[nodiscard]] Eigen::Vector3d value(double x) const;
        [[nodiscard]] Eigen::Vector3d rate(double x) const;
    };

    // 0 at x = 0, `end` at x = `duration`; `rates` are the derivatives there.
    struct Rates {
        Eigen::Vector3d begin, end;
    };
    static Cubic through(const Eigen::Vector3d& end, double duration, const Rates& rates);

    KnownPoint from_;
    Cubic velocity_;
    Cubic rotation_;  // rotation vector, in the body axes of from_
};

}  // namespace truenorth::plant
