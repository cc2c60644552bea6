#include "components/truth_plant_rules.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "components/truth_plant_models.hpp"
#include "contract/parameter_rules.hpp"
#include "elementary/sincos.hpp"
#include "inertial/earth.hpp"
#include "plant/fix_queue.hpp"
#include "plant/transition.hpp"

namespace truenorth::truth_plant {

namespace {

// A speed that rounding may leave of none [m/s].
constexpr double kStandstill = 1e-6;

std::string element(const std::string& name, Eigen::Index index) {
    return name + "[" + text(index + 1) + "]";
}

std::string with_value(const std::string& name, double value) { return name + " (" + text(value) + ")"; }

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

// Nobody goes backwards, nor pushes over so fast that he floats: the bank of a coordinated turn is undefined
// without weight, and wheels leave the road.
void check_segments(const Parameters::Motion& motion, const std::string& vehicle) {
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
                          "at least " + with_value("what stops the " + vehicle, -speed / duration[i]));
        }
        const plant::Transition push_over{
            .change = std::min(0.0, climb_angle[i] - climb),
            .begin = 0.0,
            .duration = duration[i],
        };
        const double steepest = std::max(std::abs(climb), std::abs(climb_angle[i]));
        if (std::max(speed, speed_after) * push_over.peak_rate() >=
            earth::kStandardGravity * sincos(steepest).cosine) {
            rules::refuse(element("motion.segment.climb_angle", i), climb_angle[i],
                          "reached in more than " +
                              with_value(element("motion.segment.duration", i), duration[i]) +
                              ": the push-over would be weightless");
        }
        speed = speed_after;
        climb = climb_angle[i];
    }
}

void check_aid(const std::string& name, double rate, double begin, double end, double imu_rate) {
    check_window(name + ".outage.begin", begin, name + ".outage.end", end);
    const double samples = rate > 0.0 ? imu_rate / rate : 1.0;
    if (samples < 1.0 - kWhole || std::abs(samples - std::round(samples)) > kWhole) {
        rules::refuse(
            name + ".rate", rate,
            with_value("imu.rate", imu_rate) + " divided by a whole number, or 0 for no such sensor");
    }
}

bool has_size(ImuFaultKind kind) {
    using enum ImuFaultKind;
    return kind == spike || kind == bias_step || kind == scale_step || kind == count_jump ||
           kind == clock_step || kind == clock_drift;
}

bool has_size(GnssFaultKind kind) {
    using enum GnssFaultKind;
    return kind == position_jump || kind == drift || kind == time_offset || kind == latency;
}

// A fault of size 0 is none, and a run with it would show nothing.
template <class Fault>
void check_size(const std::string& sensor, const Fault& fault) {
    if (has_size(fault.kind) && fault.size == 0.0) {
        rules::refuse(sensor + ".size", fault.size, "other than 0 for a " + sensor + ".kind that has a size");
    }
}

void check_count_jump(double size) {
    constexpr double largest = std::numeric_limits<std::int32_t>::max();
    if (size != std::round(size) || std::abs(size) > largest) {
        rules::refuse("fault.imu.size", size, "a whole number of 32 bits where fault.imu.kind is count_jump");
    }
}

}  // namespace

void check_together(const Parameters& parameters) {
    const Parameters::Motion& motion = parameters.motion;
    const Parameters::Imu& imu = parameters.imu;
    const Parameters::Gnss& gnss = parameters.gnss;
    const Parameters::Fault& fault = parameters.fault;

    if (motion.kind == MotionKind::ship) {
        check_period("motion.sway.period", motion.sway.period, motion.sway.amplitude, imu.rate);
        check_period("motion.wave.period", motion.wave.period, motion.wave.velocity, imu.rate);
    } else if (motion.kind == MotionKind::flight) {
        check_segments(motion, "aircraft");
    } else if (motion.kind == MotionKind::road_vehicle) {
        check_segments(motion, "road vehicle");
    } else if (motion.kind == MotionKind::parked_vehicle) {
        const Eigen::Vector3d amplitude = motion.vibration.angle.cwiseMax(motion.vibration.acceleration);
        check_frequency("motion.vibration.frequency", motion.vibration.frequency, amplitude, imu.rate);
    }

    const double samples_per_fix = imu.rate / gnss.rate;
    if (samples_per_fix < 1.0 - kWhole || std::abs(samples_per_fix - std::round(samples_per_fix)) > kWhole) {
        rules::refuse("gnss.rate", gnss.rate,
                      with_value("imu.rate", imu.rate) + " divided by a whole number");
    }
    // One place of the queue is for the fix that becomes valid as the oldest one appears.
    constexpr std::size_t most_periods = plant::FixQueue::kCapacity - 1;
    const double longest = static_cast<double>(most_periods) / gnss.rate;
    if (gnss.latency > longest) {
        rules::refuse("gnss.latency", gnss.latency,
                      "at most " + with_value(text(most_periods, " periods of gnss.rate"), longest));
    }
    if (fault.gnss.kind == GnssFaultKind::latency) {
        const double more = longest - gnss.latency;
        if (fault.gnss.size < 0.0 || fault.gnss.size > more) {
            rules::refuse(
                "fault.gnss.size", fault.gnss.size,
                "from 0 to " +
                    with_value(text(most_periods, " periods of gnss.rate less gnss.latency"), more) +
                    " where fault.gnss.kind is latency");
        }
    }
    const auto check = [&imu](const std::string& name, const auto& aid) {
        check_aid(name, aid.rate, aid.outage.begin, aid.outage.end, imu.rate);
    };
    check("body_velocity", parameters.body_velocity);
    check("heading_aid", parameters.heading_aid);
    check("height_aid", parameters.height_aid);
    check_size("fault.imu", fault.imu);
    check_size("fault.gnss", fault.gnss);
    if (fault.imu.kind == ImuFaultKind::count_jump) {
        check_count_jump(fault.imu.size);
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

}  // namespace truenorth::truth_plant
