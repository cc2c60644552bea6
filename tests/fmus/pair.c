/* Runs a plant and a filter together (FMI 2, co-simulation) without Python, so that binaries for other
   platforms can be tried under an emulator. Both step at once from the values at the beginning of the step.

   pair <binary> <guid> <model name> <binary> <guid> <model name> < orders > results

   The first FMU is the plant. Orders are words, numbers in C's hexadecimal notation (%a) so that no digit is
   lost; R, I and B stand for Real, Integer and Boolean:
       <step> <steps>
       for each FMU:
           <parameters>  {R|I|B <value reference> <value>} ...              set before initialisation
           <outputs>     {R|I|B <value reference>} ...                      shown
       <connections>     {R|I|B <of the plant> R|I|B <of the filter>} ...   value references
   Results are one line after initialisation and after each step: the outputs of both.
   The exit code is 0 if every call succeeded. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) GetProcAddress(library, name)
typedef HMODULE Library;
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
typedef void* Library;
#endif

typedef struct {
    char kind;
    fmi2ValueReference reference;
} Variable;

typedef struct {
    int count;
    Variable* of;
} Variables;

typedef struct {
    Library library;
    fmi2Component instance;
    Variables outputs;
    fmi2SetRealTYPE* set_real;
    fmi2SetIntegerTYPE* set_integer;
    fmi2SetBooleanTYPE* set_boolean;
    fmi2GetRealTYPE* get_real;
    fmi2GetIntegerTYPE* get_integer;
    fmi2GetBooleanTYPE* get_boolean;
    fmi2DoStepTYPE* do_step;
} Fmu;

static void must(int condition, const char* what) {
    if (!condition) {
        fprintf(stderr, "pair: %s failed\n", what);
        exit(1);
    }
}

static void report(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    (void)environment, (void)status, (void)message;
    fprintf(stderr, "pair: %s logs in %s\n", instance, category);
}

static double number(void) {
    double value = 0;
    must(scanf("%lf", &value) == 1, "reading a number");
    return value;
}

static Variable variable(void) {
    Variable result;
    must(scanf(" %c %u", &result.kind, &result.reference) == 2, "reading a variable");
    return result;
}

static Variables space(int count) {
    const Variables result = {count, calloc((size_t)count + 1, sizeof(Variable))};
    must(result.of != NULL, "allocating memory");
    return result;
}

static void set(const Fmu* fmu, Variable v, double value) {
    const fmi2Integer whole = (fmi2Integer)value;
    must((v.kind == 'R'   ? fmu->set_real(fmu->instance, &v.reference, 1, &value)
          : v.kind == 'I' ? fmu->set_integer(fmu->instance, &v.reference, 1, &whole)
                          : fmu->set_boolean(fmu->instance, &v.reference, 1, &whole)) == fmi2OK,
         "setting a variable");
}

static double get(const Fmu* fmu, Variable v) {
    double value = 0;
    fmi2Integer whole = 0;
    must((v.kind == 'R'   ? fmu->get_real(fmu->instance, &v.reference, 1, &value)
          : v.kind == 'I' ? fmu->get_integer(fmu->instance, &v.reference, 1, &whole)
                          : fmu->get_boolean(fmu->instance, &v.reference, 1, &whole)) == fmi2OK,
         "getting a variable");
    return v.kind == 'R' ? value : whole;
}

/* An instance with its parameters, before initialisation. */
static Fmu prepared(char** words, const fmi2CallbackFunctions* environment) {
    Fmu fmu = {.library = OPEN(words[0])};
    must(fmu.library != NULL, "loading a binary");
    fmu.set_real = (fmi2SetRealTYPE*)FIND(fmu.library, "fmi2SetReal");
    fmu.set_integer = (fmi2SetIntegerTYPE*)FIND(fmu.library, "fmi2SetInteger");
    fmu.set_boolean = (fmi2SetBooleanTYPE*)FIND(fmu.library, "fmi2SetBoolean");
    fmu.get_real = (fmi2GetRealTYPE*)FIND(fmu.library, "fmi2GetReal");
    fmu.get_integer = (fmi2GetIntegerTYPE*)FIND(fmu.library, "fmi2GetInteger");
    fmu.get_boolean = (fmi2GetBooleanTYPE*)FIND(fmu.library, "fmi2GetBoolean");
    fmu.do_step = (fmi2DoStepTYPE*)FIND(fmu.library, "fmi2DoStep");
    fmu.instance = ((fmi2InstantiateTYPE*)FIND(fmu.library, "fmi2Instantiate"))(
        words[2], fmi2CoSimulation, words[1], NULL, environment, fmi2False, fmi2False);
    must(fmu.instance != NULL, "fmi2Instantiate");
    for (int left = (int)number(); left > 0; --left) {
        const Variable parameter = variable();
        set(&fmu, parameter, number());
    }
    fmu.outputs = space((int)number());
    for (int i = 0; i < fmu.outputs.count; ++i) fmu.outputs.of[i] = variable();
    return fmu;
}

static void begin_initialisation(const Fmu* fmu, double stop) {
    must(((fmi2SetupExperimentTYPE*)FIND(fmu->library, "fmi2SetupExperiment"))(fmu->instance, fmi2False, 0, 0,
                                                                               fmi2True, stop) == fmi2OK,
         "fmi2SetupExperiment");
    must(((fmi2EnterInitializationModeTYPE*)FIND(fmu->library, "fmi2EnterInitializationMode"))(
             fmu->instance) == fmi2OK,
         "fmi2EnterInitializationMode");
}

static void finish_initialisation(const Fmu* fmu) {
    must(((fmi2ExitInitializationModeTYPE*)FIND(fmu->library, "fmi2ExitInitializationMode"))(fmu->instance) ==
             fmi2OK,
         "fmi2ExitInitializationMode");
}

static void show(const Fmu* fmu) {
    for (int i = 0; i < fmu->outputs.count; ++i) printf("%a ", get(fmu, fmu->outputs.of[i]));
}

int main(int argc, char** argv) {
    must(argc == 7, "the command line");
    const double step = number();
    const int steps = (int)number();
    const fmi2CallbackFunctions environment = {report, calloc, free, NULL, NULL};
    const Fmu plant = prepared(argv + 1, &environment);
    const Fmu filter = prepared(argv + 4, &environment);
    const int connections = (int)number();
    const Variables from = space(connections), to = space(connections);
    for (int i = 0; i < connections; ++i) {
        from.of[i] = variable();
        to.of[i] = variable();
    }

    begin_initialisation(&plant, step * steps);
    finish_initialisation(&plant);
    begin_initialisation(&filter, step * steps);
    for (int i = 0; i < connections; ++i) set(&filter, to.of[i], get(&plant, from.of[i]));
    finish_initialisation(&filter);
    for (int index = 0; index <= steps; ++index) {
        show(&plant);
        show(&filter);
        printf("\n");
        if (index == steps) break;
        for (int i = 0; i < connections; ++i) set(&filter, to.of[i], get(&plant, from.of[i]));
        must(plant.do_step(plant.instance, index * step, step, fmi2True) == fmi2OK, "fmi2DoStep, plant");
        must(filter.do_step(filter.instance, index * step, step, fmi2True) == fmi2OK, "fmi2DoStep, filter");
    }
    ((fmi2FreeInstanceTYPE*)FIND(filter.library, "fmi2FreeInstance"))(filter.instance);
    ((fmi2FreeInstanceTYPE*)FIND(plant.library, "fmi2FreeInstance"))(plant.instance);
    return 0;
}
