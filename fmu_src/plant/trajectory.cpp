#include "plant/trajectory.hpp"

#include <array>

#include "inertial/attitude.hpp"

namespace truenorth::plant {

namespace {

struct Node {
    double at;      // in [0, 1]
    double weight;  // all nodes: 1
};
constexpr double kBeginWeight = 1.0 / 12.0;
constexpr double kInnerNode = 0.27639320225002103;  // (1 - 1 / sqrt(5)) / 2
constexpr std::array<Node, 3> kNodes{
    {
        {.at = kInnerNode, .weight = 5.0 / 12.0},
        {.at = 1.0 - kInnerNode, .weight = 5.0 / 12.0},
        {.at = 1.0, .weight = 1.0 / 12.0},
    },
};

Trajectory::Rates rates(const earth::Place& place, const Kinematics& kinematics) {
    const Eigen::Vector3d& velocity = kinematics.velocity;
    const Eigen::Vector3d omega_ie = place.rate();
    const Eigen::Vector3d omega_en = place.transport_rate(velocity);
    const Eigen::Vector3d gravity(0.0, 0.0, -place.gravity());
    const Eigen::Vector3d f_n =
        kinematics.acceleration + (2.0 * omega_ie + omega_en).cross(velocity) - gravity;
    return {
        .omega_ib_b = kinematics.omega_nb_b + kinematics.C_bn.transpose() * (omega_ie + omega_en),
        .f_b = kinematics.C_bn.transpose() * f_n,
        .position_rate = place.position_rate(velocity),
    };
}

}  // namespace

Trajectory::State Trajectory::begin(double time) const {
    const Kinematics kinematics = at(motion_, time);
    return {
        .time = time,
        .start = start_,
        .travelled = Eigen::Vector3d::Zero(),
        .kinematics = kinematics,
        .rates = rates(earth::Place(start_), kinematics),
    };
}

Trajectory::Increments Trajectory::advance(State& state, double to) const {
    const double duration = to - state.time;
    const Rates begin = state.rates;
    Rates mean{
        .omega_ib_b = kBeginWeight * begin.omega_ib_b,
        .f_b = kBeginWeight * begin.f_b,
        .position_rate = kBeginWeight * begin.position_rate,
    };
    for (const Node& node : kNodes) {
        const double elapsed = node.at * duration;
        state.kinematics = at(motion_, state.time + elapsed);
        // The rates hardly depend on position: a first-order prediction, 0.1 mm off at 100 Hz, is ample.
        const Eigen::Vector3d travelled = state.travelled + elapsed * begin.position_rate;
        const earth::Place place(state.start.latitude + travelled.x(), state.start.height + travelled.z());
        state.rates = rates(place, state.kinematics);
        mean.omega_ib_b += node.weight * state.rates.omega_ib_b;
        mean.f_b += node.weight * state.rates.f_b;
        mean.position_rate += node.weight * state.rates.position_rate;
    }
    state.travelled += duration * mean.position_rate;
    state.time = to;
    return {.delta_angle = duration * mean.omega_ib_b, .delta_velocity = duration * mean.f_b};
}

earth::Position Trajectory::State::position() const {
    return {
        .latitude = start.latitude + travelled.x(),
        .longitude = wrap_angle(start.longitude + travelled.y()),
        .height = start.height + travelled.z(),
    };
}

earth::Position displaced(const earth::Position& imu, const Kinematics& kinematics,
                          const Eigen::Vector3d& lever_arm) {
    return earth::displaced(imu, kinematics.C_bn * lever_arm);
}

Eigen::Vector3d velocity_at(const earth::Position& imu, const Kinematics& kinematics,
                            const Eigen::Vector3d& lever_arm) {
    const Eigen::Vector3d omega_eb_b =
        kinematics.omega_nb_b + kinematics.C_bn.transpose() * earth::transport_rate(imu, kinematics.velocity);
    return kinematics.velocity + kinematics.C_bn * omega_eb_b.cross(lever_arm);
}

}  // namespace truenorth::plant
