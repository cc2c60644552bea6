#include "filter/antenna_history.hpp"

#include "contract/time_tolerance.hpp"
#include "inertial/attitude.hpp"

namespace truenorth {

Displacement Displacement::after(const Displacement& earlier) const {
    if (!earlier.any) {
        return *this;
    }
    if (!any) {
        return earlier;
    }
    return {.rotation = rotation * earlier.rotation,
            .velocity = earlier.velocity + velocity,
            .position = earlier.position + position,
            .offset = offset + earlier.offset.turned(rotation),
            .any = true};
}

AntennaState Displacement::of(const AntennaState& state) const {
    if (!any) {
        return state;
    }
    AntennaState moved = state;
    moved.lever_velocity = rotation * state.lever_velocity;
    moved.velocity += moved.lever_velocity - state.lever_velocity + velocity;
    moved.q_bn = Eigen::Quaterniond(rotation) * state.q_bn;
    moved.position = earth::displaced(state.position, position);
    moved.travelled = offset + state.travelled.turned(rotation);
    return moved;
}

void AntennaHistory::push(const AntennaState& state) {
    const bool crowded = size_ >= 2 && back(0).state.time - back(1).state.time < kSpacing;
    if (crowded) {
        back(1).since = back(0).since.after(back(1).since);
    } else {
        newest_ = (newest_ + 1) % kCapacity;
        size_ = size_ < kCapacity ? size_ + 1 : kCapacity;
    }
    back(0).state = state;
    back(0).since.any = false;
}

std::optional<AntennaState> AntennaHistory::at(double time) const {
    if (size_ == 0 || time > back(0).state.time + kTimeTolerance) {
        return std::nullopt;
    }
    Displacement until_now = back(0).since;
    if (time >= back(0).state.time) {
        return until_now.of(back(0).state);
    }
    for (std::size_t age = 1; age < size_; ++age) {
        const Displacement until_now_after = until_now;
        until_now = until_now.after(back(age).since);
        if (time < back(age).state.time) {
            continue;
        }
        const AntennaState before = until_now.of(back(age).state);
        const AntennaState after = until_now_after.of(back(age - 1).state);
        const double share = (time - before.time) / (after.time - before.time);
        return AntennaState{
            .time = time,
            .position = earth::displaced(before.position,
                                         share * earth::displacement(before.position, after.position)),
            .velocity = before.velocity + share * (after.velocity - before.velocity),
            .lever_velocity = before.lever_velocity + share * (after.lever_velocity - before.lever_velocity),
            .q_bn = between(before.q_bn, after.q_bn, share),
            .omega_eb_b = before.omega_eb_b + share * (after.omega_eb_b - before.omega_eb_b),
            .travelled = IntervalAverage::between(before.travelled, after.travelled, share)};
    }
    return std::nullopt;
}

void AntennaHistory::turn(const Eigen::Matrix3d& R, const IntervalAverage& travelled) {
    displace({.rotation = R, .offset = travelled - travelled.turned(R), .any = true});
}

void AntennaHistory::shift(const Eigen::Vector3d& velocity, const Eigen::Vector3d& displacement) {
    displace({.velocity = velocity, .position = displacement, .any = true});
}

void AntennaHistory::displace(const Displacement& more) { back(0).since = more.after(back(0).since); }

}  // namespace truenorth
