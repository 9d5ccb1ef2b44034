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
_Static_assert((int)ST_OK == fmi2OK && (int)ST_WARNING == fmi2Warning && (int)ST_DISCARD == fmi2Discard &&
                   (int)ST_ERROR == fmi2Error,
               "the statuses of FMI 2.0 are those of the core");

static void tell(void *host, Status status, const char *text) {
    static const char *const categories[] = {[ST_OK] = "logAll", [ST_WARNING] = "logStatusWarning",
                                             [ST_DISCARD] = "logStatusDiscard", [ST_ERROR] = "logStatusError"};
    const Face *face = host;
    char escaped[MESSAGE];
    size_t length = 0;
    if (!face->logger || (status == ST_OK && !face->logging)) return;
    for (const char *at = text; *at && length + 2 < sizeof escaped; at++) { /* the host's logger takes it for a format */
        if (*at == '%') escaped[length++] = '%';
        escaped[length++] = *at;
    }
    escaped[length] = 0;
    face->logger(face->environment, face->name, (fmi2Status)status, categories[status], escaped);
}

/* What a call answers: the instance is there, and the core does what it is asked. */
#define ANSWER(call)                                                                                                   \
    Face *face = component;                                                                                            \
    return face ? (fmi2Status)(call) : fmi2Error

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

FMI2_Export void fmi2FreeInstance(fmi2Component component) {
    Face *face = component;
    if (face) core_free(face->column);
    free(face);
}

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                                           const fmi2String categories[]) {
    Face *face = component;
    (void)count, (void)categories;
    if (!face) return fmi2Error;
    face->logging = on;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                           fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    ANSWER(core_set_up(face->column, start, has_stop ? &stop : NULL, has_tolerance ? &tolerance : NULL));
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
    ANSWER(core_enter_initialization(face->column));
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    ANSWER(core_exit_initialization(face->column));
}

FMI2_Export fmi2Status fmi2Terminate(fmi2Component component) { ANSWER(core_terminate(face->column)); }

FMI2_Export fmi2Status fmi2Reset(fmi2Component component) { ANSWER((core_reset(face->column), ST_OK)); }

/* --- variables */

FMI2_Export fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                   fmi2Real values[]) {
    ANSWER(core_get_reals(face->column, references, count, values));
}

FMI2_Export fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      fmi2Integer values[]) {
    Face *face = component;
    if (!face || core_readable(face->column, references, count, INTEGER, values) != ST_OK) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = (fmi2Integer)core_whole(face->column, references[k]);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      fmi2Boolean values[]) {
    Face *face = component;
    if (!face || core_readable(face->column, references, count, BOOLEAN, values) != ST_OK) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = core_whole(face->column, references[k]) ? fmi2True : fmi2False;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                     fmi2String values[]) {
    Face *face = component;
    if (!face || core_readable(face->column, references, count, STRING, values) != ST_OK) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = core_text(face->column, references[k]);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                   const fmi2Real values[]) {
    ANSWER(core_set_reals(face->column, references, count, values));
}

FMI2_Export fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      const fmi2Integer values[]) {
    Face *face = component;
    if (!face || core_settable(face->column, references, count, INTEGER, values) != ST_OK) return fmi2Error;
    for (size_t k = 0; k < count; k++) core_put_whole(face->column, references[k], values[k]);
    core_has_changed(face->column, count > 0); /* no input is whole */
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      const fmi2Boolean values[]) {
    /* no Boolean can be set */
    ANSWER(core_settable(face->column, references, count, BOOLEAN, values));
}

FMI2_Export fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                     const fmi2String values[]) {
    ANSWER(core_set_texts(face->column, references, count, values));
}

/* --- steps */

FMI2_Export fmi2Status fmi2DoStep(fmi2Component component, fmi2Real start, fmi2Real step, fmi2Boolean no_return) {
    (void)no_return;
    ANSWER(core_step(face->column, start, step));
}

static fmi2Status refuse(Face *face, fmi2Status status, const char *text) {
    if (!face) return fmi2Error;
    core_say(face->column, (Status)status, "%s", text);
    return status;
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component component) {
    return refuse(component, fmi2Error, "no step can be cancelled: every step is finished when fmi2DoStep returns");
}

static fmi2Status no_status(Face *face, int kind) {
    char text[NAME];
    snprintf(text, sizeof text, "status %d: is not known of this kind", kind);
    return refuse(face, fmi2Discard, text);
}

FMI2_Export fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value) {
    Face *face = component;
    if (!face || kind != fmi2DoStepStatus) return no_status(face, kind);
    if (!core_has(face->column, value, 1, "value")) return fmi2Error;
    *value = (fmi2Status)core_last_step(face->column);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
    Face *face = component;
    if (!face || kind != fmi2LastSuccessfulTime) return no_status(face, kind);
    if (!core_has(face->column, value, 1, "value")) return fmi2Error;
    *value = core_time(face->column);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)value;
    return no_status(component, kind);
}

FMI2_Export fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value) {
    Face *face = component;
    if (!face || kind != fmi2Terminated) return no_status(face, kind);
    if (!core_has(face->column, value, 1, "value")) return fmi2Error;
    *value = fmi2False; /* the slave never asks for the end of the run */
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind, fmi2String *value) {
    Face *face = component;
    if (!face || kind != fmi2PendingStatus) return no_status(face, kind);
    if (!core_has(face->column, value, 1, "value")) return fmi2Error;
    *value = "";
    return fmi2OK;
}

/* --- derivatives */

FMI2_Export fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                                   size_t count, const fmi2Integer orders[], const fmi2Real values[]) {
    ANSWER(core_set_slopes(face->column, references, count, orders, values));
}

FMI2_Export fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                                    size_t count, const fmi2Integer orders[], fmi2Real values[]) {
    ANSWER(core_rates(face->column, references, count, orders, values));
}

FMI2_Export fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[],
                                                    size_t unknown_count, const fmi2ValueReference knowns[],
                                                    size_t known_count, const fmi2Real seeds[], fmi2Real values[]) {
    ANSWER(core_directional(face->column, unknowns, unknown_count, knowns, known_count, seeds, values));
}

/* --- state */

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state) {
    Face *face = component;
    if (!face || !core_has(face->column, state, 1, "state")) return fmi2Error;
    Saved *saved = *state;
    if (core_save(face->column, &saved) != ST_OK) return fmi2Error;
    *state = saved;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
    ANSWER(core_restore(face->column, state));
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state) {
    if (!component) return fmi2Error;
    if (state) {
        core_release(*state);
        *state = NULL;
    }
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size) {
    Face *face = component;
    if (!face || !core_has(face->column, state, 1, "state") || !core_has(face->column, size, 1, "size"))
        return fmi2Error;
    *size = core_bytes();
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                             size_t size) {
    ANSWER(core_to_bytes(face->column, state, bytes, size));
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *state) {
    Face *face = component;
    Saved *saved = NULL;
    if (!face || !core_has(face->column, state, 1, "state")) return fmi2Error;
    if (core_from_bytes(face->column, bytes, size, &saved) != ST_OK) return fmi2Error;
    *state = saved;
    return fmi2OK;
}
