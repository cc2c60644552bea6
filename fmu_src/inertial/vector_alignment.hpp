// Attitude from nothing: alignment of a moving vehicle by vectors in inertial space.
//
// Let i be the axes that coincide with the Earth-fixed ones at the first fix, and R the attitude then, body
// to i. From then on the velocity relative to i changes by gravitation, which the place tells, and by the
// specific force, which the IMU integrates in the body axes of that moment: at every fix
//
//     b = R a + c,    b = v^i - (integral of gravitation),    a = (integral of specific force)
//
// with c the velocity at the first fix (Wu and Pan 2013, velocity integration formula). With white errors of
// the measured velocities the most likely R and c are those of least squares: about the means of a and b the
// problem is that of Wahba, and the q-method of Davenport solves it in closed form. No attitude has to be
// known beforehand, and sums over the fixes are all that is kept. Biases of the sensors are not estimated;
// they tilt the solution by the accelerometer bias over g and turn it by the east gyro bias over the
// horizontal Earth rate.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "inertial/preintegration.hpp"

namespace truenorth {

class VectorAlignment {
  public:
    // A fix in Earth-fixed axes. The antenna moves against the IMU by R velocity_arm.
    struct Fix {
        Eigen::Vector3d position;      // from the Earth's centre [m]
        Eigen::Vector3d velocity;      // relative to an inertial frame [m/s]
        Eigen::Vector3d velocity_arm;  // body [m/s]
    };

    struct Solution {
        Eigen::Quaterniond at_first_fix;  // attitude, body to Earth-fixed
        Eigen::Quaterniond attitude;      // at the last fix
        // Of the latter's error, a rotation vector in Earth-fixed axes [rad2], as the scatter of the fixes
        // tells; never more than that of an attitude of which nothing is known.
        Eigen::Matrix3d covariance;
    };

    // A fix at the end of the interval since the fix before. That of the first fix does not matter.
    void add(const Preintegration& interval, const Fix& fix);

    // None before the fourth fix.
    [[nodiscard]] std::optional<Solution> solve() const;

    // The attitude at the first fix from which this one at the last follows, if the sensors are off by this
    // bias (preintegration.hpp).
    [[nodiscard]] Eigen::Quaterniond at_first_fix(const Eigen::Quaterniond& attitude,
                                                  const Eigen::Matrix<double, 6, 1>& bias) const;

    [[nodiscard]] int fixes() const { return count_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(count_, travelled_, gravitation_, impulse_, mean_a_, mean_b_, aa_, ba_, bb_);
    }

  private:
    int count_ = 0;
    Preintegration travelled_;                               // since the first fix
    Eigen::Vector3d gravitation_ = Eigen::Vector3d::Zero();  // at the last fix, axes i [m/s2]
    Eigen::Vector3d impulse_ = Eigen::Vector3d::Zero();      // its integral since the first fix [m/s]
    Eigen::Vector3d mean_a_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_b_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d aa_ = Eigen::Matrix3d::Zero();  // sums of products about the means
    Eigen::Matrix3d ba_ = Eigen::Matrix3d::Zero();
    double bb_ = 0.0;
};

}  // namespace truenorth
