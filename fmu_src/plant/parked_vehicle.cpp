#include "plant/parked_vehicle.hpp"

#include <cmath>

namespace truenorth::plant {

Kinematics ParkedVehicle::at(double time) const {
    const double left = std::exp(-time / settle_time);
    const auto [angle, angle_rate] = angular_vibration.at(time);
    const EulerAngles attitude{
        .roll = settle_roll * left + angle[0],
        .pitch = settle_pitch * left + angle[1],
        .heading = heading - angle[2],
    };
    const EulerAngles attitude_rate{
        .roll = -settle_roll / settle_time * left + angle_rate[0],
        .pitch = -settle_pitch / settle_time * left + angle_rate[1],
        .heading = -angle_rate[2],
    };
    const Eigen::Matrix3d C_bn = dcm(attitude);
    const auto [velocity, acceleration] = vibration.at(time);
    return {
        .velocity = velocity,
        .acceleration = acceleration,
        .C_bn = C_bn,
        .omega_nb_b = body_rate(attitude, attitude_rate, C_bn),
    };
}

}  // namespace truenorth::plant
