#include "plant/ship.hpp"

#include <cmath>

namespace truenorth::plant {

Kinematics Ship::at(double time) const {
    double course_now = course;
    double course_rate = 0.0;
    for (const Turn& turn : turns) {
        course_now += turn.turned(time);
        course_rate += turn.rate(time);
    }
    const Eigen::Vector3d ahead(std::sin(course_now), std::cos(course_now), 0.0);
    const Eigen::Vector3d starboard(std::cos(course_now), -std::sin(course_now), 0.0);
    const auto [water_velocity, water_acceleration] = wave.at(time);

    const auto [angle, angle_rate] = sway.at(time);
    const EulerAngles attitude{angle[0], angle[1], course_now - angle[2]};
    const EulerAngles attitude_rate{angle_rate[0], angle_rate[1], course_rate - angle_rate[2]};
    const Eigen::Matrix3d C_bn = dcm(attitude);

    return {speed * ahead + water_velocity, speed * course_rate * starboard + water_acceleration, C_bn,
            body_rate(attitude, attitude_rate, C_bn)};
}

}  // namespace truenorth::plant
