#include "filter/heading_finder.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "contract/time_tolerance.hpp"
#include "elementary/exponential.hpp"
#include "inertial/attitude.hpp"

namespace truenorth {

void HeadingFinder::add(const AntennaState& then, const Eigen::Vector3d& velocity, double sigma) {
    const double dt = then.time - time_;
    const bool follows = fixes_ > 0 && dt > 0.0;
    if (follows && dt < kSpacing - kTimeTolerance) {
        return;
    }
    if (follows) {
        const IntervalAverage between = then.travelled - travelled_;
        const Eigen::Vector3d mechanised = between.force() + (then.lever_velocity - lever_velocity_) / dt;
        const Eigen::Vector2d a_measured = (velocity - velocity_).head<2>() / dt;
        const double keep = exponential(-dt / kMemory);
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

void HeadingFinder::turn(const Eigen::Matrix3d& R, const IntervalAverage& travelled) {
    const double angle = arctangent(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
    sum_ = about_up(-angle).topLeftCorner<2, 2>() * sum_;
    mechanised_ = R * mechanised_;  // gravity too, which a tilt would show as acceleration
    force_ = R * force_;
    lever_velocity_ = R * lever_velocity_;
    travelled_ = travelled - (travelled - travelled_).turned(R);
}

void HeadingFinder::turn_with_measured(const Eigen::Matrix3d& R, const IntervalAverage& travelled) {
    turn(R, travelled);
    const Eigen::Matrix2d level = R.topLeftCorner<2, 2>();
    velocity_ = R * velocity_;
    measured_ = level * measured_;
    acceleration_ = level * acceleration_;
}

Eigen::Matrix3d HeadingFinder::upright(double angle) const {
    if (memory_ <= 0.0) {
        return about_up(angle);
    }
    const Eigen::Matrix3d heading = about_up(angle);
    const Eigen::Vector3d force = force_ / memory_;
    const Eigen::Vector2d level = acceleration_ / memory_;
    const double up = std::sqrt(std::max(force.squaredNorm() - level.squaredNorm(), 1.0));
    const Eigen::Vector3d expected(level.x(), level.y(), up);
    const Eigen::Vector3d before = heading.transpose() * expected;
    return heading * Eigen::Quaterniond::FromTwoVectors(force, before).toRotationMatrix();
}

void HeadingFinder::take(const Eigen::Vector2d& u, const Eigen::Vector2d& w, double keep, double sigma) {
    sum_ = keep * sum_ + Eigen::Vector2d(u.dot(w), u.x() * w.y() - u.y() * w.x());
    energy_ = keep * energy_ + u.squaredNorm();
    // Second differences of white noise have the covariances 6, -4 and 1 with themselves and their
    // neighbours: 16 for motion that alternates from one to the next, less for any other.
    noise_ = std::max(keep * noise_, 16.0 * sigma * sigma);
}

}  // namespace truenorth
