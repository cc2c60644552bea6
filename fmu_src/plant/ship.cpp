#include "plant/ship.hpp"

#include "plant/transition.hpp"

namespace truenorth::plant {

Kinematics Ship::at(double time) const {
    double course_now = course;
    double course_rate = 0.0;
    for (const auto& [angle, begin, duration] : turns) {
        if (angle != 0.0) {
            const Transition turn{.change = angle, .begin = begin, .duration = duration};
            course_now += turn.value(time);
            course_rate += turn.rate(time);
        }
    }
    const auto [swaying, water] = plant::at(time, sway, wave);
    const auto& [angle, angle_rate] = swaying;

    // Roll, pitch, heading, and the course of the track.
    const auto [sine, cosine] = sincos(Eigen::Array4d(angle[0], angle[1], course_now - angle[2], course_now));
    const Eigen::Vector3d ahead(sine[3], cosine[3], 0.0);
    const Eigen::Vector3d starboard(cosine[3], -sine[3], 0.0);
    const auto [C_bn, omega_nb_b] =
        turning({.sine = sine.head<3>(), .cosine = cosine.head<3>()},
                {.roll = angle_rate[0], .pitch = angle_rate[1], .heading = course_rate - angle_rate[2]});
    return {
        .velocity = speed * ahead + water.value,
        .acceleration = speed * course_rate * starboard + water.rate,
        .C_bn = C_bn,
        .omega_nb_b = omega_nb_b,
    };
}

}  // namespace truenorth::plant
