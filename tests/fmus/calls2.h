/* FMI 2 for system.c, into which it is included. Each call says whether it succeeded. */
#include "fmi2FunctionTypes.h"

typedef struct {
    fmi2Component instance;
    fmi2SetRealTYPE* set_real;
    fmi2SetIntegerTYPE* set_integer;
    fmi2SetBooleanTYPE* set_boolean;
    fmi2GetRealTYPE* get_real;
    fmi2GetIntegerTYPE* get_integer;
    fmi2GetBooleanTYPE* get_boolean;
    fmi2SetupExperimentTYPE* set_up;
    fmi2EnterInitializationModeTYPE* enter;
    fmi2ExitInitializationModeTYPE* exit;
    fmi2DoStepTYPE* step;
    fmi2FreeInstanceTYPE* release;
} Calls;

static void report(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    (void)environment, (void)status, (void)message;
    fprintf(stderr, "system: %s logs in %s\n", instance, category);
}

static const fmi2CallbackFunctions environment = {report, calloc, free, NULL, NULL};

static Calls load(Library library) {
    return (Calls){
        .set_real = (fmi2SetRealTYPE*)FIND(library, "fmi2SetReal"),
        .set_integer = (fmi2SetIntegerTYPE*)FIND(library, "fmi2SetInteger"),
        .set_boolean = (fmi2SetBooleanTYPE*)FIND(library, "fmi2SetBoolean"),
        .get_real = (fmi2GetRealTYPE*)FIND(library, "fmi2GetReal"),
        .get_integer = (fmi2GetIntegerTYPE*)FIND(library, "fmi2GetInteger"),
        .get_boolean = (fmi2GetBooleanTYPE*)FIND(library, "fmi2GetBoolean"),
        .set_up = (fmi2SetupExperimentTYPE*)FIND(library, "fmi2SetupExperiment"),
        .enter = (fmi2EnterInitializationModeTYPE*)FIND(library, "fmi2EnterInitializationMode"),
        .exit = (fmi2ExitInitializationModeTYPE*)FIND(library, "fmi2ExitInitializationMode"),
        .step = (fmi2DoStepTYPE*)FIND(library, "fmi2DoStep"),
        .release = (fmi2FreeInstanceTYPE*)FIND(library, "fmi2FreeInstance"),
    };
}

static int instantiate(Calls* calls, Library library, const char* name, const char* guid,
                       const char* resources) {
    calls->instance = ((fmi2InstantiateTYPE*)FIND(library, "fmi2Instantiate"))(
        name, fmi2CoSimulation, guid, resources, &environment, fmi2False, fmi2False);
    return calls->instance != NULL;
}

static int set(const Calls* calls, Variable v, const double* value) {
    const fmi2Integer whole = (fmi2Integer)*value;
    return (v.kind == 'R'   ? calls->set_real(calls->instance, &v.reference, 1, value)
            : v.kind == 'I' ? calls->set_integer(calls->instance, &v.reference, 1, &whole)
                            : calls->set_boolean(calls->instance, &v.reference, 1, &whole)) == fmi2OK;
}

static int get(const Calls* calls, Variable v, double* value) {
    fmi2Integer whole = 0;
    const fmi2Status status = v.kind == 'R'   ? calls->get_real(calls->instance, &v.reference, 1, value)
                              : v.kind == 'I' ? calls->get_integer(calls->instance, &v.reference, 1, &whole)
                                              : calls->get_boolean(calls->instance, &v.reference, 1, &whole);
    if (v.kind != 'R') *value = whole;
    return status == fmi2OK;
}

static int enter_initialisation(const Calls* calls, double stop) {
    return calls->set_up(calls->instance, fmi2False, 0, 0, fmi2True, stop) == fmi2OK &&
           calls->enter(calls->instance) == fmi2OK;
}

static int exit_initialisation(const Calls* calls) { return calls->exit(calls->instance) == fmi2OK; }

static int do_step(const Calls* calls, double time, double step) {
    return calls->step(calls->instance, time, step, fmi2True) == fmi2OK;
}

static void free_instance(const Calls* calls) { calls->release(calls->instance); }
