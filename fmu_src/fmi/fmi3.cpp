// FMI 3.0 for co-simulation and model exchange, written once for every component: each function checks its
// pointers and delegates to the Instance (c_interface.hpp).
//
// A variable's value reference is that of its first scalar; the time follows after the last scalar. Integers
// are Int32, enumerations Int64; there is nothing of any other integer type, String, Binary or Clock.
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "fmi/c_interface.hpp"
#include "fmi3Functions.h"

using namespace truenorth::fmi;  // NOLINT(google-build-using-namespace): this file is its C face

namespace {

static_assert(std::is_same_v<fmi3ValueReference, unsigned>);

template <class Body>
fmi3Status guarded(fmi3Instance handle, const char* function, Body body) noexcept {
    return succeeds(handle, function, body) ? fmi3OK : fmi3Error;
}

fmi3Status refused(fmi3Instance handle, const char* function, const char* reason) noexcept {
    return guarded(handle, function, [&](Instance&) { throw Refusal(reason); });
}

// Nothing may be asked for, and nothing is given.
fmi3Status none_of(fmi3Instance handle, const char* function, std::size_t count) noexcept {
    return guarded(handle, function, [&](Instance&) {
        if (count > 0) {
            throw Refusal("this FMU has no variables of this type");
        }
    });
}

fmi3Status no_states(fmi3Instance handle, const char* function, std::size_t count) noexcept {
    return guarded(handle, function, [&](Instance& instance) { instance.require_none(count); });
}

template <class T, class External>
fmi3Status get(fmi3Instance handle, const char* function, const fmi3ValueReference* references,
               std::size_t count, External* values, std::size_t size) noexcept {
    return guarded(handle, function, [&](Instance& instance) {
        instance.get<T>(array(references, count, "valueReferences"), Reach::variable,
                        array(values, size, "values"));
    });
}

template <class T, class External>
fmi3Status set(fmi3Instance handle, const char* function, const fmi3ValueReference* references,
               std::size_t count, const External* values, std::size_t size) noexcept {
    return guarded(handle, function, [&](Instance& instance) {
        const auto given = array(values, size, "values");
        if constexpr (std::is_integral_v<External> && sizeof(External) > sizeof(T)) {
            for (const External value : given) {
                if (value < std::numeric_limits<T>::min() || value > std::numeric_limits<T>::max()) {
                    throw Refusal("value " + std::to_string(value) + ": must fit into 32 bits");
                }
            }
        }
        instance.set<T>(array(references, count, "valueReferences"), Reach::variable, given);
    });
}

template <class T>
void put(T* pointer, T value) {
    if (pointer != nullptr) {
        *pointer = value;
    }
}

// The log of one instance as the environment wants it.
Journal::Sink sink_of(fmi3LogMessageCallback log, fmi3InstanceEnvironment environment) {
    return [log, environment](Journal::Severity severity, const char* category, const char* text) {
        if (log != nullptr) {
            log(environment, severity == Journal::Severity::error ? fmi3Error : fmi3OK, category, text);
        }
    };
}

template <class Check>
fmi3Instance instantiated(const Request& request, fmi3LogMessageCallback log,
                          fmi3InstanceEnvironment environment, Check check) noexcept {
    try {
        return instantiate(request, sink_of(log, environment), check);
    } catch (...) {  // no memory for the sink
        return nullptr;
    }
}

constexpr const char* no_derivatives = "this FMU provides no partial derivatives";
constexpr const char* no_clocks = "this FMU has no clocks";
constexpr const char* no_structure = "this FMU has no structural parameters";
constexpr const char* no_dependencies = "the dependencies stand in modelDescription.xml";

}  // namespace

