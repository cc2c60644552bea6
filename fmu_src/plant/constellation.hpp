// A constellation like that of GPS: 24 satellites, 4 in each of 6 planes, on circular orbits of 26560 km
// radius and 55 deg inclination (Walker delta 55:24/6/1: a satellite is 15 deg ahead of its neighbour in the
// plane west of it). Two-body motion about a uniformly rotating Earth, and nothing else: no eccentricity, no
// perturbations, no satellite clocks.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace truenorth::plant {

inline constexpr std::size_t kSatellites = 24;

// In the Earth-fixed frame e.
struct Satellite {
    Eigen::Vector3d position;  // [m]
    Eigen::Vector3d velocity;  // relative to the Earth [m/s]
};

// All satellites at `time` [s]; number i is element i - 1. At time 0 the ascending node of the first plane is
// at longitude 0 and satellite 1 passes through it.
std::array<Satellite, kSatellites> constellation(double time);

}  // namespace truenorth::plant
