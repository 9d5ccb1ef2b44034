/* The guard of the PythonFMU: takes every call of the master and hands it to PythonFMU's library, which lies beside it.

   That library ends the process when it does not find its resources, knows no other escape than %20 in their URI, takes
   any GUID, answers Fatal where the slave has refused a call and lives on, logs a second line then, and none where the
   master has turned logging off. What it does well it goes on doing. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"

#define NEIGHBOUR "pythonfmu.so"
#define SECOND_LINE "Fatal py exception encountered"
enum { PATH = 4096, TEXT = 256, MESSAGE = 2 * PATH, CATEGORIES = 8 };

#define CALLS(each)                                                                                                    \
    each(Instantiate) each(FreeInstance) each(SetDebugLogging) each(SetupExperiment) each(EnterInitializationMode)     \
    each(ExitInitializationMode) each(Terminate) each(Reset) each(GetReal) each(GetInteger) each(GetBoolean)           \
    each(GetString) each(SetReal) each(SetInteger) each(SetBoolean) each(SetString) each(GetFMUstate)                  \
    each(SetFMUstate) each(FreeFMUstate) each(SerializedFMUstateSize) each(SerializeFMUstate)                          \
    each(DeSerializeFMUstate) each(GetDirectionalDerivative) each(SetRealInputDerivatives)                             \
    each(GetRealOutputDerivatives) each(DoStep) each(CancelStep) each(GetRealStatus)

static struct {
#define FIELD(name) fmi2##name##TYPE *name;
    CALLS(FIELD)
} inner;

static void *library;
static char fault[MESSAGE] = ""; /* why the library cannot be called */

/* With the guard, before any call and only once: hosts may instantiate in several threads. */
__attribute__((constructor)) static void load(void) {
    Dl_info here;
    char path[PATH];
    if (!dladdr((void *)load, &here)) return;
    const char *end = strrchr(here.dli_fname, '/');
    snprintf(path, sizeof path, "%.*s" NEIGHBOUR, end ? (int)(end - here.dli_fname) + 1 : 0, here.dli_fname);
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        const char *why = dlerror();
        snprintf(fault, sizeof fault, "PythonFMU's library cannot be loaded: %s; a host that is not Python has to "
                 "bring Python's own library in (LD_PRELOAD)", why ? why : "no reason is known");
        return;
    }
