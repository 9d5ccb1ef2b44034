/* A master in C for the FMUs without Python: the same steps as master.py.
 *
 *   cc -O1 master.c -o master -ldl
 *   master WIRING STEP STOP
 *
 * The file WIRING, which build.py --native writes, says one thing a line:
 *
 *   fmu NAME GUID LIBRARY
 *   real NAME REFERENCE VALUE                   a parameter
 *   text NAME REFERENCE VALUE
 *   connect SOURCE REFERENCE TARGET REFERENCE
 *   watch NAME REFERENCE                        a column of the output
 *
 * At each communication point all outputs are read, then all inputs set: what each FMU says follows from its state, so no
 * order matters. Prints time and what is watched. Exit status 0 if all went well.
 */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FMUS = 8, MOST_LINES = 64, WORD = 1024 };

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    char name[64];
    void *fmu;
    int (*get_real)(void *, const unsigned[], size_t, double[]);
    int (*set_real)(void *, const unsigned[], size_t, const double[]);
    int (*set_string)(void *, const unsigned[], size_t, const char *const[]);
    int (*enter)(void *), (*leave)(void *), (*terminate)(void *);
    int (*set_up)(void *, int, double, double, int, double);
    int (*step)(void *, double, double, int);
    void (*release)(void *);
} Part;

typedef struct { Part *source, *target; unsigned from, to; } Wire;

static Part parts[MOST_FMUS];
static Wire wires[MOST_LINES], watched[MOST_LINES];
static int part_count, wire_count, watched_count;

static void fail(const char *what, const char *which) {
    fprintf(stderr, "%s: %s\n", which, what);
    exit(1);
}

static void check(int status, const char *call, const char *which) {
    if (status != 0) fail(call, which);
}

static void logger(void *environment, const char *name, int status, const char *category, const char *text, ...) {
    va_list arguments;
    (void)environment, (void)category;
    va_start(arguments, text);
    fprintf(stderr, "%s, status %d: ", name, status);
    vfprintf(stderr, text, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

static const Callbacks callbacks = {logger, calloc, free, NULL, NULL};

static Part *part_of(const char *name) {
    for (int k = 0; k < part_count; k++)
        if (!strcmp(parts[k].name, name)) return &parts[k];
    fail("no such FMU", name);
    return NULL;
}

static void *function(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) fail("not in the library", name);
    return found;
}

static void load(const char *name, const char *path, const char *guid) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fail(dlerror(), path);
    if (part_count == MOST_FMUS) fail("too many FMUs", name);
    Part *part = &parts[part_count++];
    snprintf(part->name, sizeof part->name, "%.63s", name);
    void *(*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    *(void **)&instantiate = function(library, "fmi2Instantiate");
    *(void **)&part->get_real = function(library, "fmi2GetReal");
    *(void **)&part->set_real = function(library, "fmi2SetReal");
    *(void **)&part->set_string = function(library, "fmi2SetString");
    *(void **)&part->set_up = function(library, "fmi2SetupExperiment");
    *(void **)&part->enter = function(library, "fmi2EnterInitializationMode");
    *(void **)&part->leave = function(library, "fmi2ExitInitializationMode");
    *(void **)&part->step = function(library, "fmi2DoStep");
    *(void **)&part->terminate = function(library, "fmi2Terminate");
    *(void **)&part->release = function(library, "fmi2FreeInstance");
    part->fmu = instantiate(name, 1, guid, "", &callbacks, 0, 0);
    if (!part->fmu) fail("no instance", name);
}

static void read_wiring(const char *path) {
    char line[4 * WORD], first[WORD], second[WORD], third[WORD];
    unsigned reference, other;
    double value;
    FILE *file = fopen(path, "r");
    if (!file) fail("cannot be read", path);
    while (fgets(line, sizeof line, file)) {
        if (wire_count == MOST_LINES || watched_count == MOST_LINES) fail("too many lines", path);
        if (sscanf(line, "fmu %63s %1023s %1023[^\n]", first, second, third) == 3)
            load(first, third, second);
        else if (sscanf(line, "real %63s %u %lf", first, &reference, &value) == 3) {
            Part *part = part_of(first);
            check(part->set_real(part->fmu, &reference, 1, &value), "parameter", first);
        } else if (sscanf(line, "text %63s %u %1023s", first, &reference, second) == 3) {
            Part *part = part_of(first);
            const char *text = second;
            check(part->set_string(part->fmu, &reference, 1, &text), "parameter", first);
        } else if (sscanf(line, "connect %63s %u %63s %u", first, &reference, second, &other) == 4)
            wires[wire_count++] = (Wire){part_of(first), part_of(second), reference, other};
        else if (sscanf(line, "watch %63s %u", first, &reference) == 2)
            watched[watched_count++] = (Wire){part_of(first), NULL, reference, 0};
        else
            fail("not understood", line);
    }
    fclose(file);
}

static void hand_over(void) {
    double values[MOST_LINES];
    for (int k = 0; k < wire_count; k++)
        check(wires[k].source->get_real(wires[k].source->fmu, &wires[k].from, 1, &values[k]), "get",
              wires[k].source->name);
    for (int k = 0; k < wire_count; k++)
        check(wires[k].target->set_real(wires[k].target->fmu, &wires[k].to, 1, &values[k]), "set",
              wires[k].target->name);
}

static void show(double time) {
    double value;
    printf("%.17g", time);
    for (int k = 0; k < watched_count; k++) {
        const Wire *wire = &watched[k];
        check(wire->source->get_real(wire->source->fmu, &wire->from, 1, &value), "get", wire->source->name);
        printf(",%.17g", value);
    }
    putchar('\n');
}

int main(int count, char **words) {
    if (count != 4) fail("WIRING STEP STOP are wanted", words[0]);
    double step = atof(words[2]), stop = atof(words[3]);
    if (!(step > 0.0) || !(stop >= 0.0) || stop / step > 1e9) fail("must be positive, STOP at most 1e9 steps", "STEP");
    read_wiring(words[1]);
    for (int k = 0; k < part_count; k++) {
        check(parts[k].set_up(parts[k].fmu, 0, 0.0, 0.0, 0, 0.0), "set-up", parts[k].name);
        check(parts[k].enter(parts[k].fmu), "initialization", parts[k].name);
        check(parts[k].leave(parts[k].fmu), "end of initialization", parts[k].name);
    }
    /* whole steps, and a shorter one up to STOP */
    long whole = (long)(stop / step + 1e-9);
    double rest = stop - (double)whole * step;
    long steps = whole + (rest > 1e-9 * step);
    for (long n = 0; n <= steps; n++) {
        show(n > whole ? stop : (double)n * step);
        if (n < steps) hand_over();
        for (int k = 0; n < steps && k < part_count; k++)
            check(parts[k].step(parts[k].fmu, (double)n * step, n < whole ? step : rest, 1), "step", parts[k].name);
    }
    for (int k = 0; k < part_count; k++) {
        check(parts[k].terminate(parts[k].fmu), "end", parts[k].name);
        parts[k].release(parts[k].fmu);
    }
    return 0;
}
