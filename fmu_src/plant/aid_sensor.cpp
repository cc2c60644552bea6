#include "plant/aid_sensor.hpp"

#include "inertial/attitude.hpp"

namespace truenorth::plant {

BodyVelocitySensor::BodyVelocitySensor(const Errors& errors, std::uint32_t seed)
    : sigma_(errors.sigma),
      scale_(errors.scale_sigma * NoiseStream(seed, NoiseSource::body_velocity_scale).normal(0).x()),
      axes_(quaternion(-errors.boresight_sigma.cwiseProduct(
          NoiseStream(seed, NoiseSource::body_velocity_boresight).normal(0)))),
      noise_(seed, NoiseSource::body_velocity) {}

Eigen::Vector3d BodyVelocitySensor::measure(std::uint64_t number, const Eigen::Vector3d& truth) const {
    return (1.0 + scale_) * axes_ * truth + sigma_.cwiseProduct(noise_.normal(number));
}

ScalarSensor::ScalarSensor(const Errors& errors, const Sources& sources, std::uint32_t seed)
    : sigma_(errors.sigma),
      bias_(errors.bias_sigma * NoiseStream(seed, sources.bias).normal(0).x()),
      noise_(seed, sources.noise) {}

double ScalarSensor::measure(std::uint64_t number, double truth) const {
    return truth + bias_ + sigma_ * noise_.normal(number).x();
}

}  // namespace truenorth::plant
