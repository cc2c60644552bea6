// FMI 2.0 for co-simulation, written once for every component: each function checks its pointers, delegates
// to the Instance, and turns what that throws into fmi2Error and a line of the log. No exception leaves this
// file.
#include <algorithm>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fmi/fmu.hpp"
#include "fmi/instance.hpp"
#include "fmi/refusal.hpp"
#include "fmi2Functions.h"

using truenorth::fmi::Instance;
using truenorth::fmi::Journal;
using truenorth::fmi::Refusal;
using truenorth::fmi::State;

namespace {

static_assert(sizeof(fmi2ValueReference) == sizeof(unsigned));

// Runs `body` on the instance; a refusal becomes a line "<function>: <why>" and fmi2Error.
template <class Body>
fmi2Status guarded(fmi2Component component, const char* function, Body body) noexcept {
    if (component == nullptr) {
        return fmi2Error;
    }
    auto& instance = *static_cast<Instance*>(component);
    try {
        try {
            body(instance);
            return fmi2OK;
        } catch (const std::exception& reason) {
            instance.journal().error(std::string(function) + ": " + reason.what());
        }
    } catch (...) {  // no memory for the line, or a logger that throws: the status must do
        return fmi2Error;
    }
    return fmi2Error;
}

fmi2Status refused(fmi2Component component, const char* function, const char* reason) noexcept {
    return guarded(component, function, [&](Instance&) { throw Refusal(reason); });
}

template <class T>
T& present(T* pointer, const char* name) {
    if (pointer == nullptr) {
        throw Refusal(std::string(name) + " is NULL");
    }
    return *pointer;
}

template <class T>
std::span<T> array(T* pointer, std::size_t size, const char* name) {
    if (pointer == nullptr && size > 0) {
        throw Refusal(std::string(name) + " is NULL");
    }
    return {pointer, size};
}

template <class T, class External>
fmi2Status get(fmi2Component component, const char* function, const fmi2ValueReference* references,
               std::size_t count, External* values) noexcept {
    return guarded(component, function, [&](Instance& instance) {
        instance.get<T>(array(references, count, "vr"), array(values, count, "value"));
    });
}

template <class T, class External>
fmi2Status set(fmi2Component component, const char* function, const fmi2ValueReference* references,
               std::size_t count, const External* values) noexcept {
    return guarded(component, function, [&](Instance& instance) {
        instance.set<T>(array(references, count, "vr"), array(values, count, "value"));
    });
}

// The log of one instance as the environment wants it.
Journal::Sink sink_of(const fmi2CallbackFunctions& environment, std::string instance_name) {
    return [log = environment.logger, context = environment.componentEnvironment,
            name = std::move(instance_name)](Journal::Severity severity, const char* category,
                                             const char* text) {
        log(context, name.c_str(), severity == Journal::Severity::error ? fmi2Error : fmi2OK, category, "%s",
            text);
    };
}

void require_instantiable(const char* instance_name, fmi2Type type, const char* guid) {
    if (instance_name == nullptr || *instance_name == '\0') {
        throw Refusal("instanceName is NULL or empty");
    }
    if (type != fmi2CoSimulation) {
        throw Refusal("fmuType: this FMU is for co-simulation only");
    }
    const std::string_view expected = truenorth::fmi::this_fmu().identity.guid;
    if (guid == nullptr || expected != guid) {
        throw Refusal("fmuGUID = " + std::string(guid == nullptr ? "NULL" : guid) + ": this FMU is " +
                      std::string(expected) +
                      "; modelDescription.xml and the binary belong to different builds");
    }
}

State* state_of(fmi2FMUstate state) { return static_cast<State*>(state); }

constexpr const char* no_strings = "this FMU has no variables of type String";
constexpr const char* co_simulation_only = "this FMU is for co-simulation only";
constexpr const char* nothing_pending = "no step is ever pending: fmi2DoStep finishes before it returns";

}  // namespace

