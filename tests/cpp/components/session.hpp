// An inertial filter on the turntable: fed by hand, or for a while.
#pragma once

#include <algorithm>
#include <cereal/archives/binary.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

#include "contract/serialisation.hpp"
#include "filter/aids.hpp"
#include "lines.hpp"
#include "sky.hpp"
#include "turntable.hpp"

namespace truenorth {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kRate = 50;  // IMU samples a second

// A filter fed by hand.
template <class Filter>
class Fed {
  public:
    Fed() = default;

    // Parameters of one filter, inputs of the other.
    auto& initial() {
        if constexpr (requires { filter.inputs.initial; }) {
            return filter.inputs.initial;
        } else {
            return filter.parameters.initial;
        }
    }

    void start(const Turntable& table, double heading_error) {
        initial().roll = table.roll;
        initial().pitch = table.pitch;
        initial().heading = table.heading + heading_error;
        initial().latitude = table.position.latitude;
        initial().longitude = table.position.longitude;
        initial().height = table.position.height;
        initial().velocity.setZero();
        clock = 0.0;
        next = 0.0;
        filter.initialise(0.0);
    }

    void put_sample(double time, const ImuIncrement& increment) {
        auto& port = filter.inputs.imu;
        ++port.sample;
        port.time = time;
        next = time;
        port.delta_angle = increment.delta_angle;
        port.delta_velocity = increment.delta_velocity;
    }

    // Where the filter has channels, they see the `sky`.
    void put_fix(const GnssFix& fix) {
        auto& port = filter.inputs.gnss;
        ++port.sample;
        port.time = fix.time;
        port.latitude = fix.position.latitude;
        port.longitude = fix.position.longitude;
        port.height = fix.position.height;
        port.velocity = fix.velocity;
        if constexpr (requires { port.channel; }) {
            sky.observe(port.channel, fix);
        }
    }

    // The master's clock goes with the samples.
    void step() {
        const double end = std::max(clock, std::isfinite(next) ? next : clock);
        filter.step(clock, end - clock);
        clock = end;
    }

    double clock = 0.0;
    double next = 0.0;
    Sky sky;
    Lines log;
    Filter filter{log};
};

// A sample every 1 / kRate, a fix a second, delivered `latency` samples late.
template <class Filter>
struct Session {
    Turntable table = {};
    double heading_error = 10.0 * kDegree;
    int latency = 0;
    Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
    std::function<Eigen::Vector3d(int second)> fix_noise = [](int) {
        return Eigen::Vector3d(Eigen::Vector3d::Zero());
    };  // of the velocity [m/s]
    std::function<void(ImuIncrement&)> imu_noise = [](ImuIncrement&) {};
    std::function<void(Fed<Filter>&, int k)> after_step = [](Fed<Filter>&, int) {};

    void start(Fed<Filter>& fed) const { fed.start(table, heading_error); }

    // Steps `from` + 1 to `to`.
    void advance(Fed<Filter>& fed, int from, int to) const {
        for (int k = from + 1; k <= to; ++k) {
            const double time = static_cast<double>(k) / kRate;
            ImuIncrement increment = table.increment(static_cast<double>(k - 1) / kRate, time);
            imu_noise(increment);
            fed.put_sample(time, increment);
            if (k > latency && (k - latency) % kRate == 0) {
                const int second = (k - latency) / kRate;
                GnssFix fix = table.fix(second, lever_arm);
                fix.velocity += fix_noise(second);
                fed.put_fix(fix);
            }
            fed.step();
            after_step(fed, k);
        }
    }
    void seconds(Fed<Filter>& fed, double duration) const {
        start(fed);
        advance(fed, 0, static_cast<int>(std::lround(duration * kRate)));
    }
};

template <class Filter>
double heading_error_of(const Fed<Filter>& fed, const Turntable& table) {
    const auto& nav = fed.filter.outputs.nav;
    return wrap_angle(nav.heading - table.heading_at(nav.time));
}

template <class Value>
std::string bytes(const Value& value) {
    std::ostringstream stream;
    cereal::BinaryOutputArchive archive(stream);
    archive(value);
    return stream.str();
}

// The outputs without the counts of what was refused.
template <class Filter>
std::string estimate(const Fed<Filter>& fed) {
    auto outputs = fed.filter.outputs;
    outputs.rejected_fixes = 0;
    outputs.rejected_samples = 0;
    outputs.aid.gnss.rejected = 0;
    outputs.aid.gnss.silent_for = 0.0;
    Aids{}.each([&outputs]<class Aid>(std::type_identity<Aid>, const AidMemory&) {
        Aid::health(outputs.aid).silent_for = 0.0;
    });
    outputs.imu.silent_for = 0.0;
    outputs.clock_disagreements = 0;
    outputs.measurement_weight.setZero();  // of the last fix, whatever became of it
    return bytes(outputs);
}

}  // namespace truenorth
