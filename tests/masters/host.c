/* A host that is not Python: runs an extracted FMU, goes back to a saved and serialized state, and runs on.
 *
 *   host LIBRARY RESOURCES_URI GUID INPUT_REFERENCE OUTPUT_REFERENCE
 *
 * Prints the output after 200 steps of 0.01 s under an input of 0.5, twice: the second time from the state at 1 s.
 * Exit status 0 if every call was answered with OK and both are the same to the last bit.
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
#define dlopen(name, flags) ((void *)LoadLibraryA(name))
#define dlsym(library, name) ((void *)GetProcAddress(library, name))
#define dlclose(library) FreeLibrary(library)
#define dlerror() "cannot be loaded"
#else
#include <dlfcn.h>
#endif

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

static void logger(void *environment, const char *name, int status, const char *category, const char *text, ...) {
    va_list arguments;
    (void)environment;
    va_start(arguments, text);
    fprintf(stderr, "%s, status %d, %s: ", name, status, category ? category : "");
    vfprintf(stderr, text, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

static void *library;

static void *function(const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "%s: not in the library\n", name);
        exit(1);
    }
    return found;
}

#define CALL(name, types, ...)                                          \
    do {                                                                \
        int status = ((int(*) types)function(name))(__VA_ARGS__);       \
        if (status != 0) {                                              \
            fprintf(stderr, "%s: status %d\n", name, status);           \
            return 1;                                                   \
        }                                                               \
    } while (0)

static int run(void *fmu, int first, int last) {
    for (int k = first; k < last; k++)
        CALL("fmi2DoStep", (void *, double, double, int), fmu, 0.01 * k, 0.01, 1);
    return 0;
}

int main(int count, char **words) {
    Callbacks callbacks = {logger, calloc, free, NULL, NULL};
    if (count != 6 || !(library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL))) {
        fprintf(stderr, "%s\n", count != 6 ? "five arguments" : dlerror());
        return 1;
    }
    unsigned input = (unsigned)atoi(words[4]), output = (unsigned)atoi(words[5]);
    double push = 0.5, once, again;
    void *fmu = ((void *(*)(const char *, int, const char *, const char *, const Callbacks *, int, int))function(
        "fmi2Instantiate"))("column", 1, words[3], words[2], &callbacks, 0, 1);
    if (!fmu)
        return 1;
    CALL("fmi2SetupExperiment", (void *, int, double, double, int, double), fmu, 0, 0.0, 0.0, 0, 0.0);
    CALL("fmi2EnterInitializationMode", (void *), fmu);
    CALL("fmi2SetReal", (void *, const unsigned *, size_t, const double *), fmu, &input, 1, &push);
    CALL("fmi2ExitInitializationMode", (void *), fmu);
    if (run(fmu, 0, 100))
        return 1;

    void *state = NULL, *restored = NULL;
    size_t size = 0;
    CALL("fmi2GetFMUstate", (void *, void **), fmu, &state);
    CALL("fmi2SerializedFMUstateSize", (void *, void *, size_t *), fmu, state, &size);
    char *bytes = malloc(size);
    CALL("fmi2SerializeFMUstate", (void *, void *, char *, size_t), fmu, state, bytes, size);
    CALL("fmi2FreeFMUstate", (void *, void **), fmu, &state);
    if (run(fmu, 100, 200))
        return 1;
    CALL("fmi2GetReal", (void *, const unsigned *, size_t, double *), fmu, &output, 1, &once);

    CALL("fmi2Reset", (void *), fmu);
    CALL("fmi2DeSerializeFMUstate", (void *, const char *, size_t, void **), fmu, bytes, size, &restored);
    CALL("fmi2SetFMUstate", (void *, void *), fmu, restored);
    if (run(fmu, 100, 200))
        return 1;
    CALL("fmi2GetReal", (void *, const unsigned *, size_t, double *), fmu, &output, 1, &again);
    CALL("fmi2FreeFMUstate", (void *, void **), fmu, &restored);
    free(bytes);
    CALL("fmi2Terminate", (void *), fmu);
    ((void (*)(void *))function("fmi2FreeInstance"))(fmu);
    dlclose(library);
    printf("%.17g %.17g\n", once, again);
    return once == again ? 0 : 1;
}
