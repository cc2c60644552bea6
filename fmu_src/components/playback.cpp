#include "components/playback.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "contract/count_up.hpp"
#include "contract/parameter_rules.hpp"
#include "contract/text.hpp"
#include "contract/time_tolerance.hpp"
#include "plant/time_window.hpp"

namespace truenorth {

namespace {

Eigen::Vector3d vector(const recorded::Triple& values) { return Eigen::Vector3d(values.data()); }

std::string element(const char* name, Eigen::Index index) { return text(name, "[", index + 1, "]"); }

}  // namespace

bool Playback::State::fits(const RecordedSignals& signals) const {
    return first <= samples && samples <= signals.imu().size() && fixes <= signals.gnss().size() &&
           body_velocities <= signals.body_velocity().size() && headings <= signals.heading_aid().size() &&
           heights <= signals.height_aid().size();
}

void Playback::check() const {
    validate(parameters);
    const double lasts = signals_->imu().back().time - signals_->begin();
    if (!(parameters.recording.skip < lasts)) {
        rules::refuse("recording.skip", parameters.recording.skip,
                      text("less than ", lasts, ", which the recording lasts"));
    }
    const auto& [begin, end] = parameters.gnss.outage;
    for (Eigen::Index i = 0; i < begin.size(); ++i) {
        if (end[i] < begin[i]) {
            rules::refuse(element("gnss.outage.end", i), end[i],
                          "at least " + element("gnss.outage.begin", i) + " = " + text(begin[i]));
        }
    }
}

void Playback::initialise(double start_time) {
    check();
    const double begin = signals_->begin() + parameters.recording.skip;
    const auto& imu = signals_->imu();
    const auto first = std::ranges::upper_bound(imu, begin, {}, &recorded::ImuSample::time);
    state_ = {.initialised = true,
              .start_time = start_time,
              .begin = begin,
              .first = static_cast<std::uint64_t>(first - imu.begin()),
              .samples = static_cast<std::uint64_t>(first - imu.begin())};
    outputs = {};
    outputs.imu.time = start_time;
    for (double* const time : {&outputs.gnss.time, &outputs.body_velocity.time, &outputs.heading_aid.time,
                               &outputs.height_aid.time}) {
        *time = start_time;
    }
    state_.fixes = begin_at(signals_->gnss(), begin);
    state_.body_velocities = begin_at(signals_->body_velocity(), begin);
    state_.headings = begin_at(signals_->heading_aid(), begin);
    state_.heights = begin_at(signals_->height_aid(), begin);
    outputs.recording.time = begin;
    put_out_truth();
}

template <class Row>
std::uint64_t Playback::begin_at(const std::vector<Row>& rows, double time) {
    const auto later = std::ranges::upper_bound(rows, time + kTimeTolerance, {}, &Row::time);
    const auto shown = std::find_if(later, rows.end(), [this](const Row& row) { return !withheld(row); });
    if (shown != rows.end()) {
        put_out(*shown);
    }
    return static_cast<std::uint64_t>(later - rows.begin());
}

void Playback::step(double time, double step) {
    if (!state_.initialised) {
        throw std::logic_error("a recording cannot be played before it is initialised");
    }
    if (sample_until(time + step - state_.start_time + state_.begin) > 0) {
        play_aids();
        put_out_truth();
    } else if (state_.samples == signals_->imu().size() && !outputs.recording.ended) {
        outputs.recording.ended = true;
        if (log_->listens()) {
            log_->event(text("the recording has ended at ", outputs.imu.time, " s, ", outputs.recording.time,
                             " s of its own clock: nothing new comes any more"));
        }
    }
}

std::size_t Playback::sample_until(double time) {
    const auto& imu = signals_->imu();
    const std::uint64_t before = state_.samples;
    double missed = 0.0;
    Eigen::Vector3d delta_angle = Eigen::Vector3d::Zero();
    Eigen::Vector3d delta_velocity = Eigen::Vector3d::Zero();
    for (; state_.samples < imu.size() && imu[state_.samples].time <= time + kTimeTolerance;
         ++state_.samples) {
        const recorded::ImuSample& sample = imu[state_.samples];
        missed += state_.samples == state_.first ? 0.0 : sample.missed;
        delta_angle += vector(sample.delta_angle);
        delta_velocity += vector(sample.delta_velocity);
    }
    if (state_.samples > before) {
        outputs.recording.time = imu[state_.samples - 1].time;
        int sample = outputs.imu.sample;
        count_up(sample, 1 + static_cast<int>(missed));
        outputs.imu = {.sample = sample,
                       .time = simulated(outputs.recording.time),
                       .delta_angle = delta_angle,
                       .delta_velocity = delta_velocity};
    }
    return state_.samples - before;
}

void Playback::play_aids() {
    play(signals_->gnss(), state_.fixes, outputs.gnss);
    play(signals_->body_velocity(), state_.body_velocities, outputs.body_velocity);
    play(signals_->heading_aid(), state_.headings, outputs.heading_aid);
    play(signals_->height_aid(), state_.heights, outputs.height_aid);
}

template <class Row, class Output>
void Playback::play(const std::vector<Row>& rows, std::uint64_t& come, Output& output) {
    for (; come < rows.size() && rows[come].shown <= static_cast<double>(state_.samples); ++come) {
        if (!withheld(rows[come])) {
            put_out(rows[come]);
            count_up(output.sample, static_cast<int>(rows[come].count));
        }
    }
}

bool Playback::withheld(const recorded::Fix& fix) const {
    const auto& [begin, end] = parameters.gnss.outage;
    for (Eigen::Index i = 0; i < begin.size(); ++i) {
        if (plant::TimeWindow{.begin = begin[i], .end = end[i]}.contains(simulated(fix.time))) {
            return true;
        }
    }
    return false;
}

void Playback::put_out(const recorded::Fix& fix) {
    auto& output = outputs.gnss;
    output.time = simulated(fix.time);
    output.latitude = fix.latitude;
    output.longitude = fix.longitude;
    output.height = fix.height;
    output.velocity = vector(fix.velocity);
    output.fix_position_sigma = vector(fix.position_sigma);
    output.fix_velocity_sigma = vector(fix.velocity_sigma);
}

void Playback::put_out(const recorded::BodyVelocity& measured) {
    auto& output = outputs.body_velocity;
    output.time = simulated(measured.time);
    output.velocity = vector(measured.velocity);
    output.sigma = vector(measured.sigma);
}

void Playback::put_out(const recorded::HeadingAid& measured) {
    auto& output = outputs.heading_aid;
    output.time = simulated(measured.time);
    output.heading = measured.heading;
    output.sigma = measured.sigma;
}

void Playback::put_out(const recorded::HeightAid& measured) {
    auto& output = outputs.height_aid;
    output.time = simulated(measured.time);
    output.height = measured.height;
    output.sigma = measured.sigma;
}

void Playback::put_out_truth() {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    constexpr recorded::Triple nothing{unknown, unknown, unknown};
    const recorded::Truth truth = signals_->truth().empty() ? recorded::Truth{.roll = unknown,
                                                                              .pitch = unknown,
                                                                              .heading = unknown,
                                                                              .latitude = unknown,
                                                                              .longitude = unknown,
                                                                              .height = unknown,
                                                                              .velocity = nothing}
                                                            : signals_->truth()[state_.samples];
    outputs.truth = {
        .roll = truth.roll,
        .pitch = truth.pitch,
        .heading = truth.heading,
        .latitude = truth.latitude,
        .longitude = truth.longitude,
        .height = truth.height,
        .velocity = vector(truth.velocity),
        .gyro_bias = vector(nothing),
        .accelerometer_bias = vector(nothing),
        .clock_bias = unknown,
        .clock_drift = unknown,
        .time = simulated(outputs.recording.time),
    };
}

}  // namespace truenorth
