// The aids that a filter has besides its receiver: what each takes from its port, what it measures
// (aiding/), and what is in doubt when the filter no longer believes itself.
#pragma once

#include <cmath>

#include "aiding/body_velocity.hpp"
#include "aiding/heading.hpp"
#include "aiding/height.hpp"
#include "aiding/nonholonomic.hpp"
#include "aiding/standstill.hpp"
#include "contract/time_tolerance.hpp"
#include "filter/aid_memory.hpp"
#include "filter/gnss_input.hpp"
#include "filter/uncertainty.hpp"

namespace truenorth {

// What is in doubt when an aid has been refused too often: of the prediction, and which of the sensor's
// constant errors (aiding::SensorErrors).
struct AidDoubt {
    const char* name = "";
    Uncertainty prediction;
    int own = 0;
    int own_count = 0;
    double own_least = 0.0;  // how large they may be, by what was refused: of an aid whose one error it is
    bool binds_velocity = false;  // the sensor bears the navigation where there are no fixes
};

template <class Aid>
AidDoubt doubt_of(const Eigen::Vector3d& residual) {
    return {.name = Aid::kName,
            .prediction = Aid::doubt(residual),
            .own = Aid::kOwn,
            .own_count = Aid::kOwnCount,
            .own_least = Aid::kOwnCount == 1 ? residual.norm() : 0.0,
            .binds_velocity = Aid::kBindsVelocity};
}

// What a filter knows of its motion without a sensor, with a new sample of its IMU.
struct OwnMotion {
    double clock = 0.0;                                   // the master's [s]
    bool stood = false;                                   // over a window that has ended
    Eigen::Vector3d mean_rate = Eigen::Vector3d::Zero();  // that the gyros measured over it [rad/s]
};

// Each names itself, says whether it binds the velocity so that the estimate does not coast, follows from the
// parameters, knows its port and the outputs that tell how it does, reads the port, knows what is possible,
// and observes. `sigma` is that of the parameters, for measurements that do not say; its constant errors are
// the kOwnCount of aiding::SensorErrors from kOwn on. What the filter knows of its motion without a sensor is
// an aid without a port: it says when it is due and what is measured then, and with `sigma` 0 it is none.

struct BodyVelocityAid {
    static constexpr const char* kName = "body_velocity";
    static constexpr bool kHasPort = true;
    static constexpr bool kBindsVelocity = true;
    static constexpr bool kIsHeight = false;
    static constexpr bool kIsRate = false;
    static constexpr int kOwn = aiding::kScale;
    static constexpr int kOwnCount = 4;

    Eigen::Vector3d lever_arm;
    double sigma;  // [m/s]

    template <class Parameters>
    static BodyVelocityAid of(const Parameters& p) {
        return {.lever_arm = p.body_velocity.lever_arm, .sigma = p.measurement.body_velocity_sigma};
    }
    template <class Inputs>
    static const auto& port(const Inputs& inputs) {
        return inputs.body_velocity;
    }
    template <class Outputs>
    static auto& health(Outputs& aid) {
        return aid.body_velocity;
    }
    template <class Port>
    static Eigen::Vector3d measured(const Port& port) {
        return port.velocity;
    }
    template <class Port>
    static Eigen::Vector3d sigma_of(const Port& port) {
        return port.sigma;
    }
    static bool possible(const Eigen::Vector3d& measured) {
        return !(measured.array().abs() > GnssInput::kLargestSpeed).any();
    }
    [[nodiscard]] aiding::Observation observe(const aiding::Moment& moment,
                                              const Eigen::Vector3d& measured) const {
        return aiding::body_velocity(moment, lever_arm, measured);
    }
    static Uncertainty doubt(const Eigen::Vector3d& residual) {
        return {.velocity = residual.squaredNorm() * Eigen::Matrix3d::Identity()};
    }
};

struct HeadingAid {
    static constexpr const char* kName = "heading_aid";
    static constexpr bool kHasPort = true;
    static constexpr bool kBindsVelocity = false;
    static constexpr bool kIsHeight = false;
    static constexpr bool kIsRate = false;
    static constexpr int kOwn = aiding::kHeadingBias;
    static constexpr int kOwnCount = 1;

    double sigma;  // [rad]

    template <class Parameters>
    static HeadingAid of(const Parameters& p) {
        return {.sigma = p.measurement.heading_aid_sigma};
    }
    template <class Inputs>
    static const auto& port(const Inputs& inputs) {
        return inputs.heading_aid;
    }
    template <class Outputs>
    static auto& health(Outputs& aid) {
        return aid.heading_aid;
    }
    template <class Port>
    static Eigen::Vector3d measured(const Port& port) {
        return aiding::Observation::single(port.heading);
    }
    template <class Port>
    static Eigen::Vector3d sigma_of(const Port& port) {
        return aiding::Observation::single(port.sigma);
    }
    static bool possible(const Eigen::Vector3d& measured) {
        return std::abs(measured(0)) <= GnssInput::kLargestLongitude;  // a turn either way
    }
    [[nodiscard]] static aiding::Observation observe(const aiding::Moment& moment,
                                                     const Eigen::Vector3d& measured) {
        return aiding::heading(moment, measured(0));
    }
    static Uncertainty doubt(const Eigen::Vector3d& residual) {
        return {.attitude = Eigen::Vector3d(0.0, 0.0, residual.squaredNorm()).asDiagonal()};
    }
};

struct HeightAid {
    static constexpr const char* kName = "height_aid";
    static constexpr bool kHasPort = true;
    static constexpr bool kBindsVelocity = false;
    static constexpr bool kIsHeight = true;
    static constexpr bool kIsRate = false;
    static constexpr int kOwn = aiding::kHeightBias;
    static constexpr int kOwnCount = 1;

