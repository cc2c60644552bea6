// Plant and filters in a loop as one writes it by hand for them, which runner.py holds the compiled loop
// against: every signal of the plant goes to every filter, and nothing is recorded.
#include <array>
#include <cstddef>

#include "fmi2FunctionTypes.h"

namespace {

constexpr std::size_t kMostSignals = 256;

}  // namespace

extern "C" {

struct Instance {
    fmi2Component component;
    fmi2DoStepTYPE* step;
};

struct Plant {
    Instance instance;
    fmi2GetRealTYPE* get_real;
    fmi2GetIntegerTYPE* get_integer;
    const fmi2ValueReference* reals;
    const fmi2ValueReference* integers;
};

struct Filter {
    Instance instance;
    fmi2SetRealTYPE* set_real;
    fmi2SetIntegerTYPE* set_integer;
    const fmi2ValueReference* reals;
    const fmi2ValueReference* integers;
};

__attribute__((visibility("default"))) int plain_loop(const Plant* plant, const Filter* filters,
                                                      std::size_t count, std::size_t reals,
                                                      std::size_t integers, double step, std::size_t steps) {
    std::array<fmi2Real, kMostSignals> real{};
    std::array<fmi2Integer, kMostSignals> integer{};
    int worst = 0;
    for (std::size_t k = 0; k < steps; ++k) {
        const double time = static_cast<double>(k) * step;
        worst |= plant->instance.step(plant->instance.component, time, step, fmi2True);
        worst |= plant->get_real(plant->instance.component, plant->reals, reals, real.data());
        worst |= plant->get_integer(plant->instance.component, plant->integers, integers, integer.data());
        for (std::size_t i = 0; i < count; ++i) {
            const Filter& filter = filters[i];
            worst |= filter.set_real(filter.instance.component, filter.reals, reals, real.data());
            worst |= filter.set_integer(filter.instance.component, filter.integers, integers, integer.data());
            worst |= filter.instance.step(filter.instance.component, time, step, fmi2True);
        }
    }
    return worst;
}
}
