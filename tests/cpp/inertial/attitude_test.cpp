#include "inertial/attitude.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;
const Vector3d kRight = Vector3d::UnitX();
const Vector3d kForward = Vector3d::UnitY();
const Vector3d kUp = Vector3d::UnitZ();

TEST(AboutUp, IsARotationAboutTheThirdAxis) {
    for (const double angle : {0.0, 0.3, -2.0, 3.1}) {
        const Matrix3d expected = Eigen::AngleAxisd(angle, kUp).toRotationMatrix();
        EXPECT_LT((about_up(angle) - expected).norm(), 1e-15);
    }
}

TEST(Between, IsWhatSlerpGives) {
    std::srand(5);
    for (int i = 0; i < 100; ++i) {
        const Quaterniond a = Quaterniond::UnitRandom();
        const Quaterniond b = Quaterniond::UnitRandom();
        EXPECT_NEAR(angle_between(a, b), a.angularDistance(b), 1e-14);
        EXPECT_NEAR(angle_between(a, a), 0.0, 1e-15);
        for (const double share : {0.0, 0.3, 1.0}) {
            EXPECT_LT(angle_between(between(a, b, share), a.slerp(share, b)), 1e-14);
        }
    }
}

TEST(Dcm, OfZeroAnglesPointsForwardNorthAndRightEast) {
    EXPECT_LT((dcm(EulerAngles{}) - Matrix3d::Identity()).norm(), 1e-16);
}

TEST(Dcm, HeadingIsClockwiseFromNorth) {
    const Matrix3d C = dcm({.heading = 90.0 * kDegree});
    EXPECT_LT((C * kForward - Vector3d(1.0, 0.0, 0.0)).norm(), 1e-15);  // forward points east
    EXPECT_LT((C * kRight - Vector3d(0.0, -1.0, 0.0)).norm(), 1e-15);   // right points south
}

TEST(Dcm, PositivePitchRaisesTheBowAboutTheRightAxis) {
    const Matrix3d C = dcm({.pitch = 30.0 * kDegree});
    EXPECT_LT((C * kForward - Vector3d(0.0, std::sqrt(3.0) / 2.0, 0.5)).norm(), 1e-15);
    EXPECT_LT((C * kRight - kRight).norm(), 1e-15);
}

TEST(Dcm, PositiveRollLowersTheRightSideAboutTheForwardAxis) {
    const Matrix3d C = dcm({.roll = 30.0 * kDegree});
    EXPECT_LT((C * kRight - Vector3d(std::sqrt(3.0) / 2.0, 0.0, -0.5)).norm(), 1e-15);
    EXPECT_LT((C * kForward - kForward).norm(), 1e-15);
}

TEST(Dcm, RollIsTheInnermostRotation) {
    // Roll leaves the forward axis where heading and pitch put it; pitch leaves the right axis level.
    const EulerAngles angles{.roll = 0.7, .pitch = 0.4, .heading = 2.0};
    const Vector3d forward(std::sin(2.0) * std::cos(0.4), std::cos(2.0) * std::cos(0.4), std::sin(0.4));
    EXPECT_LT((dcm(angles) * kForward - forward).norm(), 1e-15);
    EXPECT_NEAR((dcm({0.0, 0.4, 2.0}) * kRight).z(), 0.0, 1e-16);
    EXPECT_NEAR((dcm({0.0, 0.4, 2.0}) * kRight).x(), std::cos(2.0), 1e-15);
}

TEST(Dcm, IsThatOfThreeRotationsOneAfterTheOther) {
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> angle(-7.0, 7.0);
    for (int i = 0; i < 200; ++i) {
        const EulerAngles angles{
            .roll = angle(generator), .pitch = angle(generator), .heading = angle(generator)};
        const Quaterniond q = Eigen::AngleAxisd(-angles.heading, kUp) *
                              Eigen::AngleAxisd(angles.pitch, kRight) *
                              Eigen::AngleAxisd(angles.roll, kForward);
        EXPECT_LT((dcm(angles) - q.toRotationMatrix()).norm(), 2e-15);
    }
}

