#include "plant/parked_vehicle.hpp"

#include <cmath>

namespace truenorth::plant {

Kinematics ParkedVehicle::at(double time) const {
    const double left = std::exp(-time / settle_time);
    const auto [angle, angle_rate] = angular_vibration.at(time);
    const EulerAngles attitude{settle_roll * left + angle[0], settle_pitch * left + angle[1],
                               heading - angle[2]};
    const EulerAngles attitude_rate{-settle_roll / settle_time * left + angle_rate[0],
                                    -settle_pitch / settle_time * left + angle_rate[1], -angle_rate[2]};
    const Eigen::Matrix3d C_bn = dcm(attitude);
    const auto [velocity, acceleration] = vibration.at(time);
    return {velocity, acceleration, C_bn, body_rate(attitude, attitude_rate, C_bn)};
}

}  // namespace truenorth::plant