extern "C" {

// ------------------------------------------------------------------ about the FMU

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }

const char* fmi2GetVersion() { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    return guarded(c, "fmi2SetDebugLogging", [&](Instance& instance) {
        std::vector<std::string_view> names;
        for (const fmi2String name : array(categories, count, "categories")) {
            names.emplace_back(&present(name, "a category"));
        }
        instance.journal().enable(on != fmi2False, names);
    });
}

// ------------------------------------------------------------------ life of an instance

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String /*resources*/,
                              const fmi2CallbackFunctions* functions, fmi2Boolean /*visible*/,
                              fmi2Boolean logging) {
    if (functions == nullptr || functions->logger == nullptr) {
        return nullptr;
    }
    try {
        const auto sink = sink_of(*functions, name == nullptr ? "" : name);
        try {
            require_instantiable(name, type, guid);
            return std::make_unique<Instance>(truenorth::fmi::this_fmu(), sink, logging != fmi2False)
                .release();
        } catch (const std::exception& reason) {
            Journal(sink, truenorth::fmi::this_fmu().log, false)
                .error(std::string("fmi2Instantiate: ") + reason.what());
        }
    } catch (...) {  // no memory for the line, or a logger that throws
        return nullptr;
    }
    return nullptr;
}

void fmi2FreeInstance(fmi2Component c) { const std::unique_ptr<Instance> last(static_cast<Instance*>(c)); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean /*tolerance_defined*/, fmi2Real /*tolerance*/,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    return guarded(c, "fmi2SetupExperiment", [&](Instance& instance) {
        instance.set_up_experiment(start, stop_defined != fmi2False ? std::optional(stop) : std::nullopt);
    });
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return guarded(c, "fmi2EnterInitializationMode",
                   [](Instance& instance) { instance.enter_initialisation(); });
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return guarded(c, "fmi2ExitInitializationMode",
                   [](Instance& instance) { instance.exit_initialisation(); });
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return guarded(c, "fmi2Terminate", [](Instance& instance) { instance.terminate(); });
}

fmi2Status fmi2Reset(fmi2Component c) {
    return guarded(c, "fmi2Reset", [](Instance& instance) { instance.reset(); });
}

