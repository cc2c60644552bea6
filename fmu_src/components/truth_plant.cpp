#include "components/truth_plant.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

#include "components/truth_plant_rules.hpp"
#include "contract/text.hpp"
#include "inertial/attitude.hpp"
#include "inertial/earth.hpp"

namespace truenorth {

namespace {

// IMU periods until the first sample that is at least as late as `latency` [s].
std::uint64_t periods_of(double latency, double rate) {
    return static_cast<std::uint64_t>(std::ceil(latency * rate - truth_plant::kWhole));
}

}  // namespace

void TruthPlant::initialise(double start_time) {
    validate(parameters);
    truth_plant::check_together(parameters);
    const Models& models = models_.emplace(parameters);
    state_ = {
        .initialised = true,
        .start_time = start_time,
        .samples = 0,
        .due = 0,
        .steps = 0,
        .sequence = StepSequence(start_time),
        .trajectory = models.trajectory.begin(start_time),
        .begun = {},
        .vehicle = {},
        .gyro = models.gyro.begin(),
        .accelerometer = models.accelerometer.begin(),
        .clock = {.bias = parameters.gnss.clock.bias, .drift = parameters.gnss.clock.drift},
        .channels = {},
        .fixes = {},
        .imu_fault = {},
        .before_gnss_fault = {},
        .told_losses = {},
        .told_refusals = {},
    };
    outputs = {};
    if (parameters.motion.kind == truth_plant::MotionKind::external) {
        look(start_time);  // a vehicle that is not there yet may come with the first step
    }
    outputs.imu.time = models.imu_fault.clock(start_time);
    state_.before_gnss_fault = antenna();
    put_out(models, state_.before_gnss_fault);
    put_out_truth(models);
}

void TruthPlant::retune() {
    validate(parameters);
    truth_plant::check_together(parameters);
    models_.emplace(parameters);
}

void TruthPlant::step(double time, double step) {
    if (!models_) {
        throw std::logic_error("the plant cannot step before it is initialised");
    }
    const Models& models = *models_;
    const double rate = parameters.imu.rate;
    if (step == 0.0) {
        return;
    }
    const double periods = std::round(step * rate);
    const bool whole = periods >= 1.0 && std::abs(step * rate - periods) <= truth_plant::kWhole;
    if (!whole) {
        throw std::invalid_argument("communication step of " + text(step) +
                                    " s: must be a whole number of IMU periods of " + text(1.0 / rate) +
                                    " s (imu.rate = " + text(rate) + ")");
    }
    if (!state_.sequence.continues(time, truth_plant::kWhole / rate)) {
        throw std::invalid_argument("communication step from " + text(time) + " s: must begin at " +
                                    text(state_.sequence.next()) + " s, where the last one ended");
    }
    state_.sequence.advance(time, step);

    const double begin = end_of(state_.due);
    const auto count = static_cast<std::uint64_t>(periods);
    state_.due += count;
    plant::ImuOutput output;
    const std::uint64_t made =
        parameters.motion.kind == truth_plant::MotionKind::external
            ? follow(models, begin, output)
            : travel(models, {.trajectory = &models.trajectory}, state_.samples + count, output);
    if (made == 0) {
        return;
    }
    output.count = ++state_.steps;
    output.time = end_of(state_.samples);
    if (const auto put = models.imu_fault.put_out(state_.imu_fault, output)) {
        put_out(*put);
    }
}

std::uint64_t TruthPlant::travel(const Models& models, const Leg& leg, std::uint64_t last,
                                 plant::ImuOutput& output) {
    // A vehicle that comes into view within an IMU period is not measured before the next one.
    const double first = std::min(end_of(state_.samples), leg.end);
    if (state_.trajectory.time < first) {
        advance(leg, first);
        state_.begun = {};
    }
    const std::uint64_t before = state_.samples;
    while (state_.samples < last && end_of(state_.samples + 1) <= leg.end) {
        ++state_.samples;
        advance(leg, end_of(state_.samples));
        measure(models, output);
        receive(models);
        aid(models);
    }
    if (state_.samples > before) {
        put_out_truth(models);
    }
    if (end_of(state_.samples + 1) > leg.end && state_.trajectory.time < leg.end) {
        advance(leg, leg.end);
    }
    return state_.samples - before;
}

std::uint64_t TruthPlant::follow(const Models& models, double begin, plant::ImuOutput& output) {
    const ExternalVehicle& vehicle = state_.vehicle;
    using Verdict = ExternalVehicle::Verdict;
    // IMU samples in a passage, whatever a damaged state says.
    const auto longest =
        static_cast<std::uint64_t>(ExternalVehicle::kLargestOffset * parameters.imu.rate) + 1;
    Verdict verdict = Verdict::followed;
    std::uint64_t made = 0;
    while (verdict == Verdict::begun || verdict == Verdict::followed) {
        if (vehicle.known()) {
            const plant::Trajectory trajectory(vehicle.passage(), vehicle.from().position);
            const Leg leg{
                .trajectory = &trajectory, .end = vehicle.to().time, .arrival = vehicle.to().position};
            made += travel(models, leg, std::min(state_.due, state_.samples + longest), output);
            if (state_.trajectory.time < vehicle.to().time) {
                return made;  // the vehicle is ahead of the master
            }
        }
        verdict = look(begin);
    }
    if (verdict == Verdict::refused) {
        refuse_state(end_of(state_.due));
    }
    return made;
}

ExternalVehicle::Verdict TruthPlant::look(double begin) {
    using Verdict = ExternalVehicle::Verdict;
    const double rate = parameters.imu.rate;
    const double time = std::isnan(inputs.external.time) ? begin : inputs.external.time;
    // A stamp that is the end of an IMU sample but for rounding is taken for it.
    const double nearest = state_.start_time + std::round((time - state_.start_time) * rate) / rate;
    const double stamp = std::abs(time - nearest) <= truth_plant::kWhole / rate ? nearest : time;
    ExternalVehicle& vehicle = state_.vehicle;
    const Verdict verdict = vehicle.read(inputs.external, stamp, end_of(state_.due));
    if (verdict == Verdict::begun) {
        state_.begun = {};
        const double first =
            std::ceil((vehicle.from().time - state_.start_time) * rate - truth_plant::kWhole);
        if (first > static_cast<double>(state_.samples)) {
            state_.samples = static_cast<std::uint64_t>(first);
            ++state_.steps;  // the count shows that something is missing
        }
    }
    if (verdict == Verdict::begun || verdict == Verdict::followed) {
        const plant::KnownPoint from = vehicle.from();
        state_.trajectory = plant::Trajectory(vehicle.passage(), from.position).begin(from.time);
    }
    return verdict;
}

void TruthPlant::refuse_state(double time) {
    ++outputs.external.rejected;
    if (!log_->listens()) {
        return;
    }
    if (const auto omitted = state_.told_refusals.tell(0, time)) {
        log_->event(text("state of the vehicle refused in the step to ", time, " s",
                         and_others(*omitted).c_str(), ": ", state_.vehicle.flaw().sentence().c_str()));
    }
}

void TruthPlant::advance(const Leg& leg, double to) {
    const plant::Trajectory::Increments gained = leg.trajectory->advance(state_.trajectory, to);
    state_.begun.delta_angle += gained.delta_angle;
    state_.begun.delta_velocity += gained.delta_velocity;
    if (to == leg.end) {
        state_.trajectory.start = leg.arrival;
        state_.trajectory.travelled.setZero();
    }
    const double latitude = state_.trajectory.position().latitude;
    if (std::abs(latitude) > earth::kHighestLatitude) {
        throw std::runtime_error("the motion has come to latitude " + text(latitude) + " rad at " + text(to) +
                                 " s: must stay within " + text(earth::kHighestLatitude) +
                                 " rad, the local-level frame excludes the poles");
    }
}

void TruthPlant::measure(const Models& models, plant::ImuOutput& output) {
    const double time = state_.trajectory.time;
    const plant::Trajectory::Increments truth = std::exchange(state_.begun, {});
    Eigen::Vector3d delta_angle = models.gyro.measure(state_.gyro, state_.samples, time, truth.delta_angle);
    Eigen::Vector3d delta_velocity =
        models.accelerometer.measure(state_.accelerometer, state_.samples, time, truth.delta_velocity);
    models.imu_fault.distort(state_.imu_fault, time, delta_angle, delta_velocity);
    output.delta_angle += delta_angle;
    output.delta_velocity += delta_velocity;
}

void TruthPlant::receive(const Models& models) {
    if (state_.samples % models.samples_per_fix == 0) {
        const std::uint64_t number = state_.samples / models.samples_per_fix;
        models.clock.advance(state_.clock, number);
        const double time = state_.trajectory.time;
        if (models.receiver.lost(time)) {
            lose(time, Loss::outage);
        } else {
            const plant::Fix shown = models.gnss_fault.shown(antenna());
            plant::Fix fix = models.receiver.measure(number, shown);
            fix.channels = models.channel_receiver.measure(number, shown, state_.clock, state_.channels);
            fix = models.gnss_fault.reported(fix, state_.before_gnss_fault);
            if (models.gnss_fault.silences(time)) {
                lose(time, Loss::fault);
            } else {
                const double latency = parameters.gnss.latency + models.gnss_fault.latency(time);
                state_.fixes.push(fix, state_.samples + periods_of(latency, parameters.imu.rate));
            }
        }
    }
    while (state_.fixes.due(state_.samples)) {
        put_out(models, state_.fixes.pop());
        ++outputs.gnss.sample;
    }
}

void TruthPlant::aid(const Models& models) {
    const double time = state_.trajectory.time;
    const plant::Kinematics& kinematics = state_.trajectory.kinematics;
    const auto number = [&](const plant::AidSchedule& schedule) {
        return schedule.number(state_.samples, time);
    };
    if (const auto due = number(models.body_velocity_schedule)) {
        const auto& sensor = parameters.body_velocity;
        const earth::Position imu = state_.trajectory.position();
        const Eigen::Vector3d truth =
            kinematics.C_bn.transpose() * velocity_at(imu, kinematics, sensor.lever_arm);
        auto& output = outputs.body_velocity;
        ++output.sample;
        output.time = time;
        output.velocity = models.body_velocity.measure(*due, truth);
        for (std::size_t i = 0; i < sensor.measures.size(); ++i) {
            if (!sensor.measures[i]) {
                output.velocity[static_cast<Eigen::Index>(i)] = std::numeric_limits<double>::quiet_NaN();
            }
        }
        if (sensor.reports_sigma) {
            output.sigma = sensor.noise_sigma;
        }
    }
    if (const auto due = number(models.heading_aid_schedule)) {
        auto& output = outputs.heading_aid;
        ++output.sample;
        output.time = time;
        output.heading = wrap_angle(models.heading_aid.measure(*due, euler_angles(kinematics.C_bn).heading));
        output.sigma = parameters.heading_aid.reports_sigma ? parameters.heading_aid.noise_sigma : 0.0;
    }
    if (const auto due = number(models.height_aid_schedule)) {
        auto& output = outputs.height_aid;
        ++output.sample;
        output.time = time;
        output.height = models.height_aid.measure(*due, state_.trajectory.position().height);
        output.sigma = parameters.height_aid.reports_sigma ? parameters.height_aid.noise_sigma : 0.0;
    }
}

void TruthPlant::lose(double time, Loss cause) {
    if (!log_->listens()) {
        return;
    }
    if (const auto omitted = state_.told_losses.tell(cause, time)) {
        log_->event(text("fix at ", time,
                         " s lost: ", cause == Loss::outage ? "gnss.outage" : "fault.gnss.kind = silence",
                         and_others(*omitted).c_str()));
    }
}

plant::Fix TruthPlant::antenna() const {
    const plant::Kinematics& kinematics = state_.trajectory.kinematics;
    const earth::Position imu = state_.trajectory.position();
    return {
        .time = state_.trajectory.time,
        .position = displaced(imu, kinematics, parameters.gnss.lever_arm),
        .velocity = velocity_at(imu, kinematics, parameters.gnss.lever_arm),
    };
}

void TruthPlant::put_out(const plant::ImuOutput& output) {
    outputs.imu = {
        .sample = static_cast<int>(output.count),  // a counter of 32 bits wraps
        .time = output.time,
        .delta_angle = output.delta_angle,
        .delta_velocity = output.delta_velocity,
    };
}

void TruthPlant::put_out(const Models& models, const plant::Fix& fix) {
    const auto& gnss = parameters.gnss;
    const auto if_measured = [](bool measured, double value) {
        return measured ? value : std::numeric_limits<double>::quiet_NaN();
    };
    auto& output = outputs.gnss;
    output.time = fix.time;
    output.longitude = if_measured(gnss.measures_position[0], fix.position.longitude);
    output.latitude = if_measured(gnss.measures_position[1], fix.position.latitude);
    output.height = if_measured(gnss.measures_position[2], fix.position.height);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        output.velocity[row] = if_measured(gnss.measures_velocity[i], fix.velocity[row]);
    }
    if (gnss.reports_sigma) {
        output.fix_position_sigma = models.receiver.position_sigma(fix.time);
        output.fix_velocity_sigma = models.receiver.velocity_sigma(fix.time);
    }
    auto& channels = output.channel;
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
    const earth::Position position = trajectory.position();
    const double since_fix =
        static_cast<double>(state_.samples % models.samples_per_fix) / parameters.imu.rate;
    const plant::ImuFault::Axes fault = models.imu_fault.bias(trajectory.time);
    outputs.truth = {
        .roll = attitude.roll,
        .pitch = attitude.pitch,
        .heading = attitude.heading,
        .latitude = position.latitude,
        .longitude = position.longitude,
        .height = position.height,
        .velocity = trajectory.kinematics.velocity,
        .gyro_bias = models.gyro.slow_error(state_.gyro, trajectory.time) + fault.head<3>().matrix(),
        .accelerometer_bias =
            models.accelerometer.slow_error(state_.accelerometer, trajectory.time) + fault.tail<3>().matrix(),
        .clock_bias = state_.clock.bias + since_fix * state_.clock.drift,
        .clock_drift = state_.clock.drift,
        .time = trajectory.time,
    };
}

}  // namespace truenorth
