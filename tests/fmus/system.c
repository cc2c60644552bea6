/* Runs a system of FMUs (co-simulation) without Python, so that binaries for other platforms can be tried under
   an emulator. All step at once from the values at the beginning of the step. Compiled with -DFMI=2 or -DFMI=3:
   what differs stands in calls2.h and calls3.h.

   system {<binary> <guid or token> <model name> <location of the resources>} ... < orders > results

   Orders are words, numbers in C's hexadecimal notation (%a) so that no digit is lost; R, I and B stand for
   real numbers, 32-bit integers and Booleans, and the size is the number of elements (1 in FMI 2):
       <step> <steps>
       for each FMU:
           <parameters>  {R|I|B <value reference> <size> <value> ...} ...    set before initialisation
           <outputs>     {R|I|B <value reference> <size>} ...                shown
       <connections>     {<FMU> <output> <FMU> <input>} ...                  from an output to an input of a later
                                                                            FMU, each as R|I|B <reference> <size>
   Results are one line after initialisation and after each step: the outputs of all.
   The exit code is 0 if every call succeeded. */
#include <stdio.h>
#include <stdlib.h>

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

enum { LARGEST = 256 }; /* elements of an array */

typedef struct {
    char kind;
    unsigned reference;
    size_t size;
} Variable;

typedef struct {
    int from, to; /* FMUs */
    Variable output, input;
} Connection;

static void must(int condition, const char* what) {
    if (!condition) {
        fprintf(stderr, "system: %s failed\n", what);
        exit(1);
    }
}

/* Defines Calls, load, instantiate, set, get, enter_initialisation, exit_initialisation, do_step, free_instance. */
#if FMI == 2
#include "calls2.h"
#else
#include "calls3.h"
#endif

typedef struct {
    Calls calls;
    int output_count;
    Variable* outputs;
} Fmu;

static double number(void) {
    double value = 0;
    must(scanf("%lf", &value) == 1, "reading a number");
    return value;
}

static Variable variable(void) {
    Variable result;
    must(scanf(" %c %u %zu", &result.kind, &result.reference, &result.size) == 3, "reading a variable");
    must(result.size <= LARGEST, "an array of this size");
    return result;
}

static void* space(int count, size_t size) {
    void* result = calloc((size_t)count + 1, size);
    must(result != NULL, "allocating memory");
    return result;
}

/* An instance with its parameters, before initialisation. */
static Fmu prepared(char** words) {
    Fmu fmu;
    double values[LARGEST];
    const Library library = OPEN(words[0]);
    must(library != NULL, "loading a binary");
    fmu.calls = load(library);
    must(instantiate(&fmu.calls, library, words[2], words[1], words[3]), "instantiating");
    for (int left = (int)number(); left > 0; --left) {
        const Variable parameter = variable();
        for (size_t i = 0; i < parameter.size; ++i) values[i] = number();
        must(set(&fmu.calls, parameter, values), "setting a parameter");
    }
    fmu.output_count = (int)number();
    fmu.outputs = space(fmu.output_count, sizeof *fmu.outputs);
    for (int i = 0; i < fmu.output_count; ++i) fmu.outputs[i] = variable();
    return fmu;
}

static void show(const Fmu* fmu) {
    double values[LARGEST];
    for (int i = 0; i < fmu->output_count; ++i) {
        must(get(&fmu->calls, fmu->outputs[i], values), "getting an output");
        for (size_t k = 0; k < fmu->outputs[i].size; ++k) printf("%a ", values[k]);
    }
}

/* Carries values to one FMU, or to all. */
static void transfer(const Fmu* fmus, const Connection* connections, int count, int to) {
    double values[LARGEST];
    for (int i = 0; i < count; ++i) {
        const Connection* c = connections + i;
        if (to >= 0 && c->to != to) continue;
        must(get(&fmus[c->from].calls, c->output, values), "getting an output");
        must(set(&fmus[c->to].calls, c->input, values), "setting an input");
    }
}

int main(int argc, char** argv) {
    must(argc > 1 && argc % 4 == 1, "the command line");
    const int count = argc / 4;
    const double step = number();
    const int steps = (int)number();
    Fmu* fmus = space(count, sizeof *fmus);
    for (int k = 0; k < count; ++k) fmus[k] = prepared(argv + 1 + 4 * k);
    const int connection_count = (int)number();
    Connection* connections = space(connection_count, sizeof *connections);
    for (int i = 0; i < connection_count; ++i) {
        connections[i].from = (int)number();
        connections[i].output = variable();
        connections[i].to = (int)number();
        connections[i].input = variable();
    }

    for (int k = 0; k < count; ++k) {
        must(enter_initialisation(&fmus[k].calls, step * steps), "entering initialisation mode");
        transfer(fmus, connections, connection_count, k);
        must(exit_initialisation(&fmus[k].calls), "leaving initialisation mode");
    }
    for (int index = 0; index <= steps; ++index) {
        for (int k = 0; k < count; ++k) show(fmus + k);
        printf("\n");
        if (index == steps) break;
        transfer(fmus, connections, connection_count, -1);
        for (int k = 0; k < count; ++k) must(do_step(&fmus[k].calls, index * step, step), "stepping");
    }
    for (int k = 0; k < count; ++k) free_instance(&fmus[k].calls);
    return 0;
}
