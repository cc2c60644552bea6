// The motions that the tests of the plant share.
#pragma once

#include <numbers>

#include "plant/flight.hpp"
#include "plant/parked_vehicle.hpp"
#include "plant/road_vehicle.hpp"
#include "plant/ship.hpp"

namespace truenorth::plant {

inline constexpr double kDegree = std::numbers::pi / 180.0;

// The sway of Zhou 2011 (roll 8 deg / 8 s, pitch 6 deg / 10 s, yaw 5 deg / 6 s) in waves of 0.5 m/s, under
// way at 10 m/s on course 0.3 rad; no turns.
inline Ship swaying_ship() {
    Ship ship;
    ship.course = 0.3;
    ship.speed = 10.0;
    ship.sway.amplitude = kDegree * Eigen::Vector3d(8.0, 6.0, 5.0);
    ship.sway.frequency = Eigen::Vector3d(8.0, 10.0, 6.0).cwiseInverse();
    ship.sway.phase = {0.3, 1.1, 2.0};
    ship.wave.amplitude.setConstant(0.5);
    ship.wave.frequency = Eigen::Vector3d(7.0, 9.0, 8.0).cwiseInverse();
    ship.wave.phase = {0.0, 1.0, 0.5};
    return ship;
}

// Settles from small tilts with a time constant of 5 s and vibrates with 11, 12 and 13 Hz.
inline ParkedVehicle parked_vehicle() {
    ParkedVehicle vehicle;
    vehicle.heading = 1.0;
    vehicle.settle_roll = 4e-4;
    vehicle.settle_pitch = -3e-4;
    vehicle.settle_time = 5.0;
    vehicle.angular_vibration.amplitude = {2e-5, 3e-5, 4e-5};
    vehicle.angular_vibration.frequency = {11.0, 12.0, 13.0};
    vehicle.angular_vibration.phase.setZero();
    vehicle.vibration.amplitude = {3e-4, 3e-4, 6e-4};
    vehicle.vibration.frequency = {11.0, 12.0, 13.0};
    vehicle.vibration.phase.setConstant(-1.5);
    return vehicle;
}

// Takes off from standstill, accelerates, climbs, turns right while it climbs, levels off, turns left, brakes
// and descends: every quantity changes alone and with the others.
inline Flight eventful_flight() {
    return Flight({.speed = 0.0, .climb_angle = 0.0, .course = 90.0 * kDegree},
                  {{
                      {.duration = 40.0, .acceleration = 2.0},
                      {.duration = 10.0, .acceleration = 1.0, .climb_angle = 12.0 * kDegree},
                      {.duration = 60.0, .climb_angle = 12.0 * kDegree, .turn_angle = 120.0 * kDegree},
                      {.duration = 0.0, .acceleration = 50.0, .climb_angle = 1.0, .turn_angle = 1.0},
                      {.duration = 15.0, .turn_angle = 20.0 * kDegree},
                      {.duration = 30.0},
                      {.duration = 45.0, .turn_angle = -180.0 * kDegree},
                      {.duration = 30.0,
                       .acceleration = -1.5,
                       .climb_angle = -8.0 * kDegree,
                       .turn_angle = -30.0 * kDegree},
                  }});
}

// Stands for 10 s on the level, starts uphill, turns both ways, stops on the slope for 20 s, and goes on.
inline RoadVehicle drive_with_stops() {
    return RoadVehicle({.speed = 0.0, .climb_angle = 0.0, .course = 30.0 * kDegree},
                       {{
                           {.duration = 10.0},
                           {.duration = 8.0, .acceleration = 1.5, .climb_angle = 4.0 * kDegree},
                           {.duration = 10.0, .climb_angle = 4.0 * kDegree, .turn_angle = 90.0 * kDegree},
                           {.duration = 6.0, .acceleration = -2.0, .climb_angle = 4.0 * kDegree},
                           {.duration = 20.0, .climb_angle = 4.0 * kDegree},
                           {.duration = 10.0, .acceleration = 1.0, .turn_angle = -70.0 * kDegree},
                       }});
}

}  // namespace truenorth::plant
