#include "filter/heading_finder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "inertial/attitude.hpp"

namespace truenorth {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRate = 50.0;  // mechanised steps a second

// A level vehicle that weaves, mechanised with a heading and tilts that are wrong, and the velocities that a
// receiver measures of it.
class Weaving {
  public:
    Weaving(double heading_error, double sigma, unsigned seed)
        : wrong_(AngleAxisd(-heading_error, Vector3d::UnitZ()) * AngleAxisd(0.05, Vector3d::UnitX())),
          sigma_(sigma),
          random_(seed) {}

    // Of the vehicle, ENU [m/s].
    static Vector3d velocity(double t) {
        const double heading = 0.6 * std::sin(0.3 * t);
        return 8.0 * Vector3d(std::sin(heading), std::cos(heading), 0.0);
    }

    void advance(HeadingFinder& finder, double seconds, double amplitude = 1.0) {
        std::normal_distribution<double> normal(0.0, sigma_);
        for (int k = 0; k < std::lround(seconds * kRate); ++k) {
            const double dt = 1.0 / kRate;
            const Vector3d force =
                amplitude * (velocity(time_ + dt) - velocity(time_)) / dt + Vector3d(0.0, 0.0, 9.8);
            const NavigationState before = mechanisation_.state;
            mechanisation_.state.q_bn = wrong_;
            mechanisation_.advance({.dt = dt,
                                    .delta_angle = Vector3d::Zero(),
                                    .delta_velocity = force * dt});  // body axes are those of n
            travelled_.add(before, mechanisation_, dt);
            time_ += dt;
            if (++steps_ % 12 == 0) {
                AntennaState then;
                then.time = time_;
                then.travelled = travelled_;
                const Vector3d noise(normal(random_), normal(random_), normal(random_));
                finder.add(then, amplitude * velocity(time_) + noise, sigma_);
            }
        }
    }

    void turn(HeadingFinder& finder, double angle) {
        const Matrix3d R = AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
        wrong_ = Eigen::Quaterniond(R) * wrong_;
        finder.turn(R, travelled_);
    }

    void turn_with_measured(HeadingFinder& finder, const Matrix3d& R) const {
        finder.turn_with_measured(R, travelled_);
    }

  private:
    Eigen::Quaterniond wrong_;
    double sigma_;
    std::mt19937 random_;
    Mechanisation mechanisation_;
    IntervalAverage travelled_;
    double time_ = 0.0;
    int steps_ = 0;
};

TEST(HeadingFinder, TellsAnyAngleWithinItsSigma) {
    // Normalised errors of 8 angles x 10 seeds, mean square: at most 1.6 with 99.9 % confidence. The sigma is
    // on the safe side: noise of neighbouring differences cancels where the motion is slow.
    double sum = 0.0;
    for (int a = 0; a < 8; ++a) {
        for (unsigned seed = 1; seed <= 10; ++seed) {
            const double error = -3.0 + 0.8 * a;
            HeadingFinder finder;
            finder.start();
            Weaving vehicle(error, 0.04, seed);
            vehicle.advance(finder, 60.0);
            ASSERT_TRUE(finder.tells());
            EXPECT_LT(finder.sigma(), 0.1);
            const double off = wrap_angle(finder.angle() - error) / finder.sigma();
            EXPECT_LT(std::abs(off), 4.5);
            sum += off * off / 80.0;
        }
    }
    EXPECT_GT(sum, 0.01);
    EXPECT_LT(sum, 1.6);
}

TEST(HeadingFinder, FollowsWhatIsCorrected) {
    HeadingFinder finder;
    finder.start();
    Weaving vehicle(2.5, 0.01, 1);
    vehicle.advance(finder, 30.0);
    EXPECT_NEAR(finder.angle(), 2.5, 0.1);
    vehicle.turn(finder, 2.0);
    EXPECT_NEAR(finder.angle(), 0.5, 0.1);
    vehicle.advance(finder, 10.0);
    EXPECT_NEAR(finder.angle(), 0.5, 0.1);
}

// Velocities that are known in the computed frame turn with it: the tilt that they tell is the same as if
// they had come in the new axes from the beginning.
TEST(HeadingFinder, TurnsWhatALogMeasured) {
    HeadingFinder finder;
    finder.start();
    Weaving vehicle(0.0, 0.001, 1);
    vehicle.advance(finder, 60.0);
    const Matrix3d before = finder.upright(0.0);
    const Matrix3d R = AngleAxisd(0.9, Vector3d::UnitZ()).toRotationMatrix();
    vehicle.turn_with_measured(finder, R);
    EXPECT_LT((finder.upright(0.0) * R - R * before).norm(), 1e-9);
}

TEST(HeadingFinder, SaysNothingOfAVehicleThatDoesNotAccelerate) {
    for (const double sigma : {0.04, 0.5}) {
        HeadingFinder finder;
        finder.start();
        EXPECT_FALSE(finder.tells());
        Weaving vehicle(1.0, sigma, 2);
        vehicle.advance(finder, 60.0, 0.0);
        EXPECT_FALSE(finder.tells());
    }
}

TEST(HeadingFinder, SaysNothingWhenTheReceiverDoesNotMeasureTheMotion) {
    HeadingFinder finder;
    finder.start();
    Weaving vehicle(1.0, 0.0, 3);
    vehicle.advance(finder, 10.0);
    HeadingFinder still;
    still.start();
    for (int k = 0; k < 100; ++k) {
        AntennaState then;
        then.time = 0.25 * k;
        still.add(then, Vector3d::Zero(), 0.1);
    }
    EXPECT_FALSE(still.tells());
}

}  // namespace
}  // namespace truenorth
