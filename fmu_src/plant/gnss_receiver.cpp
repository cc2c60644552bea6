#include "plant/gnss_receiver.hpp"

#include <algorithm>
#include <utility>

namespace truenorth::plant {

GnssReceiver::GnssReceiver(Errors errors, std::uint32_t seed)
    : errors_(std::move(errors)),
      position_(seed, NoiseSource::gnss_position),
      velocity_(seed, NoiseSource::gnss_velocity),
      position_outlier_(seed, NoiseSource::gnss_position_outlier),
      velocity_outlier_(seed, NoiseSource::gnss_velocity_outlier),
      outlier_epoch_(seed, NoiseSource::gnss_outlier_epoch) {}

bool GnssReceiver::lost(double time) const {
    return std::ranges::any_of(errors_.outages,
                               [time](const TimeWindow& outage) { return outage.contains(time); });
}

Eigen::Vector3d GnssReceiver::position_sigma(double time) const {
    return errors_.noise_scale.at(time) * errors_.position_sigma;
}

Eigen::Vector3d GnssReceiver::velocity_sigma(double time) const {
    return errors_.noise_scale.at(time) * errors_.velocity_sigma;
}

Fix GnssReceiver::measure(std::uint64_t fix, const Fix& truth) const {
    const double scale = errors_.noise_scale.at(truth.time);
    const Eigen::Matrix<double, 6, 1> epoch = errors_.outlier_epochs.draw(outlier_epoch_, fix);
    const Eigen::Vector3d position_error =
        scale * errors_.position_sigma.cwiseProduct(position_.normal(fix) + epoch.head<3>()) +
        errors_.position_outliers.draw(position_outlier_, fix);
    const Eigen::Vector3d velocity_error =
        scale * errors_.velocity_sigma.cwiseProduct(velocity_.normal(fix) + epoch.tail<3>()) +
        errors_.velocity_outliers.draw(velocity_outlier_, fix);
    return {
        .time = truth.time,
        .position = earth::displaced(truth.position, position_error),
        .velocity = truth.velocity + velocity_error,
    };
}

}  // namespace truenorth::plant
