// The invariant model in a filter.
#pragma once

#include "contract/parameter_rules.hpp"
#include "contract/time_tolerance.hpp"
#include "error_models/invariant.hpp"
#include "filter/position_fix.hpp"

namespace truenorth {

template <bool coloured>
struct Adapter<Invariant<coloured>> : PositionFix {
    using Model = Invariant<coloured>;
    static constexpr Block attitude{.first = Model::kRotation, .count = 3};
    static constexpr Block velocity{.first = Model::kVelocity, .count = 3};
    static constexpr Block position{.first = Model::kPosition, .count = 3};
    static constexpr Block gyro{.first = Model::kGyro, .count = 3};
    static constexpr Block accelerometer{.first = Model::kAccelerometer, .count = 3};
    static constexpr Block markov{.first = Model::kGyroMarkov, .count = Model::kStates - Model::kGyroMarkov};

    template <class Parameters>
    static bool is_chosen(const Parameters& p) {
        return p.error_model == decltype(p.error_model)::invariant && is_coloured(p) == coloured;
    }

    template <class Parameters>
    static void check(const Parameters& p) {
        if (p.discretisation != decltype(p.discretisation)::runge_kutta) {
            rules::refuse("discretisation", static_cast<int>(p.discretisation),
                          "runge_kutta (2) with error_model = invariant: there is no error equation to "
                          "integrate");
        }
        if constexpr (requires { p.velocity_form; }) {
            if (p.velocity_form != decltype(p.velocity_form)::transposed) {
                rules::refuse(
                    "velocity_form", static_cast<int>(p.velocity_form),
                    "transposed (1) with error_model = invariant: it has no velocity rows to choose");
            }
        }
        if (p.robust.states != decltype(p.robust.states)::all) {
            rules::refuse("robust.states", static_cast<int>(p.robust.states),
                          "all (1) with error_model = invariant: its errors are in body axes, heading is not "
                          "one of them");
        }
        if constexpr (requires { p.feedback; }) {
            if (!p.feedback) {
                rules::refuse("feedback", 0.0,
                              "true with error_model = invariant: it estimates the navigation state itself");
            }
        }
        if constexpr (requires { p.process.accelerometer_markov_sigma; }) {
            const auto& process = p.process;
            if (!coloured && process.gyro_markov_sigma + process.accelerometer_markov_sigma > 0.0) {
                rules::refuse("process.accelerometer_markov_sigma", process.accelerometer_markov_sigma,
                              text("0 or greater together with process.gyro_markov_sigma = ",
                                   process.gyro_markov_sigma));
            }
        }
    }

    template <class Parameters>
    static void configure(Model& model, const Parameters& p) {
        const auto& process = p.process;
        model.noise = {.angle_random_walk = process.angle_random_walk,
                       .velocity_random_walk = process.velocity_random_walk,
                       .gyro_random_walk = 0.0,
                       .accelerometer_random_walk = 0.0,
                       .gyro = {},
                       .accelerometer = {},
                       .position_sigma = position_sigma(p),
                       .velocity_sigma = velocity_sigma(p)};
        if constexpr (requires { process.gyro_bias_random_walk; }) {
            model.noise.gyro_random_walk = process.gyro_bias_random_walk;
            model.noise.accelerometer_random_walk = process.accelerometer_bias_random_walk;
        }
        if constexpr (requires { process.accelerometer_markov_sigma; }) {
            model.noise.gyro = {.sigma = process.gyro_markov_sigma,
                                .correlation_time = process.gyro_markov_time};
            model.noise.accelerometer = {.sigma = process.accelerometer_markov_sigma,
                                         .correlation_time = process.accelerometer_markov_time};
        }
    }

    template <class Parameters>
    static void set_prior(Vector<Model::kStates>& sigma, const Parameters& p) {
        if constexpr (coloured && requires { p.process.accelerometer_markov_sigma; }) {
            sigma.template segment<3>(Model::kGyroMarkov).setConstant(p.process.gyro_markov_sigma);
            sigma.template segment<3>(Model::kAccelerometerMarkov)
                .setConstant(p.process.accelerometer_markov_sigma);
        }
    }

    template <class Port>
    static typename Model::Fix fix_of(const Sighting& seen, const Port& /*gnss*/) {
        const AntennaState& then = seen.then;
        const Eigen::Quaterniond to_body = then.q_bn.conjugate();
        const Eigen::Vector3d omega_ib_b = then.omega_eb_b + to_body * earth::rate(then.position.latitude);
        auto fix = Model::Fix::of(seen.fix.position, seen.fix.velocity, seen.lever_arm, omega_ib_b);
        fix.position_sigma = seen.fix.sigma.template head<3>();
        fix.velocity_sigma = seen.fix.sigma.template tail<3>();
        const double late = seen.since.duration();
        if (late > kTimeTolerance) {
            const Eigen::Vector3d gained = to_body * (late * seen.since.force());
            fix = fix.after(
                {.attitude = to_body * seen.now.q_bn, .velocity = gained, .position = 0.5 * late * gained},
                late);
        }
        return fix;
    }

  private:
    template <class Parameters>
    static bool is_coloured(const Parameters& p) {
        if constexpr (requires { p.process.accelerometer_markov_sigma; }) {
            return p.process.gyro_markov_sigma > 0.0 && p.process.accelerometer_markov_sigma > 0.0;
        } else {
            return false;
        }
    }
};

extern template class Estimator<Invariant<false>>;
extern template class Estimator<Invariant<true>>;
extern template class Corrector<Invariant<false>::kStates, Invariant<false>::kMeasurements>;  // that of Loose
extern template class Corrector<Invariant<true>::kStates, Invariant<true>::kMeasurements>;

}  // namespace truenorth
