// What a GNSS receiver knows at one instant.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "inertial/earth.hpp"

namespace truenorth::plant {

// Measurement to one satellite; its position and velocity in the Earth-fixed frame e at the fix's time.
struct Channel {
    std::int32_t satellite = 0;  // number from 1 on; 0: none, the channel has no measurement
    double pseudorange = 0.0;    // [m]
    double range_rate = 0.0;     // [m/s]
    Eigen::Vector3d satellite_position = Eigen::Vector3d::Zero();  // [m]
    Eigen::Vector3d satellite_velocity = Eigen::Vector3d::Zero();  // relative to the Earth [m/s]

    template <class Archive>
    void serialize(Archive& archive) {
        archive(satellite, pseudorange, range_rate, satellite_position, satellite_velocity);
    }
};

inline constexpr std::size_t kChannels = 12;

struct Fix {
    double time = 0.0;                                   // of validity [s]
    earth::Position position;                            // of the antenna
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the antenna: east, north, up [m/s]
    std::array<Channel, kChannels> channels{};

    template <class Archive>
    void serialize(Archive& archive) {
        archive(time, position, velocity, channels);
    }
};

}  // namespace truenorth::plant