TEST(EulerAnglesOf, UndoDcm) {
    for (const unsigned seed : {1U, 20260U}) {
        std::mt19937 generator(seed);
        std::uniform_real_distribution<double> unit(-1.0, 1.0);
        for (int i = 0; i < 200; ++i) {
            const EulerAngles angles{
                .roll = 3.14 * unit(generator),
                .pitch = 1.5 * unit(generator),
                .heading = kPi * (1.0 + 0.999 * unit(generator)),
            };
            const EulerAngles back = euler_angles(dcm(angles));
            const double tolerance = 1e-15 / std::cos(angles.pitch) * 4.0;
            EXPECT_NEAR(back.roll, angles.roll, tolerance);
            EXPECT_NEAR(back.pitch, angles.pitch, tolerance);
            EXPECT_NEAR(back.heading, angles.heading, tolerance);
        }
    }
}

TEST(EulerAnglesOf, KeepTheHeadingInOneTurn) {
    for (const double heading : {-1e-3, -1e-12, -1e-17, 0.0, 1e-17, 3.0, -3.0, 6.28}) {
        const double found = euler_angles(dcm({.roll = 0.0, .pitch = 0.0, .heading = heading})).heading;
        EXPECT_GE(found, 0.0) << heading;
        EXPECT_LT(found, 2.0 * kPi) << heading;
        EXPECT_NEAR(std::remainder(found - heading, 2.0 * kPi), 0.0, 1e-15);
    }
}

TEST(EulerAnglesOf, KeepTheirDigitsCloseToTheVertical) {
    const double off = 1e-6;
    const EulerAngles back = euler_angles(dcm({.roll = 0.3, .pitch = 0.5 * kPi - off, .heading = 1.0}));
    EXPECT_NEAR(back.pitch, 0.5 * kPi - off, 1e-15);  // an arc sine would lose half of them
    EXPECT_NEAR(back.heading, 1.0, 1e-9);
    EXPECT_NEAR(back.roll, 0.3, 1e-9);
}

TEST(Skew, IsTheCrossProduct) {
    const Vector3d a(1.0, -2.0, 3.0);
    const Vector3d b(-4.0, 5.0, 0.5);
    EXPECT_EQ(skew(a) * b, Vector3d(-16.0, -12.5, -3.0));
}

TEST(QuaternionOf, TurnsAboutTheVectorByItsLength) {
    const Vector3d axis = Vector3d(1.0, -2.0, 0.5).normalized();
    // Both branches of the series, their border at 1e-4, and rotations close to half a turn and beyond.
    for (const double angle : {1e-150, 1e-12, 1e-5, 0.99e-4, 1.01e-4, 0.1, 1.0, kPi - 1e-9, kPi, 5.0}) {
        const Quaterniond q = quaternion(angle * axis);
        const long double half = 0.5L * static_cast<long double>(angle);
        const Vector3d expected = static_cast<double>(std::sin(half)) * axis;
        EXPECT_NEAR(q.w(), static_cast<double>(std::cos(half)), 4e-16) << angle;  // half an ulp of the angle
        EXPECT_LT((q.vec() - expected).norm(), 4e-16 * expected.norm()) << angle;
        EXPECT_NEAR(q.norm(), 1.0, 3e-16) << angle;
    }
}

TEST(QuaternionOf, IsTheActiveRotation) {
    // A quarter turn about up takes right to forward.
    EXPECT_LT((quaternion(0.5 * kPi * kUp) * kRight - kForward).norm(), 1e-15);
}

TEST(QuaternionOf, ZeroIsTheIdentity) {
    EXPECT_EQ(quaternion(Vector3d::Zero()).coeffs(), Quaterniond::Identity().coeffs());
}

