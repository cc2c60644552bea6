// Satellites that stand still over the turntable, as the channels of a receiver see them: pseudorange and
// range rate from their definitions, in Earth-fixed coordinates.
#pragma once

#include <cmath>
#include <numbers>

#include "error_models/tight.hpp"
#include "filter/gnss_input.hpp"

namespace truenorth {

struct Sky {
    int satellites = 8;
    double distance = 2.2e7;    // [m]
    double speed = 900.0;       // of the satellites, Earth-fixed [m/s]
    double clock_bias = 120.0;  // at time 0, as a range [m]
    double clock_drift = 0.7;   // [m/s]

    // Satellite i in channel i, of the number i + 1.
    template <class Channels>
    void observe(Channels& channels, const GnssFix& fix) const {
        const Eigen::Matrix3d C_ne = earth::C_en(fix.position).transpose();
        const Eigen::Vector3d antenna = earth::ecef(fix.position);
        const Eigen::Vector3d velocity = C_ne * fix.velocity;
        for (int i = 0; i < Tight::kChannels; ++i) {
            const double azimuth = 2.0 * std::numbers::pi * i / satellites;
            const double elevation = 0.3 + 0.9 * (i % 3) / 2.0;
            const Eigen::Vector3d u(std::cos(elevation) * std::sin(azimuth),
                                    std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
            const Eigen::Vector3d satellite = antenna + C_ne * (distance * u);
            const Eigen::Vector3d motion = C_ne * (speed * Eigen::Vector3d(u.y(), -u.x(), 0.3));
            const Eigen::Vector3d line = satellite - antenna;
            channels.valid[i] = i < satellites;
            channels.satellite[i] = i < satellites ? i + 1 : 0;
            channels.pseudorange(i) = line.norm() + clock_bias + clock_drift * fix.time;
            channels.range_rate(i) = line.normalized().dot(motion - velocity) + clock_drift;
            channels.satellite_position.row(i) = satellite;
            channels.satellite_velocity.row(i) = motion;
        }
    }
};

}  // namespace truenorth