extern "C" {

// ------------------------------------------------------------------ about the FMU

const char* fmi3GetVersion() { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[]) {
    return guarded(c, "fmi3SetDebugLogging", [&](Instance& instance) {
        enable_log(instance, on, array(categories, count, "categories"));
    });
}

// ------------------------------------------------------------------ life of an instance

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean /*visible*/, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    const Request request{.function = "fmi3InstantiateModelExchange",
                          .use = {.fmi_version = 3, .kind = Kind::model_exchange},
                          .instance_name = name,
                          .token_name = "instantiationToken",
                          .token = token,
                          .resources = resources,
                          .logging = logging};
    return instantiated(request, log, environment, [] {});
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean /*visible*/, fmi3Boolean logging, fmi3Boolean event_mode,
                                         fmi3Boolean /*early_return*/,
                                         const fmi3ValueReference /*required*/[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback /*update*/) {
    const Request request{.function = "fmi3InstantiateCoSimulation",
                          .use = {.fmi_version = 3, .kind = Kind::co_simulation},
                          .instance_name = name,
                          .token_name = "instantiationToken",
                          .token = token,
                          .resources = resources,
                          .logging = logging};
    return instantiated(request, log, environment, [&] {
        if (event_mode) {
            throw Refusal("eventModeUsed = true: in co-simulation this FMU has no event mode");
        }
        if (n_required > 0) {
            throw Refusal("requiredIntermediateVariables: this FMU has no intermediate values");
        }
    });
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean /*visible*/, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log, fmi3ClockUpdateCallback /*update*/,
                                               fmi3LockPreemptionCallback /*lock*/,
                                               fmi3UnlockPreemptionCallback /*unlock*/) {
    const Request request{.function = "fmi3InstantiateScheduledExecution",
                          .use = {.fmi_version = 3, .kind = Kind::co_simulation},
                          .instance_name = name,
                          .token_name = "instantiationToken",
                          .token = token,
                          .resources = resources,
                          .logging = logging};
    return instantiated(request, log, environment, [] {
        throw Refusal("this FMU is for co-simulation and model exchange, not for scheduled execution");
    });
}

void fmi3FreeInstance(fmi3Instance c) { free_instance(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean /*tolerance_defined*/,
                                       fmi3Float64 /*tolerance*/, fmi3Float64 start, fmi3Boolean stop_defined,
                                       fmi3Float64 stop) {
    return guarded(c, "fmi3EnterInitializationMode", [&](Instance& instance) {
        instance.set_up_experiment(start, stop_defined ? std::optional(stop) : std::nullopt);
        instance.enter_initialisation();
    });
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    return guarded(c, "fmi3ExitInitializationMode",
                   [](Instance& instance) { instance.exit_initialisation(); });
}

fmi3Status fmi3Terminate(fmi3Instance c) {
    return guarded(c, "fmi3Terminate", [](Instance& instance) { instance.terminate(); });
}

fmi3Status fmi3Reset(fmi3Instance c) {
    return guarded(c, "fmi3Reset", [](Instance& instance) { instance.reset(); });
}

// ------------------------------------------------------------------ variables

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Float64 values[],
                          size_t n) {
    return get<double>(c, "fmi3GetFloat64", vr, nvr, values, n);
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr,
                          const fmi3Float64 values[], size_t n) {
    return set<double>(c, "fmi3SetFloat64", vr, nvr, values, n);
}

fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Int32 values[],
                        size_t n) {
    return get<int>(c, "fmi3GetInt32", vr, nvr, values, n);
}

fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Int32 values[],
                        size_t n) {
    return set<int>(c, "fmi3SetInt32", vr, nvr, values, n);
}

fmi3Status fmi3GetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Int64 values[],
                        size_t n) {
    return get<int>(c, "fmi3GetInt64", vr, nvr, values, n);
}

fmi3Status fmi3SetInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, const fmi3Int64 values[],
                        size_t n) {
    return set<int>(c, "fmi3SetInt64", vr, nvr, values, n);
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr, fmi3Boolean values[],
                          size_t n) {
    return get<bool>(c, "fmi3GetBoolean", vr, nvr, values, n);
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t nvr,
                          const fmi3Boolean values[], size_t n) {
    return set<bool>(c, "fmi3SetBoolean", vr, nvr, values, n);
}

fmi3Status fmi3GetFloat32(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                          fmi3Float32 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3GetFloat32", nvr);
}

fmi3Status fmi3SetFloat32(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                          const fmi3Float32 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetFloat32", nvr);
}

fmi3Status fmi3GetInt8(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr, fmi3Int8 /*values*/[],
                       size_t /*n*/) {
    return none_of(c, "fmi3GetInt8", nvr);
}

fmi3Status fmi3SetInt8(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                       const fmi3Int8 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetInt8", nvr);
}

fmi3Status fmi3GetUInt8(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr, fmi3UInt8 /*values*/[],
                        size_t /*n*/) {
    return none_of(c, "fmi3GetUInt8", nvr);
}

