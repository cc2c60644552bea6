// Where the mechanisation had the GNSS antenna over the last seconds, so that a fix is compared with the
// moment at which it was valid.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>

#include "inertial/interval_average.hpp"

namespace truenorth {

struct AntennaState {
    double time = 0.0;  // [s]
    earth::Position position;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        // ENU [m/s]
    Eigen::Vector3d lever_velocity = Eigen::Vector3d::Zero();  // its part that the lever arm causes
    Eigen::Quaterniond q_bn = Eigen::Quaterniond::Identity();  // body to computed ENU
    Eigen::Vector3d omega_eb_b = Eigen::Vector3d::Zero();      // body rate relative to the Earth [rad/s]
    IntervalAverage travelled{};  // running sum since the start, from which averages since then follow

    template <class Archive>
    void serialize(Archive& archive) {
        archive(time, position, velocity, lever_velocity, q_bn, omega_eb_b, travelled);
    }
};

// What corrections have done to the mechanisation since it was in some state: its attitude turned by R
// (computed ENU), velocity and position moved, and the running sum of what it travelled, t, become offset + R
// t.
struct Displacement {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // [m/s]
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // [m]
    IntervalAverage offset{};
    bool any = false;

    // This one after an earlier one.
    [[nodiscard]] Displacement after(const Displacement& earlier) const;

    [[nodiscard]] AntennaState of(const AntennaState& state) const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(rotation, velocity, position, offset, any);
    }
};

class AntennaHistory {
  public:
    static constexpr std::size_t kCapacity = 256;
    // Entries closer than this replace each other, so that the history is 2.5 s long at least [s].
    static constexpr double kSpacing = 0.0099;

    void push(const AntennaState& state);

    // The antenna at `time`, interpolated; none when that is before the oldest entry or after the newest.
    [[nodiscard]] std::optional<AntennaState> at(double time) const;

    // When it begins [s].
    [[nodiscard]] double oldest() const {
        return size_ > 0 ? back(size_ - 1).state.time : std::numeric_limits<double>::lowest();
    }

    // The mechanisation has been corrected: its attitude turned by R (computed ENU), velocity [m/s] and
    // position [m] moved. The past is turned and moved by as much. That the corrections of velocity and
    // position would have been others then is neglected, the more the longer ago: of a turn by phi, phi x f L
    // of the velocity L before now (0.035 m/s for 2 degrees, 5 m/s2 and 0.2 s). It concerns fixes that were
    // valid before the one before them was used, which takes a latency longer than their interval.
    // `travelled` is the running sum now. Noted with the newest entry, applied to those that are read.
    void turn(const Eigen::Matrix3d& R, const IntervalAverage& travelled);
    void shift(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(size_, newest_, entries_);
        if (size_ > kCapacity || newest_ >= kCapacity) {
            throw std::out_of_range("the stored state is damaged: there is no such entry of its history");
        }
    }

  private:
    struct Entry {
        AntennaState state;    // as it was
        Displacement since{};  // after it, and before the next

        template <class Archive>
        void serialize(Archive& archive) {
            archive(state, since);
        }
    };

    // Entry `age` steps before the newest.
    [[nodiscard]] const Entry& back(std::size_t age) const {
        return entries_[(newest_ + kCapacity - age) % kCapacity];
    }
    [[nodiscard]] Entry& back(std::size_t age) { return entries_[(newest_ + kCapacity - age) % kCapacity]; }

    void displace(const Displacement& more);

    std::array<Entry, kCapacity> entries_{};
    std::size_t newest_ = 0;
    std::size_t size_ = 0;
};

}  // namespace truenorth
