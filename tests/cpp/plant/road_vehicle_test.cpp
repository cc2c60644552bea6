#include "plant/road_vehicle.hpp"

#include <gtest/gtest.h>

#include "inertial/earth.hpp"
#include "plant/motions.hpp"

namespace truenorth::plant {
namespace {

TEST(RoadVehicle, ItsWheelsDoNotSlip) {
    for (double t = 0.0; t < 80.0; t += 0.37) {
        const Kinematics now = drive_with_stops().at(t);
        const Eigen::Vector3d wheels = now.C_bn.transpose() * now.velocity;
        EXPECT_LT(std::hypot(wheels.x(), wheels.z()), 1e-12) << "t = " << t;
        EXPECT_GE(wheels.y(), -1e-12) << "t = " << t;
    }
}

TEST(RoadVehicle, StandsWhereItsSpeedIsZero) {
    for (const double t : {-5.0, 3.0, 9.9, 35.0, 50.0}) {
        const Kinematics now = drive_with_stops().at(t);
        EXPECT_LT(now.velocity.norm(), 1e-12) << "t = " << t;
        EXPECT_LT(now.acceleration.norm(), 1e-12) << "t = " << t;
        EXPECT_EQ(now.omega_nb_b.norm(), 0.0) << "t = " << t;
    }
    EXPECT_NEAR(euler_angles(drive_with_stops().at(50.0).C_bn).pitch, 4.0 * kDegree, 1e-14);
}

// Unlike an aircraft: with V X' of it the passengers lean.
TEST(RoadVehicle, DoesNotBankInATurn) {
    const Kinematics now = drive_with_stops().at(23.0);  // in the middle: the course rate peaks
    const double course_rate = 1.875 * 90.0 * kDegree / 10.0;
    const EulerAngles attitude = euler_angles(now.C_bn);
    EXPECT_NEAR(attitude.roll, 0.0, 1e-14);
    const Eigen::Vector3d force =
        now.C_bn.transpose() * (now.acceleration + Eigen::Vector3d(0, 0, earth::kStandardGravity));
    EXPECT_NEAR(force.x(), 12.0 * std::cos(4.0 * kDegree) * course_rate, 1e-9);
}

}  // namespace
}  // namespace truenorth::plant
