// The Euler platform models (Zhao 2012) in a filter.
#pragma once

#include "contract/parameter_rules.hpp"
#include "error_models/euler_platform.hpp"
#include "filter/adapter.hpp"
#include "filter/navigation_engine.hpp"

namespace truenorth {

template <>
struct Adapter<EulerPlatform> {
    static constexpr Block attitude{.first = EulerPlatform::kAlphaX, .count = 3};
    static constexpr Block velocity{.first = EulerPlatform::kVelocityEast, .count = 3};
    static constexpr Block position{};
    static constexpr Block gyro{};
    static constexpr Block accelerometer{};

    template <class Parameters>
    static bool is_chosen(const Parameters& p) {
        using Chosen = decltype(p.error_model);
        return p.error_model == Chosen::euler_platform ||
               p.error_model == Chosen::euler_platform_large_azimuth ||
               p.error_model == Chosen::euler_platform_small;
    }

    template <class Parameters>
    static void check(const Parameters& p) {
        using Form = decltype(p.velocity_form);
        if (p.velocity_form != Form::transposed && p.velocity_form != Form::vertical_force) {
            rules::refuse("velocity_form", static_cast<int>(p.velocity_form),
                          "transposed (1) or vertical_force (3) with the Euler models");
        }
        for (int i = 0; i < 3; ++i) {
            if (p.initial.velocity[i] != 0.0) {
                rules::refuse(text("initial.velocity[", i + 1, "]"), p.initial.velocity[i],
                              "0 with the Euler models: they are for a stationary base");
            }
            if (p.gnss.lever_arm[i] != 0.0) {
                rules::refuse(text("gnss.lever_arm[", i + 1, "]"), p.gnss.lever_arm[i],
                              "0 with the Euler models: they measure the IMU's velocity");
            }
        }
    }

    template <class Parameters>
    static void configure(EulerPlatform& model, const Parameters& p) {
        using Chosen = decltype(p.error_model);
        switch (p.error_model) {
            case Chosen::euler_platform_large_azimuth:
                model.form = Misalignment::large_azimuth;
                break;
            case Chosen::euler_platform_small:
                model.form = Misalignment::small;
                break;
            default:
                model.form = Misalignment::large;
                break;
        }
        using Form = EulerPlatform::VelocityForm;
        const bool vertical = p.velocity_form == decltype(p.velocity_form)::vertical_force;
        model.velocity_form = vertical ? Form::vertical_force : Form::transposed;
        model.noise = {.angle_random_walk = p.process.angle_random_walk,
                       .velocity_random_walk = p.process.velocity_random_walk,
                       .velocity_sigma = p.measurement.velocity_sigma};
    }

    static constexpr int component(int measurement) { return 3 + measurement; }  // of a GnssFix

    template <class Port>
    static EulerPlatform::Fix fix_of(const Sighting& seen, const Port& /*gnss*/) {
        return {.velocity = seen.then.velocity - seen.fix.velocity};
    }
};

extern template class Engine<EulerPlatform>;
extern template class NavigationEngine<EulerPlatform>;
extern template struct AidUpdate<NavigationEngine<EulerPlatform>>;
extern template class Estimator<EulerPlatform>;
extern template class Corrector<EulerPlatform::kStates, EulerPlatform::kMeasurements>;

}  // namespace truenorth
