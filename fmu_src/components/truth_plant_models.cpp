#include "components/truth_plant_models.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "inertial/attitude.hpp"

namespace truenorth::truth_plant {

namespace {

plant::Ship ship(const Parameters::Motion& motion) {
    const auto& sway = motion.sway;
    const auto& wave = motion.wave;
    plant::Ship ship{
        .course = motion.course,
        .speed = motion.speed,
        .sway = {.amplitude = sway.amplitude, .frequency = sway.period.cwiseInverse(), .phase = sway.phase},
        .wave = {.amplitude = wave.velocity, .frequency = wave.period.cwiseInverse(), .phase = wave.phase},
    };
    for (std::size_t i = 0; i < ship.turns.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        ship.turns[i] = {
            .angle = motion.turn.angle[row],
            .begin = motion.turn.begin[row],
            .duration = motion.turn.duration[row],
        };
    }
    return ship;
}

plant::ParkedVehicle parked_vehicle(const Parameters::Motion& motion) {
    const auto& settle = motion.settle;
    const auto& vibration = motion.vibration;
    // acceleration a sin(w t) = derivative of the velocity (a / w) sin(w t - pi / 2)
    const Eigen::Vector3d velocity =
        vibration.acceleration.cwiseQuotient(2.0 * std::numbers::pi * vibration.frequency);
    return {
        .heading = motion.course,
        .settle_roll = settle.angle[0],
        .settle_pitch = settle.angle[1],
        .settle_time = settle.time_constant,
        .angular_vibration =
            {
                .amplitude = vibration.angle,
                .frequency = vibration.frequency,
                .phase = Eigen::Vector3d::Zero(),
            },
        .vibration =
            {
                .amplitude = velocity,
                .frequency = vibration.frequency,
                .phase = Eigen::Vector3d::Constant(-0.5 * std::numbers::pi),
            },
    };
}

// An aircraft or a road vehicle.
template <class Vehicle>
Vehicle on_segments(const Parameters::Motion& motion) {
    std::array<plant::SegmentedTrack::Segment, plant::SegmentedTrack::kSegments> segments;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        segments[i] = {
            .duration = motion.segment.duration[row],
            .acceleration = motion.segment.acceleration[row],
            .climb_angle = motion.segment.climb_angle[row],
            .turn_angle = motion.segment.turn_angle[row],
        };
    }
    return {{.speed = motion.speed, .climb_angle = 0.0, .course = motion.course}, segments};
}

earth::Position start(const Parameters::Motion& motion) {
    return {.latitude = motion.latitude, .longitude = motion.longitude, .height = motion.height};
}

// Of a vehicle of which nothing is known yet: at rest.
plant::Passage unknown(const Parameters::Motion& motion) {
    const EulerAngles attitude{.heading = motion.course};
    return plant::Passage({.position = start(motion), .q_bn = Eigen::Quaterniond(dcm(attitude))});
}

plant::Motion motion(const Parameters::Motion& motion) {
    switch (motion.kind) {
        case MotionKind::ship:
            return ship(motion);
        case MotionKind::parked_vehicle:
            return parked_vehicle(motion);
        case MotionKind::flight:
            return on_segments<plant::Flight>(motion);
        case MotionKind::external:
            return unknown(motion);
        case MotionKind::road_vehicle:
            return on_segments<plant::RoadVehicle>(motion);
    }
    throw std::logic_error("a motion that validate() does not know");
}

// Gyro and accelerometer have the same errors in different units.
template <class Sensor>
plant::InertialSensor::Errors errors(const Sensor& sensor) {
    return {
        .bias = sensor.bias,
        .bias_sigma = sensor.bias_sigma,
        .bias_limit = sensor.bias_limit,
        .bias_random_walk = sensor.bias_random_walk,
        .white_noise = sensor.white_noise,
        .markov_sigma = sensor.markov_sigma,
        .markov_time = sensor.markov_time,
        .wave_sigma = sensor.wave_sigma,
        .wave_period = sensor.wave_period,
        .wave_damping = sensor.wave_damping,
        .scale_factor = sensor.scale_factor,
        .misalignment = sensor.misalignment,
        .quantisation = sensor.quantisation,
        .bias_step = sensor.bias_step,
        .bias_step_time = sensor.bias_step_time,
        .bias_step_duration = sensor.bias_step_duration,
    };
}

plant::NoiseScale noise_scale(const Parameters::Gnss& gnss) {
    const auto& [step, sine] = gnss.noise_scale;
    return {
        .step_factor = step.factor,
        .step = {.begin = step.begin, .end = step.end},
        .sine_amplitude = sine.amplitude,
        .sine_period = sine.period,
        .sine = {.begin = sine.begin, .end = sine.end},
    };
}

// Of any quantity: probability and size.
template <class Group>
plant::Outliers outliers(const Group& group) {
    return {.probability = group.probability, .size = group.size};
}

plant::GnssReceiver::Errors errors(const Parameters::Gnss& gnss) {
    plant::GnssReceiver::Errors errors{
        .position_sigma = gnss.position_sigma,
        .velocity_sigma = gnss.velocity_sigma,
        .position_outliers = outliers(gnss.position_outlier),
        .velocity_outliers = outliers(gnss.velocity_outlier),
        .outlier_epochs =
            {
                .probability = gnss.outlier_epoch.probability,
                .channel_probability = gnss.outlier_epoch.channel_probability,
                .least = gnss.outlier_epoch.least,
                .largest = gnss.outlier_epoch.largest,
            },
        .noise_scale = noise_scale(gnss),
    };
    for (std::size_t i = 0; i < errors.outages.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        errors.outages[i] = {.begin = gnss.outage.begin[row], .end = gnss.outage.end[row]};
    }
    return errors;
}

plant::ChannelReceiver receiver_of_channels(const Parameters& parameters) {
    const Parameters::Gnss& gnss = parameters.gnss;
    const auto& [count, begin, end] = gnss.satellite_limit;
    return {
        {
            .constellation_epoch = gnss.constellation_epoch,
            .mask_angle = gnss.mask_angle,
            .limit = static_cast<std::size_t>(count),
            .limited = {.begin = begin, .end = end},
        },
        {
            .pseudorange_sigma = gnss.pseudorange_sigma,
            .range_rate_sigma = gnss.range_rate_sigma,
            .pseudorange_outliers = outliers(gnss.pseudorange_outlier),
            .range_rate_outliers = outliers(gnss.range_rate_outlier),
            .noise_scale = noise_scale(gnss),
        },
        static_cast<std::uint32_t>(parameters.seed),
    };
}

plant::ImuFault::Kind kind(ImuFaultKind declared) {
    using Kind = plant::ImuFault::Kind;
    switch (declared) {
        case ImuFaultKind::none:
            return Kind::none;
        case ImuFaultKind::silence:
            return Kind::silence;
        case ImuFaultKind::not_a_number:
            return Kind::not_a_number;
        case ImuFaultKind::spike:
            return Kind::spike;
        case ImuFaultKind::stuck:
            return Kind::stuck;
        case ImuFaultKind::zeros:
            return Kind::zeros;
        case ImuFaultKind::bias_step:
            return Kind::bias_step;
        case ImuFaultKind::scale_step:
            return Kind::scale_step;
        case ImuFaultKind::count_jump:
            return Kind::count_jump;
        case ImuFaultKind::clock_step:
            return Kind::clock_step;
        case ImuFaultKind::clock_drift:
            return Kind::clock_drift;
        case ImuFaultKind::repeated:
            return Kind::repeated;
        case ImuFaultKind::reordered:
            return Kind::reordered;
    }
    throw std::logic_error("a fault of the IMU that validate() does not know");
}

plant::GnssFault::Kind kind(GnssFaultKind declared) {
    using Kind = plant::GnssFault::Kind;
    switch (declared) {
        case GnssFaultKind::none:
            return Kind::none;
        case GnssFaultKind::silence:
            return Kind::silence;
        case GnssFaultKind::frozen:
            return Kind::frozen;
        case GnssFaultKind::position_jump:
            return Kind::position_jump;
        case GnssFaultKind::drift:
            return Kind::drift;
        case GnssFaultKind::velocity_sign:
            return Kind::velocity_sign;
        case GnssFaultKind::time_offset:
            return Kind::time_offset;
        case GnssFaultKind::latency:
            return Kind::latency;
    }
    throw std::logic_error("a fault of the receiver that validate() does not know");
}

// Of any sensor: kind, begin, duration, size, axis.
template <class Fault, class Group>
typename Fault::Settings settings(const Group& group) {
    return {
        .kind = kind(group.kind),
        .begin = group.begin,
        .duration = group.duration,
        .size = group.size,
        .axis = group.axis,
    };
}

// Of any aid: rate and outage.
template <class Group>
plant::AidSchedule schedule(const Group& group, double imu_rate) {
    const double periods = group.rate > 0.0 ? imu_rate / group.rate : 0.0;
    return {.periods = static_cast<std::uint64_t>(std::llround(periods)),
            .outage = {.begin = group.outage.begin, .end = group.outage.end}};
}

template <class Group>
plant::ScalarSensor scalar_sensor(const Group& group, const plant::ScalarSensor::Sources& sources, int seed) {
    return {{.sigma = group.noise_sigma, .bias_sigma = group.bias_sigma},
            sources,
            static_cast<std::uint32_t>(seed)};
}

plant::NoiseStream stream(const Parameters& parameters, plant::NoiseSource source) {
    return {static_cast<std::uint32_t>(parameters.seed), source};
}

}  // namespace

