// By how much the computed heading is off, from changes of velocity alone: those that the accelerometers tell
// in the computed level frame against those that the fixes tell. No prior, no linearisation: any angle.
//
// With a_k the mean horizontal acceleration between two fixes, u_k = a_k - a_{k-1} as mechanised and w_k as
// measured, the angle about up that turns the u_k into the w_k is
//
//     atan2(sum u x w, sum u . w),       variance  sigma_w^2 / sum |u|^2.
//
// Differences of accelerations are free of what a tilt and an accelerometer bias add, as long as the vehicle
// does not turn. The means of what was differenced tell the tilt: the force that the fixes leave unexplained
// is gravity's.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "elementary/arctangent.hpp"
#include "filter/antenna_history.hpp"

namespace truenorth {

class HeadingFinder {
  public:
    static constexpr double kMemory = 30.0;  // [s]
    // Between fixes that are compared: in less a vehicle changes its acceleration by less than noise does
    // [s].
    static constexpr double kSpacing = 2.0;

    void start() { *this = HeadingFinder{}; }

    // A fix of the antenna's velocity, ENU [m/s], known to sigma [m/s], and the antenna as mechanised then.
    void add(const AntennaState& then, const Eigen::Vector3d& velocity, double sigma);

    // The computed level frame has been turned by R; `travelled` is the running sum now.
    void turn(const Eigen::Matrix3d& R, const IntervalAverage& travelled);

    // Likewise, where the velocities are known in the computed frame alone, as those of a log are.
    void turn_with_measured(const Eigen::Matrix3d& R, const IntervalAverage& travelled);

    // By which the computed frame must be turned about up [rad], and how sure that is [rad].
    [[nodiscard]] double angle() const { return arctangent(sum_.y(), sum_.x()); }
    [[nodiscard]] double sigma() const { return std::sqrt(noise_ / energy_); }

    // The rotation of the computed frame by which its vertical becomes true, and the heading changes by an
    // angle about up [rad]; without fixes that tell, the latter alone.
    [[nodiscard]] Eigen::Matrix3d upright(double angle) const;

    // Both kinds of changes are of one motion, and large enough to tell.
    [[nodiscard]] bool tells() const {
        const double length = sum_.norm();
        return energy_ > 0.0 && length > 0.5 * energy_ && length < 2.0 * energy_ && sigma() < kUseful;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(fixes_, time_, spacing_, travelled_, lever_velocity_, velocity_, mechanised_, measured_, sum_,
                energy_, noise_, force_, acceleration_, memory_);
    }

  private:
    static constexpr int kEnough = 3;
    static constexpr double kUseful = 0.2;  // [rad]

    // `sigma`: of a velocity of the fixes, over the time between two [m/s2].
    void take(const Eigen::Vector2d& u, const Eigen::Vector2d& w, double keep, double sigma);

    int fixes_ = 0;  // in a row, counted up to kEnough
    double time_ = 0.0;
    double spacing_ = kSpacing;  // of the last two fixes [s]
    IntervalAverage travelled_{};
    Eigen::Vector3d lever_velocity_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d mechanised_ = Eigen::Vector3d::Zero();  // the last force [m/s2]
    Eigen::Vector2d measured_ = Eigen::Vector2d::Zero();    // the last acceleration [m/s2]
    Eigen::Vector2d sum_ = Eigen::Vector2d::Zero();         // of dot and cross products
    double energy_ = 0.0;
    double noise_ = 0.0;  // variance of w, per axis [m2/s4]
    // Sums over time that has not been forgotten, memory_ [s]: of the force and of the acceleration [m/s].
    Eigen::Vector3d force_ = Eigen::Vector3d::Zero();
    Eigen::Vector2d acceleration_ = Eigen::Vector2d::Zero();
    double memory_ = 0.0;
};

}  // namespace truenorth
