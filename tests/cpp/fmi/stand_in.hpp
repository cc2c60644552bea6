// A component of a few variables that does what a test tells it to do.
#pragma once

#include <array>
#include <cereal/types/array.hpp>
#include <memory>
#include <stdexcept>
#include <string>

#include "contract/log.hpp"
#include "contract/parameter_rules.hpp"
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
    // Inputs of all types, of which it makes nothing.
    std::array<double, 2> array{};
    int integer = 0;
    int enumeration = 1;
    std::array<bool, 2> booleans{};

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
        archive(array, integer, enumeration, booleans, parameters, input, output);
    }

  private:
    Log* log_;
};

inline constexpr unsigned fixed = 0;
inline constexpr unsigned tunable = 1;
inline constexpr unsigned input = 2;
inline constexpr unsigned output = 3;
inline constexpr unsigned array = 4;  // and 5
inline constexpr unsigned integer = 6;
inline constexpr unsigned enumeration = 7;
inline constexpr unsigned booleans = 8;  // and 9

inline fmi::Fmu stand_in() {
    using fmi::Causality;
    using fmi::Type;
    static constexpr std::array<fmi::Row<StandIn>, 10> table{{
        {{"fixed", Causality::parameter, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.parameters.fixed); }},
        {{"tunable", Causality::tunable, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.parameters.tunable); }},
        {{"input", Causality::input, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.input); }},
        {{"output", Causality::output, Type::real, 1},
         [](StandIn& c) { return fmi::address_as<double>(c.output); }},
        {{"array[1]", Causality::input, Type::real, 2},
         [](StandIn& c) { return fmi::address_as<double>(c.array[0]); }},
        {{"array[2]", Causality::input, Type::real, 0},
         [](StandIn& c) { return fmi::address_as<double>(c.array[1]); }},
        {{"integer", Causality::input, Type::integer, 1},
         [](StandIn& c) { return fmi::address_as<int>(c.integer); }},
        {{"enumeration", Causality::input, Type::enumeration, 1},
         [](StandIn& c) { return fmi::address_as<int>(c.enumeration); }},
        {{"booleans[1]", Causality::input, Type::boolean, 2},
         [](StandIn& c) { return fmi::address_as<bool>(c.booleans[0]); }},
        {{"booleans[2]", Causality::input, Type::boolean, 0},
         [](StandIn& c) { return fmi::address_as<bool>(c.booleans[1]); }},
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
