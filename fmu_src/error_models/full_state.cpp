#include "error_models/full_state.hpp"

#include "estimation/model.hpp"

namespace truenorth {

static_assert(ErrorModel<FullState> && NoiseInside<FullState>);

Matrix<FullState::kStates> FullState::transition(const State& x, const Interval& interval) {
    const Mechanisation end = mechanised(x, interval);
    const double dt = interval.increment.dt;
    const NavigationInterval mean(dt, x.q_bn.toRotationMatrix(), end.delta_velocity_n() / dt,
                                  0.5 * (x.velocity + end.state.velocity), x.position);
    return truenorth::transition(navigation_error::jacobian(mean), dt, Discretisation::runge_kutta);
}

Matrix<FullState::kStates> FullState::process_noise(const State& /*x*/, const Interval& interval) const {
    return navigation_error::random_walk_variance(noise.angle_random_walk, noise.velocity_random_walk,
                                                  interval.increment.dt)
        .asDiagonal();
}

Vector<FullState::kMeasurements> FullState::residual(const State& x, const Fix& fix) {
    Vector<kMeasurements> residual;
    residual << earth::displacement(point_position(x, fix.lever_arm), fix.position),
        fix.velocity - point_velocity(x, fix.omega_eb_b, fix.lever_arm);
    return residual;
}

Matrix<FullState::kMeasurements, FullState::kStates> FullState::measurement_matrix(const State& x,
                                                                                   const Fix& fix) {
    const Antenna antenna{
        .C_bn = x.q_bn.toRotationMatrix(), .lever_arm = fix.lever_arm, .omega_eb_b = fix.omega_eb_b};
    return antenna.error_of_navigation();
}

Matrix<FullState::kMeasurements> FullState::measurement_noise(const State& /*x*/, const Fix& /*fix*/) const {
    return fix_covariance(noise.position_sigma, noise.velocity_sigma);
}

}  // namespace truenorth