fmi3Status fmi3SetUInt8(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                        const fmi3UInt8 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetUInt8", nvr);
}

fmi3Status fmi3GetInt16(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr, fmi3Int16 /*values*/[],
                        size_t /*n*/) {
    return none_of(c, "fmi3GetInt16", nvr);
}

fmi3Status fmi3SetInt16(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                        const fmi3Int16 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetInt16", nvr);
}

fmi3Status fmi3GetUInt16(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         fmi3UInt16 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3GetUInt16", nvr);
}

fmi3Status fmi3SetUInt16(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         const fmi3UInt16 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetUInt16", nvr);
}

fmi3Status fmi3GetUInt32(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         fmi3UInt32 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3GetUInt32", nvr);
}

fmi3Status fmi3SetUInt32(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         const fmi3UInt32 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetUInt32", nvr);
}

fmi3Status fmi3GetUInt64(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         fmi3UInt64 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3GetUInt64", nvr);
}

fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         const fmi3UInt64 /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetUInt64", nvr);
}

fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         fmi3String /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3GetString", nvr);
}

fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         const fmi3String /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetString", nvr);
}

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr, size_t /*sizes*/[],
                         fmi3Binary /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3GetBinary", nvr);
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                        fmi3Clock /*values*/[]) {
    return none_of(c, "fmi3GetClock", nvr);
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                         const size_t /*sizes*/[], const fmi3Binary /*values*/[], size_t /*n*/) {
    return none_of(c, "fmi3SetBinary", nvr);
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t nvr,
                        const fmi3Clock /*values*/[]) {
    return none_of(c, "fmi3SetClock", nvr);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference /*vr*/, size_t* /*count*/) {
    return refused(c, "fmi3GetNumberOfVariableDependencies", no_dependencies);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference /*dependent*/,
                                       size_t /*elements*/[], fmi3ValueReference /*independents*/[],
                                       size_t /*independent_elements*/[], fmi3DependencyKind /*kinds*/[],
                                       size_t /*count*/) {
    return refused(c, "fmi3GetVariableDependencies", no_dependencies);
}

// ------------------------------------------------------------------ stored states

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
    return guarded(c, "fmi3GetFMUState", [&](Instance& instance) { save_state(instance, state); });
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    return guarded(c, "fmi3SetFMUState",
                   [&](Instance& instance) { instance.restore(static_cast<State*>(state)); });
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state) {
    return guarded(c, "fmi3FreeFMUState", [&](Instance& instance) { free_state(instance, state); });
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t* size) {
    return guarded(c, "fmi3SerializedFMUStateSize", [&](Instance& instance) {
        present(size, "size") = instance.bytes(static_cast<State*>(state)).size();
    });
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    return guarded(c, "fmi3SerializeFMUState",
                   [&](Instance& instance) { serialise_state(instance, state, bytes, size); });
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
    return guarded(c, "fmi3DeserializeFMUState",
                   [&](Instance& instance) { deserialise_state(instance, bytes, size, state); });
}

// ------------------------------------------------------------------ co-simulation

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 size, fmi3Boolean /*no_earlier_state*/,
                      fmi3Boolean* event, fmi3Boolean* terminate, fmi3Boolean* early_return,
                      fmi3Float64* last_time) {
    return guarded(c, "fmi3DoStep", [&](Instance& instance) {
        put(event, false);
        put(terminate, false);
        put(early_return, false);
        put(last_time, instance.time());
        instance.step(time, size);
        put(last_time, instance.time());
    });
}

fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    return refused(c, "fmi3EnterStepMode", "in co-simulation this FMU has no event mode");
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                    const fmi3Int32 /*orders*/[], fmi3Float64 /*values*/[], size_t /*n*/) {
    return refused(c, "fmi3GetOutputDerivatives", "outputs are sampled signals and have no derivatives");
}

// ------------------------------------------------------------------ model exchange

fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    return guarded(c, "fmi3EnterEventMode", [](Instance& instance) { instance.enter_event(); });
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean* again, fmi3Boolean* terminate,
                                    fmi3Boolean* nominals_changed, fmi3Boolean* values_changed,
                                    fmi3Boolean* next_defined, fmi3Float64* next) {
    return guarded(c, "fmi3UpdateDiscreteStates", [&](Instance& instance) {
        instance.update_discrete_states();
        put(again, false);
        put(terminate, false);
        put(nominals_changed, false);
        put(values_changed, false);
        put(next_defined, true);
        put(next, instance.next_event());
    });
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    return refused(c, "fmi3EvaluateDiscreteStates",
                   "discrete states change in fmi3UpdateDiscreteStates alone");
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) {
    return guarded(c, "fmi3EnterContinuousTimeMode", [](Instance& instance) { instance.enter_continuous(); });
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean /*no_earlier_state*/,
                                       fmi3Boolean* event_mode, fmi3Boolean* terminate) {
    return guarded(c, "fmi3CompletedIntegratorStep", [&](Instance& instance) {
        put(event_mode, instance.completed_integrator_step());
        put(terminate, false);
    });
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
    return guarded(c, "fmi3SetTime", [&](Instance& instance) { instance.set_time(time); });
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 /*values*/[], size_t n) {
    return no_states(c, "fmi3SetContinuousStates", n);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 /*values*/[], size_t n) {
    return no_states(c, "fmi3GetContinuousStateDerivatives", n);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 /*values*/[], size_t n) {
    return no_states(c, "fmi3GetEventIndicators", n);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 /*values*/[], size_t n) {
    return no_states(c, "fmi3GetContinuousStates", n);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 /*values*/[], size_t n) {
    return no_states(c, "fmi3GetNominalsOfContinuousStates", n);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t* count) {
    return guarded(c, "fmi3GetNumberOfEventIndicators", [&](Instance&) { present(count, "count") = 0; });
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t* count) {
    return guarded(c, "fmi3GetNumberOfContinuousStates", [&](Instance&) { present(count, "count") = 0; });
}

// ------------------------------------------------------------------ what this FMU does not have

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference /*unknowns*/[],
                                        size_t /*n_unknowns*/, const fmi3ValueReference /*knowns*/[],
                                        size_t /*n_knowns*/, const fmi3Float64 /*seed*/[], size_t /*n_seed*/,
                                        fmi3Float64 /*sensitivity*/[], size_t /*n_sensitivity*/) {
    return refused(c, "fmi3GetDirectionalDerivative", no_derivatives);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference /*unknowns*/[],
                                    size_t /*n_unknowns*/, const fmi3ValueReference /*knowns*/[],
                                    size_t /*n_knowns*/, const fmi3Float64 /*seed*/[], size_t /*n_seed*/,
                                    fmi3Float64 /*sensitivity*/[], size_t /*n_sensitivity*/) {
    return refused(c, "fmi3GetAdjointDerivative", no_derivatives);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    return refused(c, "fmi3EnterConfigurationMode", no_structure);
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    return refused(c, "fmi3ExitConfigurationMode", no_structure);
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                  fmi3Float64 /*intervals*/[], fmi3IntervalQualifier /*qualifiers*/[]) {
    return refused(c, "fmi3GetIntervalDecimal", no_clocks);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                   fmi3UInt64 /*counters*/[], fmi3UInt64 /*resolutions*/[],
                                   fmi3IntervalQualifier /*qualifiers*/[]) {
    return refused(c, "fmi3GetIntervalFraction", no_clocks);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                               fmi3Float64 /*shifts*/[]) {
    return refused(c, "fmi3GetShiftDecimal", no_clocks);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                fmi3UInt64 /*counters*/[], fmi3UInt64 /*resolutions*/[]) {
    return refused(c, "fmi3GetShiftFraction", no_clocks);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                  const fmi3Float64 /*intervals*/[]) {
    return refused(c, "fmi3SetIntervalDecimal", no_clocks);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                   const fmi3UInt64 /*counters*/[], const fmi3UInt64 /*resolutions*/[]) {
    return refused(c, "fmi3SetIntervalFraction", no_clocks);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                               const fmi3Float64 /*shifts*/[]) {
    return refused(c, "fmi3SetShiftDecimal", no_clocks);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference /*vr*/[], size_t /*nvr*/,
                                const fmi3UInt64 /*counters*/[], const fmi3UInt64 /*resolutions*/[]) {
    return refused(c, "fmi3SetShiftFraction", no_clocks);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference /*clock*/, fmi3Float64 /*time*/) {
    return refused(c, "fmi3ActivateModelPartition", no_clocks);
}

}  // extern "C"