#define FIND(name)                                                                                                     \
    if (!(*(void **)&inner.name = dlsym(library, "fmi2" #name)))                                                       \
        snprintf(fault, sizeof fault, "PythonFMU's library has no fmi2" #name);
    CALLS(FIND)
}

__attribute__((destructor)) static void leave(void) {
    if (library) dlclose(library);
}

typedef struct {
    fmi2Component component;
    fmi2Status last_step;
    fmi2CallbackFunctions functions; /* of the master */
    fmi2CallbackFunctions heard; /* of the guard; PythonFMU's library keeps where they are */
    int logging; /* whether the master wants to hear more than warnings and errors */
    size_t wanted; /* of these categories, 0: of all */
    char categories[CATEGORIES][TEXT];
    int has_failed; /* whether the last line was the reason of an error */
    char name[TEXT];
} Face;

#include "status.h"

/* --- what is said */

static void silent(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String text, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)text;
}

static void say(const Face *instance, fmi2Status status, const char *text) {
    char escaped[MESSAGE];
    escape(text, escaped, sizeof escaped);
    fprintf(stderr, "%s: %s\n", instance->name, text); /* as the slave itself does */
    instance->functions.logger(instance->functions.componentEnvironment, instance->name, status,
                               status == fmi2Discard ? "logStatusDiscard" : "logStatusError", escaped);
}

static int is_wanted(const Face *instance, const char *category) {
    size_t k = 0;
    while (k < instance->wanted && strcmp(instance->categories[k], category)) k++;
    return instance->logging && (!instance->wanted || k < instance->wanted);
}

/* A line of the slave or of PythonFMU's library: warnings and errors are passed on even if logging is off, and what the
   library adds to the reason of an error is left out. */
static void hear(fmi2ComponentEnvironment component, fmi2String name, fmi2Status status, fmi2String category,
                 fmi2String text, ...) {
    Face *instance = component;
    char escaped[MESSAGE];
    int repeats = instance->has_failed && !strncmp(text, SECOND_LINE, sizeof SECOND_LINE - 1);
    instance->has_failed = status == fmi2Error;
    if (repeats || (status == fmi2OK && !is_wanted(instance, category ? category : ""))) return;
    escape(text, escaped, sizeof escaped);
    instance->functions.logger(instance->functions.componentEnvironment, name, status,
                               category ? category : "logStatusFatal", escaped);
}

/* --- the folder with the resources */

static int holds_the_slave(const char *folder) {
    char file[PATH + 32];
    snprintf(file, sizeof file, "%s/slavemodule.txt", folder);
    return access(file, R_OK) == 0;
}

static int digit_of(char letter) {
    const char *digits = "0123456789abcdef", *found = letter ? strchr(digits, letter | 0x20) : NULL;
    return found ? (int)(found - digits) : -1;
}

static void decode(const char *from, char *to) {
    while (*from) {
        int high = *from == '%' ? digit_of(from[1]) : -1, low = high < 0 ? -1 : digit_of(from[2]);
        *to++ = low < 0 ? *from : (char)(16 * high + low);
        from += low < 0 ? 1 : 3;
    }
    *to = 0;
}

/* The path behind a URI: as it is written, for hosts that escape nothing, else with its escapes resolved. */
static int find_resources(const char *uri, char *path, char *reason) {
    static const char *const heads[] = {"file://localhost/", "file:///", "file:/"};
    const char *written = uri;
    if (!uri) return snprintf(reason, MESSAGE, "the URI of the resources is missing"), 0;
    for (size_t k = 0; k < sizeof heads / sizeof *heads && written == uri; k++)
        if (!strncmp(uri, heads[k], strlen(heads[k]))) written = uri + strlen(heads[k]) - 1;
    if (strlen(written) < PATH) {
        strcpy(path, written);
        for (int decoded = 0; decoded < 2; decoded++) {
            if (decoded) decode(written, path);
            for (size_t end = strlen(path); end > 1 && path[end - 1] == '/'; end--) path[end - 1] = 0;
            if (!holds_the_slave(path)) continue;
            if (!strstr(path, "%20")) return 1;
            snprintf(reason, MESSAGE, "resources in %s: PythonFMU's library takes no folder with %%20 in its name", path);
            return 0;
        }
    }
    snprintf(reason, MESSAGE, "resources in %.*s: are not there, must be the URI of the FMU's folder resources", PATH, uri);
    return 0;
}

/* Whether the master means this FMU; without a file, as where the FMU is made by hand, any. */
static int is_own(const char *guid, const char *resources) {
    char own[TEXT] = "", path[PATH + 32];
    snprintf(path, sizeof path, "%s/guid.txt", resources);
    FILE *file = fopen(path, "r");
    if (!file) return 1;
    if (!fgets(own, sizeof own, file)) own[0] = 0;
    fclose(file);
    own[strcspn(own, "\r\n")] = 0;
    return guid && !strcmp(guid, own);
}

/* --- the calls */

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    char path[PATH], reason[MESSAGE] = "";
    Face *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    if (functions) instance->functions = *functions;
    if (!instance->functions.logger) instance->functions.logger = silent;
    instance->heard = instance->functions;
    instance->heard.logger = hear;
    instance->heard.componentEnvironment = instance;
    instance->logging = logging;
    snprintf(instance->name, TEXT, "%s", name ? name : "");
    if (fault[0]) memcpy(reason, fault, sizeof fault);
    else if (!name || !*name) strcpy(reason, "the instance needs a name");
    else if (type != fmi2CoSimulation) strcpy(reason, "is for co-simulation only");
    else if (!find_resources(resources, path, reason)) {
    } else if (!is_own(guid, path))
        strcpy(reason, "the GUID is not that of this FMU: binary and model description differ");
    if (reason[0]) say(instance, fmi2Error, reason);
    else
        instance->component = inner.Instantiate(name, type, guid, path, &instance->heard, visible, fmi2True);
    if (instance->component) return instance;
    free(instance);
    return NULL;
}

FMI2_Export void fmi2FreeInstance(fmi2Component component) {
    Face *instance = component;
    if (!instance) return;
    inner.FreeInstance(instance->component);
    free(instance);
}

/* Fatal is all that PythonFMU's library makes of a call that the slave refuses; the slave sees to it that it lives on. */
static fmi2Status answer(fmi2Status status) { return status == fmi2Fatal ? fmi2Error : status; }

/* Whether one of three pointers is missing to `count` values: PythonFMU's library would follow it all the same. */
static int lacks(const Face *instance, size_t count, const void *first, const void *second, const void *third) {
    if (!count || (first && second && third)) return 0;
    say(instance, fmi2Error, "a pointer is NULL");
    return 1;
}

#define NEEDS(count, first, second, third) lacks(instance, count, first, second, third)
#define HAND_OVER(name, declared, missing, given)                                                                      \
    FMI2_Export fmi2Status fmi2##name declared {                                                                       \
        Face *instance = component;                                                                                \
        return instance && !(missing) ? answer(inner.name given) : fmi2Error;                                          \
    }
#define ITS instance->component
typedef fmi2ValueReference Reference;

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                                           const fmi2String categories[]) {
    Face *instance = component;
    if (!instance || NEEDS(count, categories, categories, categories)) return fmi2Error;
    instance->logging = on;
    instance->wanted = count < CATEGORIES ? count : CATEGORIES;
    for (size_t k = 0; k < instance->wanted; k++)
        snprintf(instance->categories[k], TEXT, "%s", categories[k] ? categories[k] : "");
    return fmi2OK;
}

