#include "plant/road_vehicle.hpp"

namespace truenorth::plant {

Kinematics RoadVehicle::at(double time) const {
    const SegmentedTrack::Point point = track_.at(time);
    const EulerAngles attitude{.pitch = point.climb_angle.value, .heading = point.course.value};
    const EulerAngles attitude_rate{.pitch = point.climb_angle.rate, .heading = point.course.rate};
    const Eigen::Matrix3d C_bn = dcm(attitude);
    return {
        .velocity = point.velocity(),
        .acceleration = point.acceleration(),
        .C_bn = C_bn,
        .omega_nb_b = body_rate(attitude, attitude_rate, C_bn),
    };
}

}  // namespace truenorth::plant
