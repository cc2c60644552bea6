#include "components/truth_plant.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

namespace {

using truth_plant::MotionKind;
using truth_plant::Parameters;

// Tolerance when a communication step or a ratio of rates is taken for a whole number.
constexpr double kWhole = 1e-3;

// The same limit as that of motion.latitude [rad].
constexpr double kHighestLatitude = 1.57;

// A speed that rounding may leave of none [m/s].
constexpr double kStandstill = 1e-6;

std::string element(const std::string& name, Eigen::Index index) {
    return name + "[" + rules::text(index + 1) + "]";
}

std::string with_value(const std::string& name, double value) {
    return name + " (" + rules::text(value) + ")";
}

void check_period(const std::string& name, const Eigen::Vector3d& period, const Eigen::Vector3d& amplitude,
                  double imu_rate) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (amplitude[i] > 0.0 && period[i] <= 2.0 / imu_rate) {
            rules::refuse(element(name, i), period[i],
                          "greater than " + with_value("two IMU periods", 2.0 / imu_rate));
        }
    }
}

void check_frequency(const std::string& name, const Eigen::Vector3d& frequency,
                     const Eigen::Vector3d& amplitude, double imu_rate) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (amplitude[i] > 0.0 && frequency[i] >= 0.5 * imu_rate) {
            rules::refuse(element(name, i), frequency[i],
                          "less than " + with_value("half of imu.rate", 0.5 * imu_rate));
        }
    }
}

void check_window(const std::string& begin_name, double begin, const std::string& end_name, double end) {
    if (end < begin) {
        rules::refuse(end_name, end, "at least " + with_value(begin_name, begin));
    }
}

// The aircraft never flies backwards, and never pushes over so fast that it floats: the bank of a coordinated
// turn is undefined without weight.
void check_flight(const Parameters::Motion& motion) {
    const auto& [duration, acceleration, climb_angle, turn_angle] = motion.segment;
    double speed = motion.speed;
    double climb = 0.0;
    for (Eigen::Index i = 0; i < duration.size(); ++i) {
        if (duration[i] == 0.0) {
            continue;
        }
        const double speed_after = speed + acceleration[i] * duration[i];
        if (speed_after < -kStandstill) {
            rules::refuse(element("motion.segment.acceleration", i), acceleration[i],
                          "at least " + with_value("what stops the aircraft", -speed / duration[i]));
        }
        const plant::Transition push_over{
            .change = std::min(0.0, climb_angle[i] - climb),
            .begin = 0.0,
            .duration = duration[i],
        };
        const double steepest = std::max(std::abs(climb), std::abs(climb_angle[i]));
        if (std::max(speed, speed_after) * push_over.peak_rate() >=
            earth::kStandardGravity * std::cos(steepest)) {
            rules::refuse(element("motion.segment.climb_angle", i), climb_angle[i],
                          "reached in more than " +
                              with_value(element("motion.segment.duration", i), duration[i]) +
                              ": the push-over would be weightless");
        }
        speed = speed_after;
        climb = climb_angle[i];
    }
}

// The rules that a declaration of a single variable cannot state.
void check_together(const Parameters& parameters) {
    const auto& [seed, motion, imu, gnss] = parameters;

    if (motion.kind == MotionKind::ship) {
        check_period("motion.sway.period", motion.sway.period, motion.sway.amplitude, imu.rate);
        check_period("motion.wave.period", motion.wave.period, motion.wave.velocity, imu.rate);
    } else if (motion.kind == MotionKind::flight) {
        check_flight(motion);
    } else {
        const Eigen::Vector3d amplitude = motion.vibration.angle.cwiseMax(motion.vibration.acceleration);
        check_frequency("motion.vibration.frequency", motion.vibration.frequency, amplitude, imu.rate);
    }

    const double samples_per_fix = imu.rate / gnss.rate;
    if (samples_per_fix < 1.0 - kWhole || std::abs(samples_per_fix - std::round(samples_per_fix)) > kWhole) {
        rules::refuse("gnss.rate", gnss.rate,
                      with_value("imu.rate", imu.rate) + " divided by a whole number");
    }
    const double longest = static_cast<double>(plant::FixQueue::kCapacity - 1) / gnss.rate;
    if (gnss.latency > longest) {
        rules::refuse("gnss.latency", gnss.latency,
                      "at most " + with_value("31 periods of gnss.rate", longest));
    }
    for (Eigen::Index i = 0; i < gnss.outage.end.size(); ++i) {
        check_window(element("gnss.outage.begin", i), gnss.outage.begin[i], element("gnss.outage.end", i),
                     gnss.outage.end[i]);
    }
    const auto& [probability, channel_probability, least, largest] = gnss.outlier_epoch;
    if (largest < least) {
        rules::refuse("gnss.outlier_epoch.largest", largest,
                      "at least " + with_value("gnss.outlier_epoch.least", least));
    }
    check_window("gnss.satellite_limit.begin", gnss.satellite_limit.begin, "gnss.satellite_limit.end",
                 gnss.satellite_limit.end);
    const auto& [step, sine] = gnss.noise_scale;
    check_window("gnss.noise_scale.step.begin", step.begin, "gnss.noise_scale.step.end", step.end);
    check_window("gnss.noise_scale.sine.begin", sine.begin, "gnss.noise_scale.sine.end", sine.end);
}

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

