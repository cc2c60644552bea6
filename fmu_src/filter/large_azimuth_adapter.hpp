// The large-azimuth model (Zhou 2011) in a filter.
#pragma once

#include "error_models/large_azimuth.hpp"
#include "filter/adapter.hpp"
#include "filter/navigation_engine.hpp"

namespace truenorth {

template <>
struct Adapter<LargeAzimuth> {
    static constexpr Block attitude{.first = LargeAzimuth::kPhiEast, .count = 3};
    static constexpr Block velocity{.first = LargeAzimuth::kVelocityEast, .count = 2};
    static constexpr Block position{};
    static constexpr Block gyro{.first = LargeAzimuth::kGyroX, .count = 3};
    static constexpr Block accelerometer{.first = LargeAzimuth::kAccelerometerX, .count = 2};

    template <class Parameters>
    static bool is_chosen(const Parameters& p) {
        return p.error_model == decltype(p.error_model)::large_azimuth;
    }

    template <class Parameters>
    static void check(const Parameters& /*p*/) {}

    template <class Parameters>
    static void configure(LargeAzimuth& model, const Parameters& p) {
        using Chosen = decltype(p.velocity_form);
        using Form = LargeAzimuth::VelocityForm;
        switch (p.velocity_form) {
            case Chosen::transposed:
                model.velocity_form = Form::transposed;
                break;
            case Chosen::computed_force:
                model.velocity_form = Form::computed_force;
                break;
            case Chosen::vertical_force:
                model.velocity_form = Form::vertical_force;
                break;
            case Chosen::printed:
                model.velocity_form = Form::printed;
                break;
        }
        model.noise = {.angle_random_walk = p.process.angle_random_walk,
                       .velocity_random_walk = p.process.velocity_random_walk,
                       .velocity_sigma = p.measurement.velocity_sigma};
    }

    static constexpr int component(int measurement) { return 3 + measurement; }  // of a GnssFix

    template <class Port>
    static LargeAzimuth::Fix fix_of(const Sighting& seen, const Port& /*gnss*/) {
        return {.velocity_difference = (seen.then.velocity - seen.fix.velocity).head<2>(),
                .lever_velocity = seen.then.lever_velocity};
    }
};

extern template class Engine<LargeAzimuth>;
extern template class NavigationEngine<LargeAzimuth>;
extern template struct AidUpdate<NavigationEngine<LargeAzimuth>>;
extern template class Estimator<LargeAzimuth>;
extern template class Corrector<LargeAzimuth::kStates, LargeAzimuth::kMeasurements>;

}  // namespace truenorth