// ------------------------------------------------------------------ variables

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
    return get<double>(c, "fmi2GetReal", vr, nvr, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[]) {
    return get<int>(c, "fmi2GetInteger", vr, nvr, value);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[]) {
    return get<bool>(c, "fmi2GetBoolean", vr, nvr, value);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t nvr,
                         fmi2String /*value*/[]) {
    if (nvr == 0) {
        return guarded(c, "fmi2GetString", [](Instance&) {});
    }
    return refused(c, "fmi2GetString", no_strings);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
    return set<double>(c, "fmi2SetReal", vr, nvr, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[]) {
    return set<int>(c, "fmi2SetInteger", vr, nvr, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[]) {
    return set<bool>(c, "fmi2SetBoolean", vr, nvr, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t nvr,
                         const fmi2String /*value*/[]) {
    if (nvr == 0) {
        return guarded(c, "fmi2SetString", [](Instance&) {});
    }
    return refused(c, "fmi2SetString", no_strings);
}

// ------------------------------------------------------------------ stored states

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return guarded(c, "fmi2GetFMUstate", [&](Instance& instance) {
        auto& handle = present(state, "FMUstate");
        handle = instance.save(state_of(handle));
    });
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return guarded(c, "fmi2SetFMUstate", [&](Instance& instance) { instance.restore(state_of(state)); });
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return guarded(c, "fmi2FreeFMUstate", [&](Instance& instance) {
        if (state == nullptr) {
            return;
        }
        instance.release(state_of(*state));
        *state = nullptr;
    });
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    return guarded(c, "fmi2SerializedFMUstateSize", [&](Instance& instance) {
        present(size, "size") = instance.bytes(state_of(state)).size();
    });
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return guarded(c, "fmi2SerializeFMUstate", [&](Instance& instance) {
        const auto stored = instance.bytes(state_of(state));
        const auto buffer = array(bytes, size, "serializedState");
        if (buffer.size() < stored.size()) {
            throw Refusal("the buffer has " + std::to_string(size) + " bytes, the state needs " +
                          std::to_string(stored.size()));
        }
        std::ranges::copy(stored, buffer.begin());
    });
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate* state) {
    return guarded(c, "fmi2DeSerializeFMUstate", [&](Instance& instance) {
        auto& handle = present(state, "FMUstate");
        handle = instance.import_state(array(bytes, size, "serializedState"));
    });
}

// ------------------------------------------------------------------ co-simulation

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean /*no_earlier_state*/) {
    return guarded(c, "fmi2DoStep", [&](Instance& instance) { instance.step(time, size); });
}

fmi2Status fmi2CancelStep(fmi2Component c) { return refused(c, "fmi2CancelStep", nothing_pending); }

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t /*nvr*/,
                                       const fmi2Integer /*order*/[], const fmi2Real /*value*/[]) {
    return refused(c, "fmi2SetRealInputDerivatives", "inputs are sampled signals and have no derivatives");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t /*nvr*/,
                                        const fmi2Integer /*order*/[], fmi2Real /*value*/[]) {
    return refused(c, "fmi2GetRealOutputDerivatives", "outputs are sampled signals and have no derivatives");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2Status* /*value*/) {
    return refused(c, "fmi2GetStatus", nothing_pending);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
    return guarded(c, "fmi2GetRealStatus", [&](Instance& instance) {
        if (kind != fmi2LastSuccessfulTime) {
            throw Refusal("the only Real status is fmi2LastSuccessfulTime");
        }
        present(value, "value") = instance.time();
    });
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2Integer* /*value*/) {
    return refused(c, "fmi2GetIntegerStatus", "there is no Integer status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
    return guarded(c, "fmi2GetBooleanStatus", [&](Instance&) {
        if (kind != fmi2Terminated) {
            throw Refusal("the only Boolean status is fmi2Terminated");
        }
        present(value, "value") = fmi2False;  // this FMU never asks to end the simulation
    });
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2String* /*value*/) {
    return refused(c, "fmi2GetStringStatus", nothing_pending);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference /*unknown*/[],
                                        size_t /*n_unknown*/, const fmi2ValueReference /*known*/[],
                                        size_t /*n_known*/, const fmi2Real /*seed*/[], fmi2Real /*value*/[]) {
    return refused(c, "fmi2GetDirectionalDerivative", "this FMU provides no directional derivatives");
}

// ------------------------------------------------------------------ model exchange

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return refused(c, "fmi2EnterEventMode", co_simulation_only);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* /*info*/) {
    return refused(c, "fmi2NewDiscreteStates", co_simulation_only);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return refused(c, "fmi2EnterContinuousTimeMode", co_simulation_only);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*no_earlier_state*/,
                                       fmi2Boolean* /*event_mode*/, fmi2Boolean* /*terminate*/) {
    return refused(c, "fmi2CompletedIntegratorStep", co_simulation_only);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real /*time*/) {
    return refused(c, "fmi2SetTime", co_simulation_only);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real /*x*/[], size_t /*nx*/) {
    return refused(c, "fmi2SetContinuousStates", co_simulation_only);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real /*derivatives*/[], size_t /*nx*/) {
    return refused(c, "fmi2GetDerivatives", co_simulation_only);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real /*indicators*/[], size_t /*ni*/) {
    return refused(c, "fmi2GetEventIndicators", co_simulation_only);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real /*x*/[], size_t /*nx*/) {
    return refused(c, "fmi2GetContinuousStates", co_simulation_only);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real /*nominals*/[], size_t /*nx*/) {
    return refused(c, "fmi2GetNominalsOfContinuousStates", co_simulation_only);
}

}  // extern "C"