TEST(RotationVectorOf, UndoesQuaternion) {
    const Vector3d axis = Vector3d(-0.3, 0.8, 1.1).normalized();
    for (const double angle :
         {0.0, 1e-300, 1e-14, 1e-12, 3e-12, 1e-8, 1e-4, 0.5, 2.0, kPi - 1e-6, kPi - 1e-12}) {
        const Vector3d back = rotation_vector(quaternion(angle * axis));
        EXPECT_LT((back - angle * axis).norm(), 1e-15 * (angle + 1e-300) * 4.0 + 1e-320) << angle;
    }
}

TEST(RotationVectorOf, IsTheShortWayRound) {
    const Vector3d long_way(0.0, 0.0, 2.0 * kPi - 0.25);
    EXPECT_LT((rotation_vector(quaternion(long_way)) - Vector3d(0.0, 0.0, -0.25)).norm(), 1e-14);
}

TEST(RotationVectorOf, DoesNotDependOnTheSignOfTheQuaternion) {
    for (const double angle : {1e-13, 0.1, 3.0}) {
        const Quaterniond q = quaternion(Vector3d(0.0, angle, 0.0));
        const Quaterniond negative(-q.w(), -q.x(), -q.y(), -q.z());
        EXPECT_EQ(rotation_vector(negative), rotation_vector(q));
    }
}

TEST(WrapAngle, IsWithinHalfATurnAndDiffersByWholeTurns) {
    for (const double angle : {0.0, 1.0, -1.0, 3.0, 3.2, -3.2, 6.0, 7.0, -7.0, 100.0, -1000.0}) {
        const double wrapped = wrap_angle(angle);
        EXPECT_GE(wrapped, -kPi);
        EXPECT_LT(wrapped, kPi);
        const double turns = (angle - wrapped) / (2.0 * kPi);
        EXPECT_NEAR(turns, std::round(turns), 1e-13) << angle;
    }
}

TEST(LeftJacobian, IsTheDerivativeOfTheRotation) {
    const Eigen::Vector3d axis = Eigen::Vector3d(2.0, -3.0, 6.0) / 7.0;
    for (const double angle : {0.0, 1e-6, 9e-4, 1.1e-3, 0.5, 3.0, 6.0, 40.0}) {
        const Eigen::Vector3d a = angle * axis;
        Eigen::Matrix3d expected;
        const double h = 1e-5;
        for (int i = 0; i < 3; ++i) {
            const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
            expected.col(i) =
                rotation_vector(quaternion(a + step) * quaternion(Eigen::Vector3d(a - step)).conjugate()) /
                (2.0 * h);
        }
        EXPECT_LT((left_jacobian(a) - expected).norm(), 1e-9) << angle;
    }
}

TEST(WrapAngle, TakesHalfATurnToItsNegative) {
    EXPECT_EQ(wrap_angle(kPi), -kPi);
    EXPECT_EQ(wrap_angle(-kPi), -kPi);
}

TEST(WrapAngle, KeepsToItsRangeBesideHalfATurn) {
    for (const double turns : {-3.0, -1.0, 1.0, 3.0, 5.0, 21.0}) {
        double angle = turns * kPi;
        for (int i = 0; i < 4; ++i) {
            angle = std::nextafter(angle, -1e9);
        }
        for (int i = 0; i < 8; ++i, angle = std::nextafter(angle, 1e9)) {
            EXPECT_GE(wrap_angle(angle), -kPi) << angle;
            EXPECT_LT(wrap_angle(angle), kPi) << angle;
        }
    }
}

TEST(WrapAngle, LeavesAnglesAlreadyInRangeAsTheyAre) {
    for (const double angle : {0.0, 1e-17, -1e-17, 1.234, -3.1, 3.1}) {
        EXPECT_EQ(wrap_angle(angle), angle);
    }
}

}  // namespace
}  // namespace truenorth
