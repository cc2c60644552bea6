// A component of four variables that does what a test tells it to do.
#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <string>

#include "components/log.hpp"
#include "components/parameter_rules.hpp"
#include "fmi/component.hpp"
#include "fmi/fmu.hpp"

namespace truenorth::test {

class StandIn {
  public:
    struct Parameters {
        double fixed = 1.0;
        double tunable = 2.0;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(fixed, tunable);
        }
    };

    Parameters parameters;
    double input = 0.0;
    double output = 0.0;  // sum of tunable * input over the steps

    explicit StandIn(Log& log) : log_(&log) {}

    void initialise(double /*start_time*/) {
        rules::greater_than("fixed", parameters.fixed, 0.0);
        retune();
        output = parameters.fixed;
    }

    void retune() const { rules::greater_than("tunable", parameters.tunable, 0.0); }

    // Inputs choose how a step ends: negative, it cannot be made; above 100, it breaks down.
    void step(double /*time*/, double /*size*/) {
        if (input < 0.0) {
            throw std::invalid_argument("cannot make this step");
        }
        output += parameters.tunable * input;
        if (input > 100.0) {
            throw std::runtime_error("broke down");
        }
        if (log_->listens()) {
            log_->event("stepped");
        }
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(parameters, input, output);
    }

  private:
    Log* log_;
};

inline constexpr unsigned fixed = 0;
inline constexpr unsigned tunable = 1;
inline constexpr unsigned input = 2;
inline constexpr unsigned output = 3;

inline fmi::Fmu stand_in() {
    using fmi::Causality;
    using fmi::Type;
    static constexpr std::array<fmi::Row<StandIn>, 4> table{{
        {{"fixed", Causality::parameter, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.parameters.fixed); }},
        {{"tunable", Causality::tunable, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.parameters.tunable); }},
        {{"input", Causality::input, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.input); }},
        {{"output", Causality::output, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.output); }},
    }};
    return {
        .identity = {.name = "StandIn", .guid = "{stand-in}"},
        .log = {.errors = "errors", .events = "events", .every = "every"},
        .make_component = [](Log& log) -> std::unique_ptr<fmi::Component> {
            return std::make_unique<fmi::TabledComponent<StandIn>>(table, 0.5, log);
        },
    };
}

}  // namespace truenorth::test
