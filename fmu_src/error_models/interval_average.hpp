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

    [[nodiscard]] double duration() const { return duration_; }               // [s]
    [[nodiscard]] Eigen::Matrix3d C_bn() const { return C_bn_ / duration_; }  // body to computed ENU
    [[nodiscard]] Eigen::Vector3d force() const {
        return delta_velocity_n_ / duration_;
    }  // computed ENU [m/s2]
    [[nodiscard]] Eigen::Vector3d velocity() const { return displacement_ / duration_; }  // ENU [m/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(duration_, C_bn_, delta_velocity_n_, displacement_);
    }

  private:
    double duration_ = 0.0;
    Eigen::Matrix3d C_bn_ = Eigen::Matrix3d::Zero();
    Eigen::Vector3d delta_velocity_n_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d displacement_ = Eigen::Vector3d::Zero();
};

}  // namespace truenorth
