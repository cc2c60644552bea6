/* FMI 3 for system.c, into which it is included. Each call says whether it succeeded. */
#include <stdbool.h>

#include "fmi3FunctionTypes.h"

typedef struct {
    fmi3Instance instance;
    fmi3SetFloat64TYPE* set_real;
    fmi3SetInt32TYPE* set_integer;
    fmi3SetBooleanTYPE* set_boolean;
    fmi3GetFloat64TYPE* get_real;
    fmi3GetInt32TYPE* get_integer;
    fmi3GetBooleanTYPE* get_boolean;
    fmi3EnterInitializationModeTYPE* enter;
    fmi3ExitInitializationModeTYPE* exit;
    fmi3DoStepTYPE* step;
    fmi3FreeInstanceTYPE* release;
} Calls;

static void report(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                   fmi3String message) {
    (void)environment, (void)status;
    fprintf(stderr, "system: %s: %s\n", category, message);
}

static Calls load(Library library) {
    return (Calls){
        .set_real = (fmi3SetFloat64TYPE*)FIND(library, "fmi3SetFloat64"),
        .set_integer = (fmi3SetInt32TYPE*)FIND(library, "fmi3SetInt32"),
        .set_boolean = (fmi3SetBooleanTYPE*)FIND(library, "fmi3SetBoolean"),
        .get_real = (fmi3GetFloat64TYPE*)FIND(library, "fmi3GetFloat64"),
        .get_integer = (fmi3GetInt32TYPE*)FIND(library, "fmi3GetInt32"),
        .get_boolean = (fmi3GetBooleanTYPE*)FIND(library, "fmi3GetBoolean"),
        .enter = (fmi3EnterInitializationModeTYPE*)FIND(library, "fmi3EnterInitializationMode"),
        .exit = (fmi3ExitInitializationModeTYPE*)FIND(library, "fmi3ExitInitializationMode"),
        .step = (fmi3DoStepTYPE*)FIND(library, "fmi3DoStep"),
        .release = (fmi3FreeInstanceTYPE*)FIND(library, "fmi3FreeInstance"),
    };
}

static int instantiate(Calls* calls, Library library, const char* name, const char* token,
                       const char* resources) {
    calls->instance = ((fmi3InstantiateCoSimulationTYPE*)FIND(library, "fmi3InstantiateCoSimulation"))(
        name, token, resources, false, false, false, false, NULL, 0, NULL, report, NULL);
    return calls->instance != NULL;
}

static int set(const Calls* calls, Variable v, const double* values) {
    fmi3Int32 whole[LARGEST];
    fmi3Boolean truth[LARGEST];
    for (size_t i = 0; i < v.size; ++i) {
        whole[i] = (fmi3Int32)values[i];
        truth[i] = values[i] != 0;
    }
    return (v.kind == 'R'   ? calls->set_real(calls->instance, &v.reference, 1, values, v.size)
            : v.kind == 'I' ? calls->set_integer(calls->instance, &v.reference, 1, whole, v.size)
                            : calls->set_boolean(calls->instance, &v.reference, 1, truth, v.size)) == fmi3OK;
}

static int get(const Calls* calls, Variable v, double* values) {
    fmi3Int32 whole[LARGEST];
    fmi3Boolean truth[LARGEST];
    const fmi3Status status =
        v.kind == 'R'   ? calls->get_real(calls->instance, &v.reference, 1, values, v.size)
        : v.kind == 'I' ? calls->get_integer(calls->instance, &v.reference, 1, whole, v.size)
                        : calls->get_boolean(calls->instance, &v.reference, 1, truth, v.size);
    for (size_t i = 0; i < v.size && v.kind != 'R'; ++i) values[i] = v.kind == 'I' ? whole[i] : truth[i];
    return status == fmi3OK;
}

static int enter_initialisation(const Calls* calls, double stop) {
    return calls->enter(calls->instance, false, 0, 0, true, stop) == fmi3OK;
}

static int exit_initialisation(const Calls* calls) { return calls->exit(calls->instance) == fmi3OK; }

static int do_step(const Calls* calls, double time, double step) {
    bool event = false, terminate = false, early = false;
    fmi3Float64 reached = 0;
    return calls->step(calls->instance, time, step, true, &event, &terminate, &early, &reached) == fmi3OK;
}

static void free_instance(const Calls* calls) { calls->release(calls->instance); }
