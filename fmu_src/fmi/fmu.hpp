// What distinguishes one FMU from another. The definitions are generated: <Name>/variable_table.cpp,
// guid.cpp.
#pragma once

#include <cstdint>
#include <memory>

#include "components/log.hpp"
#include "fmi/component.hpp"
#include "fmi/journal.hpp"

namespace truenorth::fmi {

struct Identity {
    const char* name;
    const char* guid;
};

struct Fmu {
    Identity identity;
    LogCategories log;
    std::unique_ptr<Component> (*make_component)(Log&);
};

enum class Kind : std::uint8_t { co_simulation, model_exchange };

// What an instance of it is for.
struct Use {
    int fmi_version;
    Kind kind;
};

[[nodiscard]] Fmu this_fmu();

// Hash of the model description and of the sources: another FMU has another.
[[nodiscard]] const char* guid();

}  // namespace truenorth::fmi
