/* The face of FMI 2.0 for co-simulation: its calls, names and statuses around core.h. Nothing is decided here but what
   the standard alone asks for. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "fmi2Functions.h"

enum { NAME = 256, MESSAGE = 2048 };

typedef struct {
    Instance *column;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    int logging;
    char name[NAME];
} Face;

_Static_assert(sizeof(fmi2ValueReference) == sizeof(Reference) && sizeof(fmi2Real) == sizeof(double) &&
                   sizeof(fmi2Integer) == sizeof(int),
               "the types of FMI 2.0 are those of the core");
#define FMI(name) fmi2##name
#define STATE(before, after) fmi2##before##FMUstate##after
#define DESERIALIZE fmi2DeSerializeFMUstate
#define EXPORT FMI2_Export
typedef fmi2Component Component;

#include "face.h"
#include "status.h"

static void tell(void *host, Status status, const char *text) {
    const Face *face = host;
    char escaped[MESSAGE];
    if (!face->logger || (status == ST_OK && !face->logging)) return;
    escape(text, escaped, sizeof escaped);
    face->logger(face->environment, face->name, (fmi2Status)status, category_of(status), escaped);
}

/* --- life */

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    (void)resources, (void)visible;
    if (!functions) return NULL; /* nowhere to say why */
    Face *face = calloc(1, sizeof *face);
    if (!face) return NULL;
    snprintf(face->name, NAME, "%s", name ? name : "");
    face->logger = functions->logger;
    face->environment = functions->componentEnvironment;
    face->logging = logging;
    const char *fault = NULL;
    if (!name || !*name) fault = "the instance needs a name";
    else if (type != fmi2CoSimulation) fault = "is for co-simulation only";
    else if (!guid || strcmp(guid, core_identity))
        fault = "the GUID is not that of this FMU: binary and model description differ";
    else if (!(face->column = core_new(tell, face))) fault = "out of memory";
    if (!fault) return face;
    tell(face, ST_ERROR, fault);
    free(face);
    return NULL;
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                           fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    ANSWER(core_set_up(face->column, start, has_stop ? &stop : NULL, has_tolerance ? &tolerance : NULL));
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component instance) {
    ANSWER(core_enter_initialization(face->column));
}

/* --- variables */

FMI2_Export fmi2Status fmi2GetReal(fmi2Component instance, const fmi2ValueReference references[], size_t count,
                                   fmi2Real values[]) {
    ANSWER(core_get_reals(face->column, references, count, values));
}

#define GIVEN_TO(own) const fmi2ValueReference references[], size_t count, own values[]
#define BEGIN                                                                                                          \
    Face *face = instance;                                                                                             \
    if (!face) return fmi2Error
#define LIST references
#define ELEMENTS count

GETTER(Integer, INTEGER, (fmi2Integer)core_whole)
GETTER(Boolean, BOOLEAN, !!core_whole)
GETTER(String, STRING, core_text)
SETTERS(Integer)

FMI2_Export fmi2Status fmi2SetReal(fmi2Component instance, const fmi2ValueReference references[], size_t count,
                                   const fmi2Real values[]) {
    ANSWER(core_set_reals(face->column, references, count, values));
}

FMI2_Export fmi2Status fmi2SetString(fmi2Component instance, const fmi2ValueReference references[], size_t count,
                                     const fmi2String values[]) {
    ANSWER(core_set_texts(face->column, references, count, values));
}

/* --- steps */

FMI2_Export fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real start, fmi2Real step, fmi2Boolean no_return) {
    (void)no_return;
    ANSWER(core_step(face->column, start, step));
}

static fmi2Status refuse(Face *face, fmi2Status status, const char *text) {
    if (!face) return fmi2Error;
    return (fmi2Status)core_say(face->column, (Status)status, "%s", text);
}

static int has(const Face *face, const void *value) { return core_has(face->column, value, 1, "value"); }

static fmi2Status last_step(const Face *face) { return (fmi2Status)core_last_step(face->column); }

static fmi2Status last_time(const Face *face, fmi2Real *value) {
    *value = core_time(face->column);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component instance) {
    return refuse(instance, fmi2Error, "no step can be cancelled: every step is finished when fmi2DoStep returns");
}

/* --- derivatives */

FMI2_Export fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance, const fmi2ValueReference references[],
                                                   size_t count, const fmi2Integer orders[], const fmi2Real values[]) {
    ANSWER(core_set_slopes(face->column, references, count, orders, values));
}

FMI2_Export fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance, const fmi2ValueReference references[],
                                                    size_t count, const fmi2Integer orders[], fmi2Real values[]) {
    ANSWER(core_rates(face->column, references, count, orders, values));
}

FMI2_Export fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknowns[],
                                                    size_t unknown_count, const fmi2ValueReference knowns[],
                                                    size_t known_count, const fmi2Real seeds[], fmi2Real values[]) {
    ANSWER(core_directional(face->column, unknowns, unknown_count, knowns, known_count, seeds, values));
}
