// Whether the attitude that the filter set out from was as good as it said: all corrections since are held
// against the uncertainty of then. A consistent filter corrects by a few sigmas in all; one that has corrected
// by many was told wrong, and its covariance, which still builds on that, cannot be believed.
//
// Innovations alone do not show it: information on heading comes in small parts, each within its covariance.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace truenorth {

class AttitudeLedger {
  public:
    // Sets out with an attitude of this variance, east, north, up [rad2].
    void open(const Eigen::Vector3d& variance) {
        variance_ = variance;
        corrected_.setZero();
    }

    // It has become uncertain by so much more.
    void doubt(const Eigen::Vector3d& variance) { variance_ += variance; }

    // A correction has turned it, ENU.
    void turn(const Eigen::Matrix3d& rotation) {
        const Eigen::AngleAxisd turned(rotation);
        corrected_ += turned.angle() * turned.axis();
    }

    // By how many sigmas it has been corrected, `elapsed` seconds after it set out with gyros whose bias is
    // known to gyro_bias [rad/s] and whose white noise is angle_random_walk [rad/s^0.5].
    [[nodiscard]] double deviate(double elapsed, double gyro_bias, double angle_random_walk) const {
        const double drift = gyro_bias * elapsed;
        const double added = drift * drift + angle_random_walk * angle_random_walk * elapsed;
        return (corrected_.array().square() / (variance_.array() + added)).sqrt().maxCoeff();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(variance_, corrected_);
    }

  private:
    Eigen::Vector3d variance_ = Eigen::Vector3d::Ones();
    Eigen::Vector3d corrected_ = Eigen::Vector3d::Zero();
};

}  // namespace truenorth