HAND_OVER(SetupExperiment,
          (fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start, fmi2Boolean has_stop,
           fmi2Real stop),
          0, (ITS, has_tolerance, tolerance, start, has_stop, stop))
HAND_OVER(EnterInitializationMode, (fmi2Component component), 0, (ITS))
HAND_OVER(ExitInitializationMode, (fmi2Component component), 0, (ITS))
HAND_OVER(Terminate, (fmi2Component component), 0, (ITS))
#define ACCESS(kind)                                                                                                   \
    HAND_OVER(Get##kind, (fmi2Component component, const Reference of[], size_t count, fmi2##kind values[]),           \
              NEEDS(count, of, values, values), (ITS, of, count, values))                                              \
    HAND_OVER(Set##kind, (fmi2Component component, const Reference of[], size_t count, const fmi2##kind values[]),     \
              NEEDS(count, of, values, values), (ITS, of, count, values))
ACCESS(Real)
ACCESS(Integer)
ACCESS(Boolean)
ACCESS(String)
HAND_OVER(GetFMUstate, (fmi2Component component, fmi2FMUstate *state),
          NEEDS(1, state, state, state), (ITS, state))
HAND_OVER(SetFMUstate, (fmi2Component component, fmi2FMUstate state), NEEDS(1, state, state, state), (ITS, state))
HAND_OVER(FreeFMUstate, (fmi2Component component, fmi2FMUstate *state),
          0, (ITS, state))
HAND_OVER(DeSerializeFMUstate, (fmi2Component component, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state),
          NEEDS(1, bytes, state, state), (ITS, bytes, size, state))
HAND_OVER(GetDirectionalDerivative,
          (fmi2Component component, const Reference unknowns[], size_t unknown_count, const Reference knowns[],
           size_t known_count, const fmi2Real seeds[], fmi2Real values[]),
          NEEDS(unknown_count, unknowns, values, values) || NEEDS(known_count, knowns, seeds, seeds),
          (ITS, unknowns, unknown_count, knowns, known_count, seeds, values))
HAND_OVER(SetRealInputDerivatives,
          (fmi2Component component, const Reference of[], size_t count, const fmi2Integer orders[],
           const fmi2Real values[]),
          NEEDS(count, of, orders, values), (ITS, of, count, orders, values))
HAND_OVER(GetRealOutputDerivatives,
          (fmi2Component component, const Reference of[], size_t count, const fmi2Integer orders[], fmi2Real values[]),
          NEEDS(count, of, orders, values), (ITS, of, count, orders, values))
HAND_OVER(CancelStep, (fmi2Component component), 0, (ITS))

/* --- states as bytes: PythonFMU's library copies as many as the host asks for, and the slave gives none for no state */

static fmi2Status refuse(Face *instance, fmi2Status status, const char *text) {
    say(instance, status, text);
    return status;
}

static fmi2Status measure(Face *instance, fmi2FMUstate state, size_t *size) {
    fmi2Status status = answer(inner.SerializedFMUstateSize(instance->component, state, size));
    if (status != fmi2OK || *size) return status;
    return refuse(instance, fmi2Error, "the state came from bytes that hold no state: it cannot be serialized");
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size) {
    Face *instance = component;
    return instance && !NEEDS(1, state, size, size) ? measure(instance, state, size) : fmi2Error;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                             size_t size) {
    Face *instance = component;
    size_t whole;
    if (!instance || NEEDS(1, state, bytes, bytes) || measure(instance, state, &whole) != fmi2OK) return fmi2Error;
    if (size < whole) return refuse(instance, fmi2Error, "the room for the serialized state is too small");
    return answer(inner.SerializeFMUstate(instance->component, state, bytes, whole));
}

FMI2_Export fmi2Status fmi2Reset(fmi2Component component) { /* makes a new slave: without one Fatal is true */
    Face *instance = component;
    if (!instance) return fmi2Error;
    instance->last_step = fmi2OK;
    return inner.Reset(instance->component);
}

FMI2_Export fmi2Status fmi2DoStep(fmi2Component component, fmi2Real start, fmi2Real step, fmi2Boolean no_return) {
    Face *instance = component;
    if (!instance) return fmi2Error;
    return instance->last_step = answer(inner.DoStep(instance->component, start, step, no_return));
}

/* --- how the last step ended: PythonFMU's library says that the slave wants to end the run after any that is discarded */

static int has(const Face *instance, const void *value) { return !lacks(instance, 1, value, value, value); }

static fmi2Status last_step(const Face *instance) { return instance->last_step; }

static fmi2Status last_time(const Face *instance, fmi2Real *value) {
    return inner.GetRealStatus(instance->component, fmi2LastSuccessfulTime, value);
}
