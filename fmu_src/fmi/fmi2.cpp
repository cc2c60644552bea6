// FMI 2.0 for co-simulation and model exchange, written once for every component: each function checks its
// pointers and delegates to the Instance (c_interface.hpp).
#include <optional>
#include <string>

#include "fmi/c_interface.hpp"
#include "fmi2Functions.h"

using namespace truenorth::fmi;  // NOLINT(google-build-using-namespace): this file is its C face

namespace {

static_assert(sizeof(fmi2ValueReference) == sizeof(unsigned));

template <class Body>
fmi2Status guarded(fmi2Component component, const char* function, Body body) noexcept {
    return succeeds(component, function, body) ? fmi2OK : fmi2Error;
}

fmi2Status refused(fmi2Component component, const char* function, const char* reason) noexcept {
    return guarded(component, function, [&](Instance&) { throw Refusal(reason); });
}

template <class T, class External>
fmi2Status get(fmi2Component component, const char* function, const fmi2ValueReference* references,
               std::size_t count, External* values) noexcept {
    return guarded(component, function, [&](Instance& instance) {
        instance.get<T>(array(references, count, "vr"), Reach::scalar, array(values, count, "value"));
    });
}

template <class T, class External>
fmi2Status set(fmi2Component component, const char* function, const fmi2ValueReference* references,
               std::size_t count, const External* values) noexcept {
    return guarded(component, function, [&](Instance& instance) {
        instance.set<T>(array(references, count, "vr"), Reach::scalar, array(values, count, "value"));
    });
}

fmi2Status none(fmi2Component component, const char* function, std::size_t count) noexcept {
    return guarded(component, function, [&](Instance& instance) { instance.require_none(count); });
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

constexpr const char* no_strings = "this FMU has no variables of type String";
constexpr const char* nothing_pending = "no step is ever pending: fmi2DoStep finishes before it returns";

}  // namespace

extern "C" {

// ------------------------------------------------------------------ about the FMU

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }

const char* fmi2GetVersion() { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    return guarded(c, "fmi2SetDebugLogging", [&](Instance& instance) {
        enable_log(instance, on != fmi2False, array(categories, count, "categories"));
    });
}

// ------------------------------------------------------------------ life of an instance

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions* functions, fmi2Boolean /*visible*/,
                              fmi2Boolean logging) {
    if (functions == nullptr || functions->logger == nullptr) {
        return nullptr;
    }
    const int kind = number_of(type);
    const Request request{
        .function = "fmi2Instantiate",
        .use = {.fmi_version = 2,
                .kind = kind == fmi2ModelExchange ? Kind::model_exchange : Kind::co_simulation},
        .instance_name = name,
        .token_name = "fmuGUID",
        .token = guid,
        .resources = resources,
        .logging = logging != fmi2False};
    try {
        return instantiate(request, sink_of(*functions, name == nullptr ? "" : name), [&] {
            if (kind != fmi2ModelExchange && kind != fmi2CoSimulation) {
                throw Refusal("fmuType = " + std::to_string(kind) +
                              ": must be fmi2ModelExchange (0) or fmi2CoSimulation (1)");
            }
        });
    } catch (...) {  // no memory for the name
        return nullptr;
    }
}

void fmi2FreeInstance(fmi2Component c) { free_instance(c); }

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
    return guarded(c, "fmi2GetFMUstate", [&](Instance& instance) { save_state(instance, state); });
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return guarded(c, "fmi2SetFMUstate",
                   [&](Instance& instance) { instance.restore(static_cast<State*>(state)); });
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
    return guarded(c, "fmi2FreeFMUstate", [&](Instance& instance) { free_state(instance, state); });
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
    return guarded(c, "fmi2SerializedFMUstateSize", [&](Instance& instance) {
        present(size, "size") = instance.bytes(static_cast<State*>(state)).size();
    });
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    return guarded(c, "fmi2SerializeFMUstate",
                   [&](Instance& instance) { serialise_state(instance, state, bytes, size); });
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate* state) {
    return guarded(c, "fmi2DeSerializeFMUstate",
                   [&](Instance& instance) { deserialise_state(instance, bytes, size, state); });
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
        if (number_of(kind) != fmi2LastSuccessfulTime) {
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
        if (number_of(kind) != fmi2Terminated) {
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
    return guarded(c, "fmi2EnterEventMode", [](Instance& instance) { instance.enter_event(); });
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
    return guarded(c, "fmi2NewDiscreteStates", [&](Instance& instance) {
        auto& result = present(info, "fmi2eventInfo");
        instance.update_discrete_states();
        result = {.newDiscreteStatesNeeded = fmi2False,
                  .terminateSimulation = fmi2False,
                  .nominalsOfContinuousStatesChanged = fmi2False,
                  .valuesOfContinuousStatesChanged = fmi2False,
                  .nextEventTimeDefined = fmi2True,
                  .nextEventTime = instance.next_event()};
    });
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return guarded(c, "fmi2EnterContinuousTimeMode", [](Instance& instance) { instance.enter_continuous(); });
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*no_earlier_state*/,
                                       fmi2Boolean* event_mode, fmi2Boolean* terminate) {
    return guarded(c, "fmi2CompletedIntegratorStep", [&](Instance& instance) {
        present(terminate, "terminateSimulation") = fmi2False;
        present(event_mode, "enterEventMode") = instance.completed_integrator_step() ? fmi2True : fmi2False;
    });
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    return guarded(c, "fmi2SetTime", [&](Instance& instance) { instance.set_time(time); });
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real /*x*/[], size_t nx) {
    return none(c, "fmi2SetContinuousStates", nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real /*derivatives*/[], size_t nx) {
    return none(c, "fmi2GetDerivatives", nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real /*indicators*/[], size_t ni) {
    return none(c, "fmi2GetEventIndicators", ni);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real /*x*/[], size_t nx) {
    return none(c, "fmi2GetContinuousStates", nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real /*nominals*/[], size_t nx) {
    return none(c, "fmi2GetNominalsOfContinuousStates", nx);
}

}  // extern "C"
