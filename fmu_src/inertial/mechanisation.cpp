#include "inertial/mechanisation.hpp"

namespace truenorth {

namespace {

// Weight of the cross products of previous and current increments: 1/12 for equal intervals; T^2 / (6 T0 (T0
// + T)) for intervals T0 and T, from integrating rates that are linear in time over both.
double two_sample_weight(double previous_dt, double dt) {
    return previous_dt > 0.0 ? dt * dt / (6.0 * previous_dt * (previous_dt + dt)) : 0.0;
}

}  // namespace

BodyMotion body_motion(const ImuIncrement& previous, const ImuIncrement& increment) {
    const double weight = two_sample_weight(previous.dt, increment.dt);
    const Eigen::Vector3d& angle = increment.delta_angle;
    const Eigen::Vector3d& velocity_increment = increment.delta_velocity;

    const Eigen::Vector3d coning = weight * previous.delta_angle.cross(angle);
    const Eigen::Vector3d sculling =
        weight * (previous.delta_angle.cross(velocity_increment) + previous.delta_velocity.cross(angle));
    // To second order in the angle: the first alone leaves 1e-3 m/s after ten minutes of sway.
    const Eigen::Vector3d rotation_compensation =
        0.5 * angle.cross(velocity_increment) + angle.cross(angle.cross(velocity_increment)) / 6.0;
    return {.rotation = angle + coning,
            .delta_velocity = velocity_increment + rotation_compensation + sculling};
}

void Mechanisation::advance(const ImuIncrement& increment) {
    const double dt = increment.dt;
    const BodyMotion motion = body_motion(previous_, increment);

    // Slow quantities at the middle of the interval.
    const Eigen::Vector3d velocity_mid = state.velocity + 0.5 * dt * acceleration_;
    const earth::Position position_mid = earth::displaced(state.position, 0.5 * dt * state.velocity);
    const earth::Place place(position_mid);
    const Eigen::Vector3d omega_ie = place.rate();
    const Eigen::Vector3d omega_en = place.transport_rate(velocity_mid);
    const Eigen::Vector3d navigation_rotation = (omega_ie + omega_en) * dt;

    // Velocity: specific force resolved in n at mid-interval, gravity, Coriolis.
    const Eigen::Vector3d delta_velocity_start = state.q_bn * motion.delta_velocity;
    delta_velocity_n_ = delta_velocity_start - 0.5 * navigation_rotation.cross(delta_velocity_start);
    const Eigen::Vector3d gravity(0.0, 0.0, -place.gravity());
    const Eigen::Vector3d velocity_change =
        delta_velocity_n_ + dt * (gravity - (2.0 * omega_ie + omega_en).cross(velocity_mid));
    const Eigen::Vector3d velocity_mean = state.velocity + 0.5 * velocity_change;
    acceleration_ = velocity_change / dt;
    state.velocity += velocity_change;

    // Position: radii and latitude at mid-interval make the step second-order.
    const Eigen::Vector3d position_rate = place.position_rate(velocity_mean);
    state.position.latitude += position_rate.x() * dt;
    state.position.longitude = wrap_angle(state.position.longitude + position_rate.y() * dt);
    state.position.height += position_rate.z() * dt;

    // Attitude.
    state.q_bn = quaternion(-navigation_rotation) * state.q_bn * quaternion(motion.rotation);
    state.q_bn.normalize();

    Eigen::Vector3d omega_ib_b = increment.delta_angle / dt;
    if (previous_.dt > 0.0) {
        omega_ib_b += (dt / (dt + previous_.dt)) * (omega_ib_b - previous_.delta_angle / previous_.dt);
    }
    omega_eb_b_ = omega_ib_b - state.q_bn.conjugate() * omega_ie;

    previous_ = increment;
}

earth::Position point_position(const NavigationState& state, const Eigen::Vector3d& lever_arm) {
    return lever_arm.isZero(0.0) ? state.position : earth::displaced(state.position, state.q_bn * lever_arm);
}

Eigen::Vector3d point_velocity(const NavigationState& state, const Eigen::Vector3d& omega_eb_b,
                               const Eigen::Vector3d& lever_arm) {
    return state.velocity + state.q_bn * omega_eb_b.cross(lever_arm);
}

}  // namespace truenorth