plant::Flight flight(const Parameters::Motion& motion) {
    std::array<plant::Flight::Segment, plant::Flight::kSegments> segments;
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

plant::Motion motion(const Parameters::Motion& motion) {
    switch (motion.kind) {
        case MotionKind::ship:
            return ship(motion);
        case MotionKind::parked_vehicle:
            return parked_vehicle(motion);
        case MotionKind::flight:
            return flight(motion);
    }
    throw std::logic_error("a motion that validate() does not know");
}

// Gyro and accelerometer have the same errors in different units.
template <class Sensor>
plant::InertialSensor::Errors errors(const Sensor& sensor) {
    return {
        .bias = sensor.bias,
        .bias_sigma = sensor.bias_sigma,
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

plant::NoiseStream stream(const Parameters& parameters, plant::NoiseSource source) {
    return {static_cast<std::uint32_t>(parameters.seed), source};
}

}  // namespace

TruthPlant::Models::Models(const Parameters& parameters)
    : trajectory(motion(parameters.motion),
                 {
                     .latitude = parameters.motion.latitude,
                     .longitude = parameters.motion.longitude,
                     .height = parameters.motion.height,
                 }),
      gyro(errors(parameters.imu.gyro), 1.0 / parameters.imu.rate,
           {
               .bias = stream(parameters, plant::NoiseSource::gyro_bias),
               .white = stream(parameters, plant::NoiseSource::gyro_white),
               .markov = stream(parameters, plant::NoiseSource::gyro_markov),
               .wave = stream(parameters, plant::NoiseSource::gyro_wave),
           }),
      accelerometer(errors(parameters.imu.accelerometer), 1.0 / parameters.imu.rate,
                    {
                        .bias = stream(parameters, plant::NoiseSource::accelerometer_bias),
                        .white = stream(parameters, plant::NoiseSource::accelerometer_white),
                        .markov = stream(parameters, plant::NoiseSource::accelerometer_markov),
                        .wave = stream(parameters, plant::NoiseSource::accelerometer_wave),
                    }),
      receiver(errors(parameters.gnss), static_cast<std::uint32_t>(parameters.seed)),
      channel_receiver(receiver_of_channels(parameters)),
      clock({.bias = parameters.gnss.clock.bias_noise, .drift = parameters.gnss.clock.drift_noise},
            1.0 / parameters.gnss.rate, stream(parameters, plant::NoiseSource::gnss_clock)),
      samples_per_fix(static_cast<std::uint64_t>(std::llround(parameters.imu.rate / parameters.gnss.rate))),
      samples_of_latency(
          static_cast<std::uint64_t>(std::ceil(parameters.gnss.latency * parameters.imu.rate - kWhole))) {}

void TruthPlant::initialise(double start_time) {
    validate(parameters);
    check_together(parameters);
    const Models& models = models_.emplace(parameters);
    state_ = {
        .initialised = true,
        .start_time = start_time,
        .samples = 0,
        .trajectory = models.trajectory.begin(start_time),
        .gyro = models.gyro.begin(),
        .accelerometer = models.accelerometer.begin(),
        .clock = {.bias = parameters.gnss.clock.bias, .drift = parameters.gnss.clock.drift},
        .channels = {},
        .fixes = {},
    };
    outputs = {};
    outputs.imu.time = start_time;
    put_out(antenna(models));
    put_out_truth(models);
}

void TruthPlant::retune() {
    validate(parameters);
    models_.emplace(parameters);
}

void TruthPlant::step(double time, double step) {
    if (!models_) {
        throw std::logic_error("the plant cannot step before it is initialised");
    }
    const Models& models = *models_;
    const double rate = parameters.imu.rate;
    const double periods = std::round(step * rate);
    const bool whole = periods >= 1.0 && std::abs(step * rate - periods) <= kWhole;
    if (!whole) {
        throw std::invalid_argument("communication step of " + rules::text(step) +
                                    " s: must be a whole number of IMU periods of " +
                                    rules::text(1.0 / rate) + " s (imu.rate = " + rules::text(rate) + ")");
    }
    // A master may sum up its steps: rounding adds up, and still must not reach the next sample.
    const double ahead = (time - state_.start_time) * rate - static_cast<double>(state_.samples);
    const bool continues = std::abs(ahead) <= 0.1;
    if (!continues) {
        throw std::invalid_argument("communication step from " + rules::text(time) + " s: the plant is at " +
                                    rules::text(state_.trajectory.time) + " s");
    }

    outputs.imu.delta_angle.setZero();
    outputs.imu.delta_velocity.setZero();
    for (auto left = static_cast<std::uint64_t>(periods); left > 0; --left) {
        sample(models);
        receive(models);
    }
    ++outputs.imu.sample;
    outputs.imu.time = state_.trajectory.time;
    put_out_truth(models);
    if (std::abs(outputs.truth.latitude) > kHighestLatitude) {
        throw std::invalid_argument("the motion has come to a pole, which the local-level frame excludes");
    }
}

// One IMU period.
void TruthPlant::sample(const Models& models) {
    ++state_.samples;
    const double time = state_.start_time + static_cast<double>(state_.samples) / parameters.imu.rate;
    const auto [delta_angle, delta_velocity] = models.trajectory.advance(state_.trajectory, time);
    outputs.imu.delta_angle += models.gyro.measure(state_.gyro, state_.samples, time, delta_angle);
    outputs.imu.delta_velocity +=
        models.accelerometer.measure(state_.accelerometer, state_.samples, time, delta_velocity);
}

// The fix that becomes valid at this IMU sample, and the fixes that appear at it.
void TruthPlant::receive(const Models& models) {
    if (state_.samples % models.samples_per_fix == 0) {
        const std::uint64_t number = state_.samples / models.samples_per_fix;
        models.clock.advance(state_.clock, number);
        const plant::Fix truth = antenna(models);
        if (!models.receiver.lost(truth.time)) {
            plant::Fix fix = models.receiver.measure(number, truth);
            fix.channels = models.channel_receiver.measure(number, truth, state_.clock, state_.channels);
            state_.fixes.push(fix, state_.samples + models.samples_of_latency);
        } else if (log_->listens()) {
            log_->event("fix at " + rules::text(truth.time) + " s lost: gnss.outage");
        }
    }
    while (state_.fixes.due(state_.samples)) {
        put_out(state_.fixes.pop());
        ++outputs.gnss.sample;
    }
}

plant::Fix TruthPlant::antenna(const Models& models) const {
    const plant::Kinematics& kinematics = state_.trajectory.kinematics;
    const earth::Position imu = models.trajectory.position(state_.trajectory);
    return {
        .time = state_.trajectory.time,
        .position = displaced(imu, kinematics, parameters.gnss.lever_arm),
        .velocity = velocity_at(imu, kinematics, parameters.gnss.lever_arm),
    };
}

void TruthPlant::put_out(const plant::Fix& fix) {
    outputs.gnss.time = fix.time;
    outputs.gnss.latitude = fix.position.latitude;
    outputs.gnss.longitude = fix.position.longitude;
    outputs.gnss.height = fix.position.height;
    outputs.gnss.velocity = fix.velocity;
    auto& channels = outputs.gnss.channel;
    for (std::size_t i = 0; i < plant::kChannels; ++i) {
        const plant::Channel& channel = fix.channels[i];
        const auto row = static_cast<Eigen::Index>(i);
        channels.valid[i] = channel.satellite != 0;
        channels.satellite[i] = channel.satellite;
        channels.pseudorange[row] = channel.pseudorange;
        channels.range_rate[row] = channel.range_rate;
        channels.satellite_position.row(row) = channel.satellite_position;
        channels.satellite_velocity.row(row) = channel.satellite_velocity;
    }
}

void TruthPlant::put_out_truth(const Models& models) {
    const plant::Trajectory::State& trajectory = state_.trajectory;
    const EulerAngles attitude = euler_angles(trajectory.kinematics.C_bn);
    const earth::Position position = models.trajectory.position(trajectory);
    const double since_fix =
        static_cast<double>(state_.samples % models.samples_per_fix) / parameters.imu.rate;
    outputs.truth = {
        .roll = attitude.roll,
        .pitch = attitude.pitch,
        .heading = attitude.heading,
        .latitude = position.latitude,
        .longitude = position.longitude,
        .height = position.height,
        .velocity = trajectory.kinematics.velocity,
        .gyro_bias = models.gyro.slow_error(state_.gyro, trajectory.time),
        .accelerometer_bias = models.accelerometer.slow_error(state_.accelerometer, trajectory.time),
        .clock_bias = state_.clock.bias + since_fix * state_.clock.drift,
        .clock_drift = state_.clock.drift,
    };
}

}  // namespace truenorth
