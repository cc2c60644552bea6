// The loosely coupled model (Li) in a filter.
#pragma once

#include "error_models/loose.hpp"
#include "filter/navigation_engine.hpp"
#include "filter/position_fix.hpp"

namespace truenorth {

template <>
struct Adapter<Loose> : PositionFix {
    static constexpr bool small_angles = true;
    static constexpr Block attitude{.first = Loose::kPhi, .count = 3};
    static constexpr Block velocity{.first = Loose::kVelocity, .count = 3};
    static constexpr Block position{.first = Loose::kPosition, .count = 3};
    static constexpr Block gyro{.first = Loose::kGyro, .count = 3};
    static constexpr Block accelerometer{.first = Loose::kAccelerometer, .count = 3};

    template <class Parameters>
    static bool is_chosen(const Parameters& p) {
        return p.error_model == decltype(p.error_model)::loose;
    }

    template <class Parameters>
    static void check(const Parameters& /*p*/) {}

    template <class Parameters>
    static void configure(Loose& model, const Parameters& p) {
        model.noise = {.angle_random_walk = p.process.angle_random_walk,
                       .velocity_random_walk = p.process.velocity_random_walk,
                       .gyro_random_walk = p.process.gyro_bias_random_walk,
                       .accelerometer_random_walk = p.process.accelerometer_bias_random_walk,
                       .position_sigma = position_sigma(p),
                       .velocity_sigma = velocity_sigma(p)};
    }

    template <class Port>
    static Loose::Fix fix_of(const Sighting& seen, const Port& /*gnss*/) {
        return {.position_difference = earth::displacement(seen.fix.position, seen.then.position),
                .velocity_difference = seen.then.velocity - seen.fix.velocity,
                .antenna = {.C_bn = seen.then.q_bn.toRotationMatrix(),
                            .lever_arm = seen.lever_arm,
                            .omega_eb_b = seen.then.omega_eb_b}};
    }
};

extern template class Engine<Loose>;
extern template class NavigationEngine<Loose>;
extern template struct AidUpdate<NavigationEngine<Loose>>;
extern template class Estimator<Loose>;
extern template class Corrector<Loose::kStates, Loose::kMeasurements>;

}  // namespace truenorth
