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

#include "components/antenna_history.hpp"
#include "components/time_tolerance.hpp"

namespace truenorth {

class HeadingFinder {
  public:
    static constexpr double kMemory = 30.0;  // [s]
    // Between fixes that are compared: in less a vehicle changes its acceleration by less than noise does
    // [s].
    static constexpr double kSpacing = 2.0;

    void start() { *this = HeadingFinder{}; }

    // A fix of the antenna's velocity, ENU [m/s], known to sigma [m/s], and the antenna as mechanised then.
    void add(const AntennaState& then, const Eigen::Vector3d& velocity, double sigma) {
        const double dt = then.time - time_;
        const bool follows = fixes_ > 0 && dt > 0.0;
        if (follows && dt < kSpacing - kTimeTolerance) {
            return;
        }
        if (follows) {
            const IntervalAverage between = then.travelled - travelled_;
            const Eigen::Vector3d mechanised = between.force() + (then.lever_velocity - lever_velocity_) / dt;
            const Eigen::Vector2d a_measured = (velocity - velocity_).head<2>() / dt;
            const double keep = std::exp(-dt / kMemory);
            if (fixes_ > 1) {
                take((mechanised - mechanised_).head<2>(), a_measured - measured_, keep,
                     sigma / std::min(dt, spacing_));
            }
            force_ = keep * force_ + dt * mechanised;
            acceleration_ = keep * acceleration_ + dt * a_measured;
            memory_ = keep * memory_ + dt;
            spacing_ = dt;
            mechanised_ = mechanised;
            measured_ = a_measured;
        }
        fixes_ = follows || fixes_ == 0 ? std::min(fixes_ + 1, kEnough) : 1;
        time_ = then.time;
        travelled_ = then.travelled;
        lever_velocity_ = then.lever_velocity;
        velocity_ = velocity;
    }

    // The computed level frame has been turned by R; `travelled` is the running sum now.
    void turn(const Eigen::Matrix3d& R, const IntervalAverage& travelled) {
        const double angle = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
        const Eigen::Rotation2Dd back(-angle);
        sum_ = back * sum_;
        mechanised_ = R * mechanised_;  // gravity too, which a tilt would show as acceleration
        force_ = R * force_;
        lever_velocity_ = R * lever_velocity_;
        travelled_ = travelled - (travelled - travelled_).turned(R);
    }

    // By which the computed frame must be turned about up [rad], and how sure that is [rad].
    [[nodiscard]] double angle() const { return std::atan2(sum_.y(), sum_.x()); }
    [[nodiscard]] double sigma() const { return std::sqrt(noise_ / energy_); }

    // The rotation of the computed frame by which its vertical becomes true, and the heading changes by an
    // angle about up [rad]; without fixes that tell, the latter alone.
    [[nodiscard]] Eigen::Matrix3d upright(double angle) const {
        const Eigen::AngleAxisd heading(angle, Eigen::Vector3d::UnitZ());
        if (memory_ <= 0.0) {
            return heading.toRotationMatrix();
        }
        const Eigen::Vector3d force = force_ / memory_;
        const Eigen::Vector2d level = acceleration_ / memory_;
        const double up = std::sqrt(std::max(force.squaredNorm() - level.squaredNorm(), 1.0));
        const Eigen::Vector3d expected(level.x(), level.y(), up);
        const Eigen::Vector3d before = heading.inverse() * expected;
        return heading * Eigen::Quaterniond::FromTwoVectors(force, before).toRotationMatrix();
    }

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
    void take(const Eigen::Vector2d& u, const Eigen::Vector2d& w, double keep, double sigma) {
        sum_ = keep * sum_ + Eigen::Vector2d(u.dot(w), u.x() * w.y() - u.y() * w.x());
        energy_ = keep * energy_ + u.squaredNorm();
        // Second differences of white noise have the covariances 6, -4 and 1 with themselves and their
        // neighbours: 16 for motion that alternates from one to the next, less for any other.
        noise_ = std::max(keep * noise_, 16.0 * sigma * sigma);
    }

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
