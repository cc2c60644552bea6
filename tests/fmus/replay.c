/* Runs an FMU for co-simulation (FMI 2) without Python, so that binaries for other platforms can be tried
   under an emulator.

   replay <binary> <guid> <model name> < orders > results

   Orders are words, numbers in C's hexadecimal notation (%a) so that no digit is lost:
       <step> <steps>
       <parameters>  {R|I|B <value reference> <value>} ...      set before initialisation
       <inputs>      {R|I|B <value reference>} ...              set at the beginning of each step, from the
   rows below <outputs>     {R|I|B <value reference>} ...              one line of results after
   initialisation and each step <steps + 1> rows of the inputs, the first for the initialisation and the first
   step The exit code is 0 if every call succeeded. */
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

static fmi2SetRealTYPE* set_real;
static fmi2SetIntegerTYPE* set_integer;
static fmi2SetBooleanTYPE* set_boolean;
static fmi2GetRealTYPE* get_real;
static fmi2GetIntegerTYPE* get_integer;
static fmi2GetBooleanTYPE* get_boolean;

static void must(int condition, const char* what) {
    if (!condition) {
        fprintf(stderr, "replay: %s failed\n", what);
        exit(1);
    }
}

static void report(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    (void)environment, (void)instance, (void)status, (void)message;
    fprintf(stderr, "replay: the FMU logs in %s\n", category);
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

static Variable* variables(int count) {
    Variable* list = calloc((size_t)count + 1, sizeof *list);
    for (int i = 0; i < count; ++i) list[i] = variable();
    return list;
}

static void set(fmi2Component c, Variable v, double value) {
    const fmi2Integer whole = (fmi2Integer)value;
    must((v.kind == 'R'   ? set_real(c, &v.reference, 1, &value)
          : v.kind == 'I' ? set_integer(c, &v.reference, 1, &whole)
                          : set_boolean(c, &v.reference, 1, &whole)) == fmi2OK,
         "setting a variable");
}

static double get(fmi2Component c, Variable v) {
    double value = 0;
    fmi2Integer whole = 0;
    must((v.kind == 'R'   ? get_real(c, &v.reference, 1, &value)
          : v.kind == 'I' ? get_integer(c, &v.reference, 1, &whole)
                          : get_boolean(c, &v.reference, 1, &whole)) == fmi2OK,
         "getting a variable");
    return v.kind == 'R' ? value : whole;
}

static void feed(fmi2Component c, const Variable* inputs, int count) {
    for (int i = 0; i < count; ++i) set(c, inputs[i], number());
}

static void show(fmi2Component c, const Variable* outputs, int count) {
    for (int i = 0; i < count; ++i) printf("%a ", get(c, outputs[i]));
    printf("\n");
}

int main(int argc, char** argv) {
    must(argc == 4, "the command line");
    const Library library = OPEN(argv[1]);
    must(library != NULL, "loading the binary");
    set_real = (fmi2SetRealTYPE*)FIND(library, "fmi2SetReal");
    set_integer = (fmi2SetIntegerTYPE*)FIND(library, "fmi2SetInteger");
    set_boolean = (fmi2SetBooleanTYPE*)FIND(library, "fmi2SetBoolean");
    get_real = (fmi2GetRealTYPE*)FIND(library, "fmi2GetReal");
    get_integer = (fmi2GetIntegerTYPE*)FIND(library, "fmi2GetInteger");
    get_boolean = (fmi2GetBooleanTYPE*)FIND(library, "fmi2GetBoolean");
    fmi2DoStepTYPE* do_step = (fmi2DoStepTYPE*)FIND(library, "fmi2DoStep");

    const double step = number();
    const int steps = (int)number();
    const fmi2CallbackFunctions environment = {report, calloc, free, NULL, NULL};
    const fmi2Component c = ((fmi2InstantiateTYPE*)FIND(library, "fmi2Instantiate"))(
        argv[3], fmi2CoSimulation, argv[2], NULL, &environment, fmi2False, fmi2False);
    must(c != NULL, "fmi2Instantiate");
    for (int left = (int)number(); left > 0; --left) {
        const Variable parameter = variable();
        set(c, parameter, number());
    }
    const int input_count = (int)number();
    const Variable* inputs = variables(input_count);
    const int output_count = (int)number();
    const Variable* outputs = variables(output_count);

    must(((fmi2SetupExperimentTYPE*)FIND(library, "fmi2SetupExperiment"))(c, fmi2False, 0, 0, fmi2True,
                                                                          step * steps) == fmi2OK,
         "fmi2SetupExperiment");
    must(((fmi2EnterInitializationModeTYPE*)FIND(library, "fmi2EnterInitializationMode"))(c) == fmi2OK,
         "fmi2EnterInitializationMode");
    feed(c, inputs, input_count);
    must(((fmi2ExitInitializationModeTYPE*)FIND(library, "fmi2ExitInitializationMode"))(c) == fmi2OK,
         "fmi2ExitInitializationMode");
    show(c, outputs, output_count);
    for (int i = 0; i < steps; ++i) {
        must(do_step(c, i * step, step, fmi2True) == fmi2OK, "fmi2DoStep");
        show(c, outputs, output_count);
        feed(c, inputs, input_count);
    }
    ((fmi2FreeInstanceTYPE*)FIND(library, "fmi2FreeInstance"))(c);
    return 0;
}
