#include "plant/gnss_receiver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace truenorth::plant {

double NoiseScale::at(double time) const {
    double scale = step.contains(time) ? step_factor : 1.0;
    if (sine.contains(time)) {
        scale *= 1.0 + sine_amplitude * std::sin(2.0 * std::numbers::pi * (time - sine.begin) / sine_period);
    }
    return scale;
}

Eigen::Vector3d Outliers::draw(const NoiseStream& stream, std::uint64_t fix) const {
    const Eigen::Vector4d u = stream.uniform(fix);
    if (u[3] >= probability) {
        return Eigen::Vector3d::Zero();
    }
    return size * (u.head<3>().array() - 0.5).sign();
}

GnssReceiver::GnssReceiver(Errors errors, std::uint32_t seed)
    : errors_(std::move(errors)),
      position_(seed, NoiseSource::gnss_position),
      velocity_(seed, NoiseSource::gnss_velocity),
      position_outlier_(seed, NoiseSource::gnss_position_outlier),
      velocity_outlier_(seed, NoiseSource::gnss_velocity_outlier) {}

bool GnssReceiver::lost(double time) const {
    return std::ranges::any_of(errors_.outages,
                               [time](const TimeWindow& outage) { return outage.contains(time); });
}

Fix GnssReceiver::measure(std::uint64_t fix, const Fix& truth) const {
    const double scale = errors_.noise_scale.at(truth.time);
    const Eigen::Vector3d position_error =
        scale * errors_.position_sigma.cwiseProduct(position_.normal(fix)) +
        errors_.position_outliers.draw(position_outlier_, fix);
    const Eigen::Vector3d velocity_error =
        scale * errors_.velocity_sigma.cwiseProduct(velocity_.normal(fix)) +
        errors_.velocity_outliers.draw(velocity_outlier_, fix);
    return {
        .time = truth.time,
        .position = earth::displaced(truth.position, position_error),
        .velocity = truth.velocity + velocity_error,
    };
}

}  // namespace truenorth::plant
