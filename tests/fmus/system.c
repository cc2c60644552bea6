/* Runs a system of FMUs (FMI 2, co-simulation) without Python, so that binaries for other platforms can be
   tried under an emulator. All step at once from the values at the beginning of the step.

   system {<binary> <guid> <model name>} ... < orders > results

   Orders are words, numbers in C's hexadecimal notation (%a) so that no digit is lost; R, I and B stand for
   Real, Integer and Boolean:
       <step> <steps>
       for each FMU:
           <parameters>  {R|I|B <value reference> <value>} ...      set before initialisation
           <outputs>     {R|I|B <value reference>} ...              shown
       <connections>     {<FMU> R|I|B <value reference> <FMU> R|I|B <value reference>} ...
                                                                    from an output to an input of a later FMU
   Results are one line after initialisation and after each step: the outputs of all.
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
    int from, to; /* FMUs */
    Variable output, input;
} Connection;

typedef struct {
    Library library;
    fmi2Component instance;
    int output_count;
    Variable* outputs;
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
        fprintf(stderr, "system: %s failed\n", what);
        exit(1);
    }
}

static void report(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    (void)environment, (void)status, (void)message;
    fprintf(stderr, "system: %s logs in %s\n", instance, category);
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

static void* space(int count, size_t size) {
    void* result = calloc((size_t)count + 1, size);
    must(result != NULL, "allocating memory");
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
    fmu.output_count = (int)number();
    fmu.outputs = space(fmu.output_count, sizeof *fmu.outputs);
    for (int i = 0; i < fmu.output_count; ++i) fmu.outputs[i] = variable();
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
    for (int i = 0; i < fmu->output_count; ++i) printf("%a ", get(fmu, fmu->outputs[i]));
}

/* Carries values to one FMU, or to all. */
static void transfer(const Fmu* fmus, const Connection* connections, int count, int to) {
    for (int i = 0; i < count; ++i) {
        const Connection* c = connections + i;
        if (to < 0 || c->to == to) set(fmus + c->to, c->input, get(fmus + c->from, c->output));
    }
}

int main(int argc, char** argv) {
    must(argc > 1 && argc % 3 == 1, "the command line");
    const int count = argc / 3;
    const double step = number();
    const int steps = (int)number();
    const fmi2CallbackFunctions environment = {report, calloc, free, NULL, NULL};
    Fmu* fmus = space(count, sizeof *fmus);
    for (int k = 0; k < count; ++k) fmus[k] = prepared(argv + 1 + 3 * k, &environment);
    const int connection_count = (int)number();
    Connection* connections = space(connection_count, sizeof *connections);
    for (int i = 0; i < connection_count; ++i) {
        connections[i].from = (int)number();
        connections[i].output = variable();
        connections[i].to = (int)number();
        connections[i].input = variable();
    }

    for (int k = 0; k < count; ++k) {
        begin_initialisation(fmus + k, step * steps);
        transfer(fmus, connections, connection_count, k);
        finish_initialisation(fmus + k);
    }
    for (int index = 0; index <= steps; ++index) {
        for (int k = 0; k < count; ++k) show(fmus + k);
        printf("\n");
        if (index == steps) break;
        transfer(fmus, connections, connection_count, -1);
        for (int k = 0; k < count; ++k) {
            must(fmus[k].do_step(fmus[k].instance, index * step, step, fmi2True) == fmi2OK, "fmi2DoStep");
        }
    }
    for (int k = 0; k < count; ++k) {
        ((fmi2FreeInstanceTYPE*)FIND(fmus[k].library, "fmi2FreeInstance"))(fmus[k].instance);
    }
    return 0;
}
