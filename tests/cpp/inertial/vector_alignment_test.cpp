#include "inertial/vector_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "inertial/mechanisation.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

// A ship that sways and surges, mechanised without error; its antenna has fixes once a second.
class Ship {
  public:
    using Bias = Eigen::Matrix<double, 6, 1>;

    // Its sensors are off by `bias`.
    Ship(double heading, const Vector3d& lever_arm, const Bias& bias = Bias::Zero())
        : lever_arm_(lever_arm), bias_(bias) {
        mechanisation_.state = {
            .q_bn = Quaterniond(dcm({.roll = 0.1, .pitch = -0.05, .heading = heading})),
            .velocity = {3.0, 8.0, 0.1},
            .position = {.latitude = 32.0 * kDegree, .longitude = 118.0 * kDegree, .height = 10.0}};
    }

    // The next second, with a fix whose velocity is wrong by `error`.
    void sail(VectorAlignment& alignment, const Vector3d& error) {
        Preintegration interval;
        ImuIncrement increment;
        for (int k = 0; k < 100; ++k) {
            const double t = 0.01 * samples_++;
            increment = {
                .dt = 0.01,
                .delta_angle = {1e-3 * std::cos(0.8 * t), 7e-4 * std::sin(0.6 * t), 5e-4 * std::cos(t)},
                .delta_velocity = {5e-3 * std::sin(0.7 * t), 4e-3 * std::cos(0.9 * t), 0.09795}};
            mechanisation_.advance(increment);
            const ImuIncrement measured{.dt = increment.dt,
                                        .delta_angle = increment.delta_angle + 0.01 * bias_.head<3>(),
                                        .delta_velocity = increment.delta_velocity + 0.01 * bias_.tail<3>()};
            interval = interval * Preintegration::of(previous_, measured);
            previous_ = measured;
        }
        const NavigationState& now = mechanisation_.state;
        const Vector3d omega_ib_b =
            mechanisation_.omega_eb_b() + now.q_bn.conjugate() * earth::rate(now.position.latitude);
        const earth::Position position = point_position(now, lever_arm_);
        const Vector3d velocity = point_velocity(now, mechanisation_.omega_eb_b(), lever_arm_) + error;
        const Vector3d ecef = earth::ecef(position);
        alignment.add(interval, {.position = ecef,
                                 .velocity = earth::C_en(position).transpose() * velocity +
                                             earth::earth_fixed_rate().cross(ecef),
                                 .velocity_arm = omega_ib_b.cross(lever_arm_)});
        if (alignment.fixes() == 1) {
            at_first_fix_ = attitude();
        }
    }

    // Body to Earth-fixed axes, now and at the first fix.
    [[nodiscard]] Quaterniond attitude() const {
        const NavigationState& now = mechanisation_.state;
        return Quaterniond(earth::C_en(now.position).transpose()) * now.q_bn;
    }
    [[nodiscard]] const Quaterniond& at_first_fix() const { return at_first_fix_; }

    [[nodiscard]] Vector3d error(const VectorAlignment::Solution& solution) const {
        return rotation_vector(solution.attitude * attitude().conjugate());
    }

  private:
    Mechanisation mechanisation_;
    Quaterniond at_first_fix_ = Quaterniond::Identity();
    Vector3d lever_arm_;
    Bias bias_;
    ImuIncrement previous_;
    int samples_ = 0;
};

TEST(VectorAlignment, TracesAnAttitudeBackToTheFirstFix) {
    Ship::Bias bias;
    bias << 5e-6, -4e-6, 5e-6, 0.1, -0.2, 0.1;  // 1 deg/h, 20 mg
    Ship ship(2.0, Vector3d::Zero(), bias);
    VectorAlignment alignment;
    for (int s = 0; s < 120; ++s) {
        ship.sail(alignment, Vector3d::Zero());
    }
    const auto off = [&](const Ship::Bias& known) {
        return rotation_vector(alignment.at_first_fix(ship.attitude(), known) *
                               ship.at_first_fix().conjugate())
            .norm();
    };
    EXPECT_LT(off(bias), 1e-6);  // (bias T)^2, and an Earth whose axes turn with the ship's way
    EXPECT_GT(off(Ship::Bias::Zero()), 1e-4);
}

TEST(VectorAlignment, FindsAnyAttitudeFromPerfectFixes) {
    for (const double heading : {0.0, 1.0, 2.5, std::numbers::pi, 5.0}) {
        Ship ship(heading, Vector3d::Zero());
        VectorAlignment alignment;
        for (int k = 0; k < 60; ++k) {
            ship.sail(alignment, Vector3d::Zero());
        }
        const auto solution = alignment.solve();
        ASSERT_TRUE(solution);
        EXPECT_EQ(alignment.fixes(), 60);
        // The mechanisation is good to about 1e-6 m/s; the heading shows in 1 m/s after a minute.
        EXPECT_LT(ship.error(*solution).norm(), 1e-5) << heading;
        EXPECT_LT(rotation_vector(solution->at_first_fix * ship.at_first_fix().conjugate()).norm(), 1e-5);
        EXPECT_LT(solution->covariance.diagonal().maxCoeff(), 1e-9);
    }
}

TEST(VectorAlignment, KnowsOfALeverArm) {
    Ship ship(2.0, {3.0, -10.0, 5.0});
    VectorAlignment alignment;
    for (int k = 0; k < 60; ++k) {
        ship.sail(alignment, Vector3d::Zero());
    }
    EXPECT_LT(ship.error(*alignment.solve()).norm(), 1e-5);
}

TEST(VectorAlignment, UncertaintyIsThatOfTheScatter) {
    constexpr int runs = 100;
    constexpr double sigma = 0.1;
    std::mt19937 generator(3);
    std::normal_distribution<double> normal(0.0, sigma);
    double nees = 0.0;
    for (int run = 0; run < runs; ++run) {
        Ship ship(0.03 * run, Vector3d::Zero());
        VectorAlignment alignment;
        for (int k = 0; k < 100; ++k) {
            ship.sail(alignment, {normal(generator), normal(generator), normal(generator)});
        }
        const auto solution = alignment.solve();
        ASSERT_TRUE(solution);
        const Vector3d error = ship.error(*solution);
        nees += error.dot(solution->covariance.llt().solve(error));
    }
    // 300 degrees of freedom: 99.9 % within 1 +- 3.3 sqrt(2 / 300).
    EXPECT_NEAR(nees / (3.0 * runs), 1.0, 0.27);
}

TEST(VectorAlignment, KnowsWhatItDoesNotKnow) {
    Ship ship(1.0, Vector3d::Zero());
    VectorAlignment alignment;
    for (int k = 0; k < 3; ++k) {
        ship.sail(alignment, Vector3d::Zero());
        EXPECT_FALSE(alignment.solve());
    }
    ship.sail(alignment, Vector3d::Zero());
    EXPECT_TRUE(alignment.solve());

    // In free fall there is no vector at all.
    VectorAlignment falling;
    Preintegration second;
    second.duration = 1.0;
    ExtendedPose pose{.position = {0.0, 6.4e6, 0.0}};
    for (int k = 0; k < 10; ++k) {
        falling.add(second,
                    {.position = pose.position, .velocity = pose.velocity, .velocity_arm = Vector3d::Zero()});
        pose = carried(pose, {}, 1.0);
    }
    const double uniform = std::numbers::pi * std::numbers::pi / 3.0;
    EXPECT_TRUE(falling.solve()->covariance.isApprox(uniform * Matrix3d::Identity(), 1e-6));
}

}  // namespace
}  // namespace truenorth