Models::Models(const Parameters& parameters)
    : trajectory(motion(parameters.motion), start(parameters.motion)),
      gyro(errors(parameters.imu.gyro), 1.0 / parameters.imu.rate,
           {
               .bias = stream(parameters, plant::NoiseSource::gyro_bias),
               .walk = stream(parameters, plant::NoiseSource::gyro_bias_walk),
               .white = stream(parameters, plant::NoiseSource::gyro_white),
               .markov = stream(parameters, plant::NoiseSource::gyro_markov),
               .wave = stream(parameters, plant::NoiseSource::gyro_wave),
           }),
      accelerometer(errors(parameters.imu.accelerometer), 1.0 / parameters.imu.rate,
                    {
                        .bias = stream(parameters, plant::NoiseSource::accelerometer_bias),
                        .walk = stream(parameters, plant::NoiseSource::accelerometer_bias_walk),
                        .white = stream(parameters, plant::NoiseSource::accelerometer_white),
                        .markov = stream(parameters, plant::NoiseSource::accelerometer_markov),
                        .wave = stream(parameters, plant::NoiseSource::accelerometer_wave),
                    }),
      receiver(errors(parameters.gnss), static_cast<std::uint32_t>(parameters.seed)),
      channel_receiver(receiver_of_channels(parameters)),
      clock({.bias = parameters.gnss.clock.bias_noise, .drift = parameters.gnss.clock.drift_noise},
            1.0 / parameters.gnss.rate, stream(parameters, plant::NoiseSource::gnss_clock)),
      imu_fault(settings<plant::ImuFault>(parameters.fault.imu), 1.0 / parameters.imu.rate),
      gnss_fault(settings<plant::GnssFault>(parameters.fault.gnss), 1.0 / parameters.imu.rate),
      samples_per_fix(static_cast<std::uint64_t>(std::llround(parameters.imu.rate / parameters.gnss.rate))),
      body_velocity({.sigma = parameters.body_velocity.noise_sigma,
                     .scale_sigma = parameters.body_velocity.scale_sigma,
                     .boresight_sigma = parameters.body_velocity.boresight_sigma},
                    static_cast<std::uint32_t>(parameters.seed)),
      body_velocity_schedule(schedule(parameters.body_velocity, parameters.imu.rate)),
      heading_aid(scalar_sensor(
          parameters.heading_aid,
          {.noise = plant::NoiseSource::heading_aid, .bias = plant::NoiseSource::heading_aid_bias},
          parameters.seed)),
      heading_aid_schedule(schedule(parameters.heading_aid, parameters.imu.rate)),
      height_aid(scalar_sensor(
          parameters.height_aid,
          {.noise = plant::NoiseSource::height_aid, .bias = plant::NoiseSource::height_aid_bias},
          parameters.seed)),
      height_aid_schedule(schedule(parameters.height_aid, parameters.imu.rate)) {}

}  // namespace truenorth::truth_plant
