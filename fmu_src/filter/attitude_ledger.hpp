// Whether the attitude that the filter set out from was as good as it said: all corrections since are held
// against the uncertainty of then. A consistent filter corrects by a few sigmas in all; one that has
// corrected by many was told wrong, and its covariance, which still builds on that, cannot be believed.
//
// Innovations alone do not show it: information on heading comes in small parts, each within its covariance.
#pragma once

#include <cmath>

#include "inertial/attitude.hpp"

namespace truenorth {

class AttitudeLedger {
  public:
    // Sets out with an attitude of this variance, east, north, up [rad2].
    void open(const Eigen::Vector3d& variance) {
        variance_ = variance;
        corrected_.setZero();
        leant_ = 0.0;
        guessed_ = false;
    }

    // That variance is a guess: the one of before has been found wrong, and nobody knows by how much.
    void guess() { guessed_ = true; }

    // It has become uncertain by so much more.
    void doubt(const Eigen::Vector3d& variance) { variance_ += variance; }

    // A heading that may be wrong by so much [rad] has let the Earth, which turns about north at this rate
    // [rad/s], tilt the level frame for so long [s].
    void lean(double heading_sigma, double earth_rate, double elapsed) {
        leant_ += heading_sigma * earth_rate * elapsed;
    }

    // A correction has turned it, ENU.
    void turn(const Eigen::Matrix3d& rotation) { corrected_ += rotation_vector(rotation); }

    struct Gyros {
        double bias = 0.0;              // sigma [rad/s]
        double random_walk = 0.0;       // [rad/s^0.5]
        double bias_random_walk = 0.0;  // [rad/s^1.5]
    };

    // By how many sigmas it has been corrected, `elapsed` seconds after it set out.
    [[nodiscard]] double deviate(double elapsed, const Gyros& gyros) const {
        const Eigen::Array3d added = Eigen::Array3d(leant_, leant_, 0.0).square() + drift(elapsed, gyros);
        return std::sqrt((corrected_.array().square() / (variance_.array() + added)).maxCoeff());
    }

    // Whether what was measured since weighs more than the guess in a heading of this sigma [rad].
    [[nodiscard]] bool measured(double heading_sigma, double elapsed, const Gyros& gyros) const {
        return !guessed_ || heading_sigma * heading_sigma < 0.5 * (variance_.z() + drift(elapsed, gyros));
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(variance_, corrected_, leant_, guessed_);
    }

  private:
    // Variance that gyros have added to each axis [rad2].
    [[nodiscard]] static double drift(double elapsed, const Gyros& gyros) {
        const auto squared = [](double x) { return x * x; };
        return squared(gyros.bias * elapsed) + squared(gyros.random_walk) * elapsed +
               squared(gyros.bias_random_walk * elapsed) * elapsed / 3.0;
    }

    Eigen::Vector3d variance_ = Eigen::Vector3d::Ones();
    Eigen::Vector3d corrected_ = Eigen::Vector3d::Zero();
    double leant_ = 0.0;  // by a wrong heading [rad]
    bool guessed_ = false;
};

}  // namespace truenorth
