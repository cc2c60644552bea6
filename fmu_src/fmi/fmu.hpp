// What distinguishes one FMU from another. The definitions are generated: <Name>/variable_table.cpp,
// guid.cpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "contract/log.hpp"
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
    // Throws what reading the resources throws, the first time.
    std::function<std::unique_ptr<Component>(Log&)> make_component;
};

enum class Kind : std::uint8_t { co_simulation, model_exchange };

// What an instance of it is for.
struct Use {
    int fmi_version;
    Kind kind;
};

// With its resources in a folder, which may not exist if the component reads none.
[[nodiscard]] Fmu this_fmu(const std::filesystem::path& resources);

// Hash of the model description and of the sources: another FMU has another.
[[nodiscard]] const char* guid();

}  // namespace truenorth::fmi
