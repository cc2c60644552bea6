#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "filter/filter_outputs.hpp"
#include "inertial/attitude.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(HeadingSigma, IsThatOfTheHeadingAtAnyAttitude) {
    // Headings of attitudes that are wrong by a misalignment drawn from a covariance: the sigma of 20000 is
    // known to 2 % with 99.9 % confidence.
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (const double pitch : {0.0, 6.0, -45.0, 80.0, 89.5, 89.9}) {
        const Matrix3d C_bn = dcm({.roll = 0.3, .pitch = pitch * kDegree, .heading = 1.0});
        const double size = 1e-3 * std::cos(pitch * kDegree);  // small beside the way to the zenith
        Matrix3d root;
        root << 1.0, 0.0, 0.0, 0.5, 2.0, 0.0, -0.3, 0.7, 1.5;
        root *= size;
        double sum = 0.0;
        constexpr int kDraws = 20000;
        for (int k = 0; k < kDraws; ++k) {
            const Vector3d phi = root * Vector3d(normal(random), normal(random), normal(random));
            const Eigen::AngleAxisd turn(phi.norm(), phi.normalized());
            const double heading = euler_angles(turn.toRotationMatrix() * C_bn).heading;
            sum += std::pow(wrap_angle(heading - 1.0), 2);
        }
        const double sigma = heading_sigma(root * root.transpose(), Eigen::Quaterniond(C_bn));
        EXPECT_NEAR(sigma / std::sqrt(sum / kDraws), 1.0, 0.02) << pitch;
    }
}

TEST(HeadingSigma, OfALevelBodyIsThatOfTheAzimuth) {
    const Matrix3d P = Vector3d(0.1, 0.2, 0.3).cwiseAbs2().asDiagonal();
    EXPECT_NEAR(heading_sigma(P, Eigen::Quaterniond::Identity()), 0.3, 1e-15);
}

TEST(HeadingSigma, StraightUpIsThatOfAnyHeading) {
    const Matrix3d up = dcm({.roll = 0.0, .pitch = 90.0 * kDegree, .heading = 0.0});
    EXPECT_NEAR(heading_sigma(Matrix3d::Identity() * 1e-6, Eigen::Quaterniond(up)),
                std::numbers::pi / std::numbers::sqrt3, 1e-12);
}

}  // namespace
}  // namespace truenorth
