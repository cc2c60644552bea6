// The aids that a filter has besides its receiver: what each takes from its port, what it measures
// (aiding/), and what is in doubt when the filter no longer believes itself.
#pragma once

#include <cmath>

#include "aiding/body_velocity.hpp"
#include "aiding/heading.hpp"
#include "aiding/height.hpp"
#include "components/gnss_input.hpp"
#include "components/uncertainty.hpp"

namespace truenorth {

// What is in doubt when an aid has been refused too often: of the prediction, and which of the sensor's
// constant errors (aiding::SensorErrors).
struct AidDoubt {
    const char* name;
    Uncertainty prediction;
    int own;
    int own_count;
    bool binds_velocity;  // the sensor bears the navigation where there are no fixes
};

template <class Aid, int K>
AidDoubt doubt_of(const Vector<K>& residual) {
    return {.name = Aid::kName,
            .prediction = Aid::doubt(residual),
            .own = Aid::kOwn,
            .own_count = Aid::kOwnCount,
            .binds_velocity = Aid::kBindsVelocity};
}

// Each names itself, says whether it binds the velocity so that the estimate does not coast, reads its port,
// knows what is possible, and observes. `sigma` is that of the parameters, for measurements that do not say;
// its constant errors are the kOwnCount of aiding::SensorErrors from kOwn on.

struct BodyVelocityAid {
    static constexpr const char* kName = "body_velocity";
    static constexpr int kChannels = 3;
    static constexpr bool kBindsVelocity = true;
    static constexpr bool kIsHeight = false;
    static constexpr int kOwn = aiding::kScale;
    static constexpr int kOwnCount = 4;

    Eigen::Vector3d lever_arm;
    double sigma;  // [m/s]

    template <class Port>
    static Vector<3> measured(const Port& port) {
        return port.velocity;
    }
    static bool possible(const Vector<3>& measured) {
        return !(measured.array().abs() > GnssInput::kLargestSpeed).any();
    }
    [[nodiscard]] aiding::Observation<3> observe(const aiding::Moment& moment,
                                                 const Vector<3>& measured) const {
        return aiding::body_velocity(moment, lever_arm, measured);
    }
    static Uncertainty doubt(const Vector<3>& residual) {
        return {.velocity = residual.squaredNorm() * Eigen::Matrix3d::Identity()};
    }
};

struct HeadingAid {
    static constexpr const char* kName = "heading_aid";
    static constexpr int kChannels = 1;
    static constexpr bool kBindsVelocity = false;
    static constexpr bool kIsHeight = false;
    static constexpr int kOwn = aiding::kHeadingBias;
    static constexpr int kOwnCount = 1;

    double sigma;  // [rad]

    template <class Port>
    static Vector<1> measured(const Port& port) {
        return Vector<1>(port.heading);
    }
    static bool possible(const Vector<1>& measured) {
        return std::abs(measured(0)) <= GnssInput::kLargestLongitude;  // a turn either way
    }
    [[nodiscard]] static aiding::Observation<1> observe(const aiding::Moment& moment,
                                                        const Vector<1>& measured) {
        return aiding::heading(moment, measured(0));
    }
    static Uncertainty doubt(const Vector<1>& residual) {
        return {.attitude = Eigen::Vector3d(0.0, 0.0, residual.squaredNorm()).asDiagonal()};
    }
};

struct HeightAid {
    static constexpr const char* kName = "height_aid";
    static constexpr int kChannels = 1;
    static constexpr bool kBindsVelocity = false;
    static constexpr bool kIsHeight = true;
    static constexpr int kOwn = aiding::kHeightBias;
    static constexpr int kOwnCount = 1;

    double sigma;  // [m]

    template <class Port>
    static Vector<1> measured(const Port& port) {
        return Vector<1>(port.height);
    }
    static bool possible(const Vector<1>& measured) {
        return measured(0) >= GnssInput::kLowest && measured(0) <= GnssInput::kHighest;
    }
    [[nodiscard]] static aiding::Observation<1> observe(const aiding::Moment& moment,
                                                        const Vector<1>& measured) {
        return aiding::height(moment, measured(0));
    }
    static Uncertainty doubt(const Vector<1>& residual) {
        return {.position = Eigen::Vector3d(0.0, 0.0, residual.squaredNorm()).asDiagonal()};
    }
};

}  // namespace truenorth
