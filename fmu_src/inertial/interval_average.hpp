// What an error model needs of the mechanisation over a filter interval: time averages.
//
// Averages of attitude and force make a filter interval of 1 s as good as one of 10 ms on a swaying ship;
// samples at the ends of the interval do not.
#pragma once

#include "inertial/mechanisation.hpp"

namespace truenorth {

class IntervalAverage {
  public:
    // Adds the last increment of the mechanisation, which lasted dt [s]; `before` is the state at its start.
    void add(const NavigationState& before, const Mechanisation& mechanisation, double dt) {
        const NavigationState& after = mechanisation.state;
        duration_ += dt;
        C_bn_ += (0.5 * dt) * (before.q_bn.toRotationMatrix() + after.q_bn.toRotationMatrix());
        delta_velocity_n_ += mechanisation.delta_velocity_n();
        displacement_ += (0.5 * dt) * (before.velocity + after.velocity);
    }

    // What has been added between two moments of a running sum, and such a sum at a share of the way between
    // two.
    friend IntervalAverage operator+(const IntervalAverage& one, const IntervalAverage& other) {
        return mix(one, 1.0, other, 1.0);
    }
    friend IntervalAverage operator-(const IntervalAverage& later, const IntervalAverage& earlier) {
        return mix(later, 1.0, earlier, -1.0);
    }
    static IntervalAverage between(const IntervalAverage& earlier, const IntervalAverage& later,
                                   double share) {
        return mix(earlier, 1.0 - share, later, share);
    }

    // The same as seen from axes that were turned by R: attitude and force, not the velocity.
    [[nodiscard]] IntervalAverage turned(const Eigen::Matrix3d& R) const {
        IntervalAverage average = *this;
        average.C_bn_ = R * C_bn_;
        average.delta_velocity_n_ = R * delta_velocity_n_;
        return average;
    }

    [[nodiscard]] double duration() const { return duration_; }               // [s]
    [[nodiscard]] Eigen::Matrix3d C_bn() const { return C_bn_ / duration_; }  // body to computed ENU
    [[nodiscard]] Eigen::Vector3d force() const {
        return delta_velocity_n_ / duration_;
    }  // computed ENU [m/s2]
    [[nodiscard]] const Eigen::Vector3d& displacement() const { return displacement_; }   // ENU [m]
    [[nodiscard]] Eigen::Vector3d velocity() const { return displacement_ / duration_; }  // ENU [m/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(duration_, C_bn_, delta_velocity_n_, displacement_);
    }

  private:
    static IntervalAverage mix(const IntervalAverage& a, double weight_a, const IntervalAverage& b,
                               double weight_b) {
        IntervalAverage sum;
        sum.duration_ = weight_a * a.duration_ + weight_b * b.duration_;
        sum.C_bn_ = weight_a * a.C_bn_ + weight_b * b.C_bn_;
        sum.delta_velocity_n_ = weight_a * a.delta_velocity_n_ + weight_b * b.delta_velocity_n_;
        sum.displacement_ = weight_a * a.displacement_ + weight_b * b.displacement_;
        return sum;
    }

    double duration_ = 0.0;
    Eigen::Matrix3d C_bn_ = Eigen::Matrix3d::Zero();
    Eigen::Vector3d delta_velocity_n_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d displacement_ = Eigen::Vector3d::Zero();
};

}  // namespace truenorth
