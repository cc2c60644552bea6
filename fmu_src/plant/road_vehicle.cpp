#include "plant/road_vehicle.hpp"

namespace truenorth::plant {

Kinematics RoadVehicle::at(double time) const {
    const SegmentedTrack::Point point = track_.at(time);
    const auto [C_bn, omega_nb_b] = turning({.sine = {0.0, point.climb.sine, point.direction.sine},
                                             .cosine = {1.0, point.climb.cosine, point.direction.cosine}},
                                            {.pitch = point.climb_angle.rate, .heading = point.course.rate});
    return {
        .velocity = point.velocity(),
        .acceleration = point.acceleration(),
        .C_bn = C_bn,
        .omega_nb_b = omega_nb_b,
    };
}

}  // namespace truenorth::plant
