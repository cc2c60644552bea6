#include "components/antenna_history.hpp"

#include "components/time_tolerance.hpp"

namespace truenorth {

void AntennaHistory::push(const AntennaState& state) {
    const bool crowded = size_ >= 2 && back(0).time - back(1).time < kSpacing;
    if (!crowded) {
        newest_ = (newest_ + 1) % kCapacity;
        size_ = size_ < kCapacity ? size_ + 1 : kCapacity;
    }
    entries_[newest_] = state;
}

std::optional<AntennaState> AntennaHistory::at(double time) const {
    if (size_ == 0 || time > back(0).time + kTimeTolerance) {
        return std::nullopt;
    }
    if (time >= back(0).time) {
        return back(0);
    }
    for (std::size_t age = 1; age < size_; ++age) {
        const AntennaState& before = back(age);
        if (time < before.time) {
            continue;
        }
        const AntennaState& after = back(age - 1);
        const double share = (time - before.time) / (after.time - before.time);
        return AntennaState{
            .time = time,
            .position = earth::displaced(before.position,
                                         share * earth::displacement(before.position, after.position)),
            .velocity = before.velocity + share * (after.velocity - before.velocity),
            .lever_velocity = before.lever_velocity + share * (after.lever_velocity - before.lever_velocity),
            .q_bn = before.q_bn.slerp(share, after.q_bn),
            .omega_eb_b = before.omega_eb_b + share * (after.omega_eb_b - before.omega_eb_b),
            .travelled = IntervalAverage::between(before.travelled, after.travelled, share)};
    }
    return std::nullopt;
}

void AntennaHistory::turn(const Eigen::Matrix3d& R, const IntervalAverage& travelled) {
    const Eigen::Quaterniond q(R);
    for (std::size_t age = 0; age < size_; ++age) {
        AntennaState& entry = entries_[(newest_ + kCapacity - age) % kCapacity];
        const Eigen::Vector3d lever_velocity = R * entry.lever_velocity;
        entry.velocity += lever_velocity - entry.lever_velocity;
        entry.lever_velocity = lever_velocity;
        entry.q_bn = q * entry.q_bn;
        entry.travelled = travelled - (travelled - entry.travelled).turned(R);
    }
}

void AntennaHistory::shift(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement) {
    for (std::size_t age = 0; age < size_; ++age) {
        AntennaState& entry = entries_[(newest_ + kCapacity - age) % kCapacity];
        entry.velocity += velocity;
        entry.position = earth::displaced(entry.position, displacement);
    }
}

}  // namespace truenorth
