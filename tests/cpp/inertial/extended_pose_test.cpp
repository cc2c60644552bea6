#include "inertial/extended_pose.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "inertial/attitude.hpp"

namespace truenorth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Tangent = ExtendedPose::Tangent;

Matrix5d matrix(const ExtendedPose& pose) {
    Matrix5d m = Matrix5d::Identity();
    m.topLeftCorner<3, 3>() = pose.attitude.toRotationMatrix();
    m.topRightCorner<3, 2>() << pose.velocity, pose.position;
    return m;
}

Matrix5d matrix(const Tangent& tangent) {
    Matrix5d m = Matrix5d::Zero();
    m.topLeftCorner<3, 3>() = skew(tangent.head<3>());
    m.topRightCorner<3, 2>() << tangent.segment<3>(3), tangent.tail<3>();
    return m;
}

// The exponential by its series, after halving: the definition.
Matrix5d series(Matrix5d m) {
    constexpr int halvings = 6;
    m /= std::pow(2.0, halvings);
    Matrix5d sum = Matrix5d::Identity();
    Matrix5d term = sum;
    for (int k = 1; k < 15; ++k) {
        term = (term * m / k).eval();
        sum += term;
    }
    for (int k = 0; k < halvings; ++k) {
        sum = (sum * sum).eval();
    }
    return sum;
}

class RandomTangents {
  public:
    // The rotation has the angle given.
    Tangent operator()(double angle) {
        Tangent t;
        for (double& x : t) {
            x = normal_(generator_);
        }
        t.head<3>() *= angle / t.head<3>().norm();
        return t;
    }

  private:
    std::mt19937 generator_{1};
    std::normal_distribution<double> normal_;
};

constexpr std::array kAngles{0.0, 1e-9, 0.9e-3, 1.1e-3, 0.1, 1.5, 3.0, 3.14};

TEST(ExtendedPose, ExponentialIsThatOfMatrices) {
    RandomTangents random;
    for (const double angle : {kAngles[1], kAngles[2], kAngles[3], kAngles[4], 1.5, 3.1, 4.0, 7.0}) {
        const Tangent t = random(angle);
        EXPECT_LT((matrix(ExtendedPose::exponential(t)) - series(matrix(t))).norm(), 1e-13) << angle;
    }
    EXPECT_EQ(matrix(ExtendedPose::exponential(Tangent::Zero())), Matrix5d::Identity());
}

TEST(ExtendedPose, LogarithmUndoesTheExponential) {
    RandomTangents random;
    for (const double angle : kAngles) {
        Tangent t = random(1.0);
        t.head<3>() *= angle;
        // Near half a turn J is nearly singular: rounding over pi - angle.
        EXPECT_LT((ExtendedPose::exponential(t).logarithm() - t).norm(), 1e-11) << angle;
    }
}

TEST(ExtendedPose, ProductAndInverseAreThoseOfMatrices) {
    RandomTangents random;
    const ExtendedPose a = ExtendedPose::exponential(random(2.0));
    const ExtendedPose b = ExtendedPose::exponential(random(1.0));
    EXPECT_LT((matrix(a * b) - matrix(a) * matrix(b)).norm(), 1e-14);
    EXPECT_LT((matrix(a.inverse()) * matrix(a) - Matrix5d::Identity()).norm(), 1e-14);
}

}  // namespace
}  // namespace truenorth
