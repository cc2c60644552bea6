#include "plant/ship.hpp"

#include <cmath>

#include "plant/transition.hpp"

namespace truenorth::plant {

Kinematics Ship::at(double time) const {
    double course_now = course;
    double course_rate = 0.0;
    for (const auto& [angle, begin, duration] : turns) {
        const Transition turn{.change = angle, .begin = begin, .duration = duration};
        course_now += turn.value(time);
        course_rate += turn.rate(time);
    }
    const Eigen::Vector3d ahead(std::sin(course_now), std::cos(course_now), 0.0);
    const Eigen::Vector3d starboard(std::cos(course_now), -std::sin(course_now), 0.0);
    const auto [water_velocity, water_acceleration] = wave.at(time);

    const auto [angle, angle_rate] = sway.at(time);
    const EulerAngles attitude{.roll = angle[0], .pitch = angle[1], .heading = course_now - angle[2]};
    const EulerAngles attitude_rate{
        .roll = angle_rate[0],
        .pitch = angle_rate[1],
        .heading = course_rate - angle_rate[2],
    };
    const Eigen::Matrix3d C_bn = dcm(attitude);

    return {
        .velocity = speed * ahead + water_velocity,
        .acceleration = speed * course_rate * starboard + water_acceleration,
        .C_bn = C_bn,
        .omega_nb_b = body_rate(attitude, attitude_rate, C_bn),
    };
}

}  // namespace truenorth::plant
