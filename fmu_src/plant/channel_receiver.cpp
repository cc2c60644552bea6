#include "plant/channel_receiver.hpp"

#include <cmath>

#include "elementary/sincos.hpp"
#include "inertial/earth.hpp"

namespace truenorth::plant {

std::array<Channel, kChannels> ChannelReceiver::measure(std::uint64_t fix, const Fix& truth,
                                                        const ReceiverClock::State& clock,
                                                        ChannelAllocation& allocation) const {
    const Eigen::Vector3d antenna = earth::ecef(truth.position);
    const Eigen::Matrix3d C_en = earth::C_en(truth.position);
    const Eigen::Vector3d velocity = C_en.transpose() * truth.velocity;
    const Eigen::Vector3d up = C_en.row(2);
    const auto satellites = constellation(reception_.constellation_epoch + truth.time);

    ChannelAllocation::Elevations sines{};
    for (std::size_t i = 0; i < kSatellites; ++i) {
        sines[i] = up.dot((satellites[i].position - antenna).normalized());
    }
    allocation.update(sines, sincos(reception_.mask_angle).sine,
                      reception_.limited.contains(truth.time) ? reception_.limit : kChannels);

    const double scale = errors_.noise_scale.at(truth.time);
    std::array<Channel, kChannels> channels{};
    for (std::size_t i = 0; i < kChannels; ++i) {
        const std::int32_t number = allocation.satellites()[i];
        if (number == 0) {
            continue;
        }
        const auto stream = [&](NoiseSource source) {
            return NoiseStream(seed_, source, static_cast<std::uint32_t>(number));
        };
        const Satellite& satellite = satellites[static_cast<std::size_t>(number) - 1];
        const Eigen::Vector3d sight = satellite.position - antenna;
        const double range = sight.norm();
        const double range_rate = sight.dot(satellite.velocity - velocity) / range;
        const Eigen::Vector3d noise = scale * stream(NoiseSource::gnss_channel).normal(fix);
        const double pseudorange_outlier =
            errors_.pseudorange_outliers.draw(stream(NoiseSource::gnss_pseudorange_outlier), fix).x();
        const double range_rate_outlier =
            errors_.range_rate_outliers.draw(stream(NoiseSource::gnss_range_rate_outlier), fix).x();
        channels[i] = {
            .satellite = number,
            .pseudorange = range + clock.bias + errors_.pseudorange_sigma * noise[0] + pseudorange_outlier,
            .range_rate = range_rate + clock.drift + errors_.range_rate_sigma * noise[1] + range_rate_outlier,
            .satellite_position = satellite.position,
            .satellite_velocity = satellite.velocity,
        };
    }
    return channels;
}

}  // namespace truenorth::plant
