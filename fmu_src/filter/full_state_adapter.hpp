// The full nonlinear model (Jing 2023) in a filter.
#pragma once

#include "contract/parameter_rules.hpp"
#include "error_models/full_state.hpp"
#include "filter/position_fix.hpp"
#include "filter/state_engine.hpp"

namespace truenorth {

template <>
struct Adapter<FullState> : PositionFix {
    static constexpr Block attitude{.first = FullState::kPhi, .count = 3};
    static constexpr Block velocity{.first = FullState::kVelocity, .count = 3};
    static constexpr Block position{.first = FullState::kPosition, .count = 3};
    static constexpr Block gyro{};
    static constexpr Block accelerometer{};

    template <class Parameters>
    static bool is_chosen(const Parameters& p) {
        return p.error_model == decltype(p.error_model)::full_state;
    }

    template <class Parameters>
    static void check(const Parameters& p) {
        if (p.discretisation != decltype(p.discretisation)::runge_kutta) {
            rules::refuse("discretisation", static_cast<int>(p.discretisation),
                          "runge_kutta (2) with error_model = full_state: its states are mechanised, there "
                          "is no error equation to integrate");
        }
    }

    template <class Parameters>
    static void configure(FullState& model, const Parameters& p) {
        model.noise = {.angle_random_walk = p.process.angle_random_walk,
                       .velocity_random_walk = p.process.velocity_random_walk,
                       .position_sigma = position_sigma(p),
                       .velocity_sigma = velocity_sigma(p)};
    }

    // The state is that of now: a late fix is moved by what the antenna has moved since.
    template <class Port>
    static FullState::Fix fix_of(const Sighting& seen, const Port& /*gnss*/) {
        const Eigen::Vector3d moved = earth::displacement(seen.then.position, seen.now.position);
        return {.position = earth::displaced(seen.fix.position, moved),
                .velocity = seen.fix.velocity + (seen.now.velocity - seen.then.velocity),
                .lever_arm = seen.lever_arm,
                .omega_eb_b = seen.now.omega_eb_b};
    }
};

extern template class Engine<FullState>;
extern template class StateEngine<FullState>;
extern template struct AidUpdate<StateEngine<FullState>>;
extern template class Estimator<FullState>;
extern template class Corrector<FullState::kStates, FullState::kMeasurements>;

}  // namespace truenorth
