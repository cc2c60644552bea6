#include "plant/parked_vehicle.hpp"

#include <cmath>

#include "elementary/exponential.hpp"

namespace truenorth::plant {

Kinematics ParkedVehicle::at(double time) const {
    const double left = exponential(-time / settle_time);
    const auto [turn, shift] = plant::at(time, angular_vibration, vibration);
    const auto& [angle, angle_rate] = turn;
    const Eigen::Array3d attitude(settle_roll * left + angle[0], settle_pitch * left + angle[1],
                                  heading - angle[2]);
    const EulerAngles attitude_rate{
        .roll = -settle_roll / settle_time * left + angle_rate[0],
        .pitch = -settle_pitch / settle_time * left + angle_rate[1],
        .heading = -angle_rate[2],
    };
    const auto [C_bn, omega_nb_b] = turning(sincos(attitude), attitude_rate);
    return {
        .velocity = shift.value,
        .acceleration = shift.rate,
        .C_bn = C_bn,
        .omega_nb_b = omega_nb_b,
    };
}

}  // namespace truenorth::plant
