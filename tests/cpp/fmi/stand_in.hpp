// A component of four variables that does what a test tells it to do.
#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <string>

#include "components/log.hpp"
#include "components/parameter_rules.hpp"
#include "fmi/fmu.hpp"
#include "fmi/model.hpp"

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

    explicit StandIn(Log& log) : log_(log) {}

    void initialise(double /*start_time*/) {
        rules::greater_than("fixed", parameters.fixed, 0.0);
        retune();
        output = parameters.fixed;
    }

    void retune() const { rules::greater_than("tunable", parameters.tunable, 0.0); }

    // Inputs choose how a step ends: negative, it cannot be made; above 100, it breaks down.
    void step(double /*time*/, double /*size*/) {
        if (input < 0.0) throw std::invalid_argument("cannot make this step");
        output += parameters.tunable * input;
        if (input > 100.0) throw std::runtime_error("broke down");
        if (log_.listens()) log_.event("stepped");
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(parameters, input, output);
    }

  private:
    Log& log_;
};

enum : unsigned { fixed, tunable, input, output };

inline fmi::Fmu stand_in() {
    using fmi::Access;
    using fmi::Causality;
    static constexpr std::array<fmi::Row<StandIn>, 4> table{{
        {{"fixed", Causality::parameter, fmi::Type::real},
         Access<StandIn, double>{[](const StandIn& c) { return c.parameters.fixed; },
                                 [](StandIn& c, double v) { c.parameters.fixed = v; }}},
        {{"tunable", Causality::tunable, fmi::Type::real},
         Access<StandIn, double>{[](const StandIn& c) { return c.parameters.tunable; },
                                 [](StandIn& c, double v) { c.parameters.tunable = v; }}},
        {{"input", Causality::input, fmi::Type::real},
         Access<StandIn, double>{[](const StandIn& c) { return c.input; },
                                 [](StandIn& c, double v) { c.input = v; }}},
        {{"output", Causality::output, fmi::Type::real},
         Access<StandIn, double>{[](const StandIn& c) { return c.output; }, nullptr}},
    }};
    return {{"StandIn", "{stand-in}"}, [](Log& log) -> std::unique_ptr<fmi::Model> {
                return std::make_unique<fmi::ComponentModel<StandIn>>(table, log);
            }};
}

}  // namespace truenorth::test