    double sigma;  // [m]

    template <class Parameters>
    static HeightAid of(const Parameters& p) {
        return {.sigma = p.measurement.height_aid_sigma};
    }
    template <class Inputs>
    static const auto& port(const Inputs& inputs) {
        return inputs.height_aid;
    }
    template <class Outputs>
    static auto& health(Outputs& aid) {
        return aid.height_aid;
    }
    template <class Port>
    static Eigen::Vector3d measured(const Port& port) {
        return aiding::Observation::single(port.height);
    }
    template <class Port>
    static Eigen::Vector3d sigma_of(const Port& port) {
        return aiding::Observation::single(port.sigma);
    }
    static bool possible(const Eigen::Vector3d& measured) {
        return measured(0) >= GnssInput::kLowest && measured(0) <= GnssInput::kHighest;
    }
    [[nodiscard]] static aiding::Observation observe(const aiding::Moment& moment,
                                                     const Eigen::Vector3d& measured) {
        return aiding::height(moment, measured(0));
    }
    static Uncertainty doubt(const Eigen::Vector3d& residual) {
        return {.position = Eigen::Vector3d(0.0, 0.0, residual.squaredNorm()).asDiagonal()};
    }
};

struct StandstillAid {
    static constexpr const char* kName = "standstill";
    static constexpr bool kHasPort = false;
    static constexpr bool kBindsVelocity = true;
    static constexpr bool kIsHeight = false;
    static constexpr bool kIsRate = false;
    static constexpr int kOwn = 0;
    static constexpr int kOwnCount = 0;

    double sigma;  // [m/s]

    template <class Parameters>
    static StandstillAid of(const Parameters& p) {
        return {.sigma = p.standstill.velocity_sigma};
    }
    template <class Outputs>
    static auto& health(Outputs& aid) {
        return aid.standstill;
    }
    [[nodiscard]] static bool is_due(const OwnMotion& motion, const AidMemory& /*memory*/) {
        return motion.stood;
    }
    static Eigen::Vector3d measured(const OwnMotion& /*motion*/) { return Eigen::Vector3d::Zero(); }
    [[nodiscard]] static aiding::Observation observe(const aiding::Moment& moment,
                                                     const Eigen::Vector3d& /*measured*/) {
        return aiding::standing(moment);
    }
    static Uncertainty doubt(const Eigen::Vector3d& residual) {
        return {.velocity = residual.squaredNorm() * Eigen::Matrix3d::Identity()};
    }
};

struct StandstillRateAid {
    static constexpr const char* kName = "standstill_rate";
    static constexpr bool kHasPort = false;
    static constexpr bool kBindsVelocity = false;
    static constexpr bool kIsHeight = false;
    static constexpr bool kIsRate = true;
    static constexpr int kOwn = 0;
    static constexpr int kOwnCount = 0;

    double sigma;  // of a mean over the window [rad/s]

    template <class Parameters>
    static StandstillRateAid of(const Parameters& p) {
        const double noise = p.process.angle_random_walk / std::sqrt(p.standstill.window);
        const double told = p.standstill.rate_sigma;
        return {.sigma = told > 0.0 ? std::sqrt(told * told + noise * noise) : 0.0};
    }
    template <class Outputs>
    static auto& health(Outputs& aid) {
        return aid.standstill_rate;
    }
    [[nodiscard]] static bool is_due(const OwnMotion& motion, const AidMemory& /*memory*/) {
        return motion.stood;
    }
    static Eigen::Vector3d measured(const OwnMotion& motion) { return motion.mean_rate; }
    [[nodiscard]] static aiding::Observation observe(const aiding::Moment& moment,
                                                     const Eigen::Vector3d& measured) {
        return aiding::not_turning(moment, measured);
    }
    static Uncertainty doubt(const Eigen::Vector3d& /*residual*/) { return {.sensors = 1.0}; }
};

struct NonholonomicAid {
    static constexpr const char* kName = "nonholonomic";
    static constexpr bool kHasPort = false;
    static constexpr bool kBindsVelocity = false;  // forward it may go as it likes
    static constexpr bool kIsHeight = false;
    static constexpr bool kIsRate = false;
    static constexpr int kOwn = aiding::kBoresight;
    static constexpr int kOwnCount = 3;

    Eigen::Vector3d lever_arm;
    double interval;  // [s]
    double sigma;     // [m/s]

    template <class Parameters>
    static NonholonomicAid of(const Parameters& p) {
        const auto& nonholonomic = p.nonholonomic;
        return {.lever_arm = nonholonomic.lever_arm,
                .interval = nonholonomic.interval,
                .sigma = nonholonomic.velocity_sigma};
    }
    template <class Outputs>
    static auto& health(Outputs& aid) {
        return aid.nonholonomic;
    }
    [[nodiscard]] bool is_due(const OwnMotion& motion, const AidMemory& memory) const {
        return motion.clock - memory.heard > interval - kTimeTolerance;
    }
    static Eigen::Vector3d measured(const OwnMotion& /*motion*/) { return Eigen::Vector3d::Zero(); }
    [[nodiscard]] aiding::Observation observe(const aiding::Moment& moment,
                                              const Eigen::Vector3d& /*measured*/) const {
        return aiding::nonholonomic(moment, lever_arm);
    }
    static Uncertainty doubt(const Eigen::Vector3d& residual) {
        return {.velocity = residual.squaredNorm() * Eigen::Matrix3d::Identity()};
    }
};

// All of them, in the order in which they are used.
using Aids =
    AidMemories<BodyVelocityAid, HeadingAid, HeightAid, StandstillAid, StandstillRateAid, NonholonomicAid>;

}  // namespace truenorth
