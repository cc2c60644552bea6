// The loop of a co-simulation: components step, signals pass from one to the next, rows are recorded, and
// nothing else is done in a step. What is done, and in which order, says a list of operations; whoever writes
// it (sim_scenarios/compiled.py) has loaded and initialised the components, and made all memory.
#pragma once

#include <cstddef>
#include <cstdint>

namespace truenorth::runner {

// Functions of a component, with the types that they have in the C interface of FMI 2.
using Step = int(void* component, double time, double step, int no_set_before);
using Access = int(void* component, const std::uint32_t* references, std::size_t count, void* values);

inline constexpr int kDiscard = 2;  // status of a call that was refused; all that is worse is greater

enum class Kind : std::int32_t {
    step,    // of a component
    access,  // a component's variables are read or written
    renew,   // a component's variables are written, if they are others than last
    gather,  // values are picked from signals
    add,     // signals are added to values
    look,    // whether a fix came: the counter of fixes among the signals is another than before
};

enum class When : std::int32_t { always, at_row, at_fix };

struct Operation {
    Kind kind;
    When when;
    Step* step;
    Access* access;
    void* component;
    const std::uint32_t* references;  // of variables; of what is gathered, the places among the signals; of a
                                      // sum, those among the values
    std::size_t count;
    std::byte* values;
    const std::byte* signals;
    std::byte* last;   // what was written last, of as many values
    std::size_t size;  // of a signal [bytes]
    // From a row to the next, to which each turn moves; 0: there is but one [bytes].
    std::size_t values_stride;
    std::size_t signals_stride;
};

struct Loop {
    Operation* operations;
    std::size_t count;
    const double* times;        // communication points [s]
    std::size_t done;           // steps
    std::size_t steps_per_row;  // a row is due after each of so many
    std::size_t fixes;          // that came
    std::int32_t fix_count;     // as it was last
};

// Goes on until so many steps are done. Returns the index of an operation that was refused, in the step after
// those that are done; otherwise -1.
std::ptrdiff_t run(Loop& loop, std::size_t until);

}  // namespace truenorth::runner
