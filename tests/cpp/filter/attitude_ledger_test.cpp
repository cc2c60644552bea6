#include "filter/attitude_ledger.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace truenorth {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Eigen::Matrix3d about(const Vector3d& axis, double angle) {
    return AngleAxisd(angle, axis).toRotationMatrix();
}

TEST(AttitudeLedger, AddsUpCorrectionsInSigmasOfTheStart) {
    AttitudeLedger ledger;
    ledger.open(Vector3d(0.01, 0.02, 0.1).cwiseAbs2());
    EXPECT_EQ(ledger.deviate(0.0, {}), 0.0);
    ledger.turn(about(Vector3d::UnitZ(), 0.2));
    EXPECT_NEAR(ledger.deviate(0.0, {}), 2.0, 1e-9);
    ledger.turn(about(Vector3d::UnitZ(), 0.3));
    EXPECT_NEAR(ledger.deviate(0.0, {}), 5.0, 1e-9);
    ledger.turn(about(Vector3d::UnitZ(), -0.5));
    ledger.turn(about(Vector3d::UnitX(), 0.03));
    EXPECT_NEAR(ledger.deviate(0.0, {}), 3.0, 1e-6);
}

TEST(AttitudeLedger, AllowsForGyrosAndDoubt) {
    AttitudeLedger ledger;
    ledger.open(Vector3d::Constant(1e-6));
    ledger.turn(about(Vector3d::UnitZ(), 0.01));
    EXPECT_NEAR(ledger.deviate(0.0, {}), 10.0, 1e-6);
    EXPECT_NEAR(ledger.deviate(100.0, {.bias = 1e-4}), 0.01 / std::hypot(1e-3, 1e-2), 1e-9);
    EXPECT_NEAR(ledger.deviate(100.0, {.random_walk = 1e-3}), 0.01 / std::hypot(1e-3, 1e-2), 1e-9);
    EXPECT_NEAR(ledger.deviate(300.0, {.bias_random_walk = 1e-6}), 0.01 / std::hypot(1e-3, 3e-3), 1e-9);
    ledger.doubt(Vector3d(0.0, 0.0, 1e-4));
    EXPECT_NEAR(ledger.deviate(0.0, {}), 0.01 / std::hypot(1e-3, 1e-2), 1e-9);
    ledger.open(Vector3d::Constant(1e-6));
    EXPECT_EQ(ledger.deviate(0.0, {}), 0.0);
}

TEST(AttitudeLedger, AllowsForTheTiltThatAWrongHeadingMakes) {
    AttitudeLedger ledger;
    ledger.open(Vector3d::Constant(1e-6));
    ledger.lean(0.1, 6e-5, 300.0);
    ledger.lean(0.05, 6e-5, 400.0);
    ledger.turn(about(Vector3d::UnitX(), 0.01));
    EXPECT_NEAR(ledger.deviate(700.0, {}), 0.01 / std::hypot(1e-3, 3e-3), 1e-9);
    ledger.turn(about(Vector3d::UnitX(), -0.01));
    ledger.turn(about(Vector3d::UnitZ(), 0.01));
    EXPECT_NEAR(ledger.deviate(700.0, {}), 10.0, 1e-9);
}

TEST(AttitudeLedger, AsksForMeasurementsWhereItsVarianceIsAGuess) {
    AttitudeLedger ledger;
    ledger.open(Vector3d(1.0, 1.0, 0.02).cwiseAbs2());
    EXPECT_TRUE(ledger.measured(0.02, 0.0, {}));
    ledger.guess();
    EXPECT_FALSE(ledger.measured(0.02, 0.0, {}));
    EXPECT_FALSE(ledger.measured(0.0142, 0.0, {}));
    EXPECT_TRUE(ledger.measured(0.0141, 0.0, {}));
    EXPECT_TRUE(ledger.measured(0.02, 100.0, {.bias = 2.1e-4}));
    EXPECT_FALSE(ledger.measured(0.02, 100.0, {.bias = 1.9e-4}));
    ledger.open(Vector3d(1.0, 1.0, 0.02).cwiseAbs2());
    EXPECT_TRUE(ledger.measured(0.02, 0.0, {}));
}

}  // namespace
}  // namespace truenorth
