/* The face of FMI 3.0 for co-simulation: its calls, names and statuses around core.h. It decides only what the standard
   alone asks for: arrays, the time as a variable, and inputs that are followed within a step. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "fmi3Functions.h"

enum { TIME = 0 }; /* TIME: the value reference of the independent variable */

typedef struct {
    Instance *column;
    fmi3LogMessageCallback logger;
    fmi3IntermediateUpdateCallback update;
    fmi3InstanceEnvironment environment;
    int logging;
    bool reads; /* within a step, where the importer may get values and not set them */
    size_t followed; /* inputs that the importer gives within a step, and their slopes: core_lines() at most */
    Reference *inputs, *slopes;
    double *first, *last, *line; /* their values at the ends of a piece, and the slopes in between */
    double *set; /* core_inputs(): all inputs as the importer has set them before the step */
    Reference *list; /* twice core_most() of them: a list of references with arrays written out */
    double numbers[]; /* what the pointers point to */
} Face;

_Static_assert(sizeof(fmi3ValueReference) == sizeof(Reference) && sizeof(fmi3Float64) == sizeof(double) &&
                   sizeof(fmi3Int32) == sizeof(int),
               "the types of FMI 3.0 are those of the core");
#define FMI(name) fmi3##name
#define STATE(before, after) fmi3##before##FMUState##after
#define DESERIALIZE fmi3DeserializeFMUState
#define EXPORT FMI3_Export
typedef fmi3Instance Component;

#include "face.h"

static void tell(void *host, Status status, const char *text) {
    const Face *face = host;
    if (face->logger && (status != ST_OK || face->logging))
        face->logger(face->environment, (fmi3Status)status, category_of(status), text);
}

static fmi3Status refuse(const Face *face, const char *format, unsigned number) {
    if (face) core_say(face->column, ST_ERROR, format, number);
    return fmi3Error;
}

/* --- life */

FMI3_Export const char *fmi3GetVersion(void) { return fmi3Version; }

static Face *new_face(void) {
    size_t lines = core_lines(), numbers = 3 * lines + core_inputs(), references = 2 * lines + 2 * core_most();
    Face *face = calloc(1, sizeof *face + numbers * sizeof *face->numbers + references * sizeof *face->list);
    if (!face) return NULL;
    face->first = face->numbers;
    face->last = face->first + lines;
    face->line = face->last + lines;
    face->set = face->line + lines;
    face->inputs = (Reference *)(face->numbers + numbers);
    face->slopes = face->inputs + lines;
    face->list = face->slopes + lines;
    return face;
}

static const char *follow(Face *face, const fmi3ValueReference references[], size_t count) {
    if (count > core_lines()) return "so many variables cannot be given within a step";
    for (size_t k = 0; k < count; k++) {
        face->inputs[k] = references[k];
        if (!core_line(references[k], &face->slopes[k])) return "a variable cannot be given within a step";
    }
    face->followed = count;
    return NULL;
}

FMI3_Export fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference required[], size_t required_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update) {
    (void)resources, (void)visible, (void)early_return;
    Face *face = new_face();
    if (!face) return NULL;
    face->logger = logger;
    face->update = update;
    face->environment = environment;
    face->logging = logging;
    const char *fault = NULL;
    if (!name || !*name) fault = "the instance needs a name";
    else if (!token || strcmp(token, core_identity))
        fault = "the instantiation token is not that of this FMU: binary and model description differ";
    else if (event_mode) fault = "has no event mode";
    else if (update && required_count && !required) fault = "the variables to be given within a step are missing";
    else if (update && (fault = follow(face, required, required_count))) (void)fault;
    else if (!(face->column = core_new(tell, face))) fault = "out of memory";
    if (!fault) return face;
    tell(face, ST_ERROR, fault);
    free(face);
    return NULL;
}

FMI3_Export fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance,
                                                   fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop,
                                                   fmi3Float64 stop) {
    Face *face = instance;
    if (!face) return fmi3Error;
    Status status = core_set_up(face->column, start, has_stop ? &stop : NULL, has_tolerance ? &tolerance : NULL);
    return (fmi3Status)(status == ST_OK ? core_enter_initialization(face->column) : status);
}

/* --- variables: an array stands for its elements, which the core knows one by one */

/* Write out arrays into the face's list: how many elements, or 0 and a reason. They are no more than `room`. */
static size_t written_out(Face *face, const fmi3ValueReference references[], size_t count, size_t room) {
    size_t elements = 0;
    for (size_t k = 0; k < count; k++) {
        size_t extent = core_extent(references[k]);
        if (!extent) return refuse(face, "value reference %u: is not that of a variable", references[k]), 0;
        if (elements + extent > room || elements + extent > core_most())
            return refuse(face, "value reference %u: there are not enough values", references[k]), 0;
        for (size_t i = 0; i < extent; i++) face->list[elements++] = references[k] + (Reference)i;
    }
    if (elements != room) return refuse(face, "%u values are too many", (unsigned)room), 0;
    return elements;
}

/* Begins every call that gets or sets: `elements` of them are in the list, one at least. */
#define WRITE_OUT                                                                                                      \
    Face *face = instance;                                                                                             \
    if (!face) return fmi3Error;                                                                                       \
    if (!count) return fmi3OK;                                                                                         \
    if (!core_has(face->column, references, count, "value references") ||                                              \
        !core_has(face->column, values, value_count, "values"))                                                        \
        return fmi3Error;                                                                                              \
    size_t elements = written_out(face, references, count, value_count);                                               \
    if (!elements) return fmi3Error

FMI3_Export fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                      fmi3Float64 values[], size_t value_count) {
    /* time, which is not in the table: what is before it and behind it is got for itself */
    for (size_t k = 0; instance && references && values && k < count; k++) {
        if (references[k] != TIME) continue;
        Face *face = instance;
        size_t before = 0;
        for (size_t i = 0; i < k; i++) before += core_extent(references[i]);
        if (before >= value_count) return refuse(face, "value reference %u: there are not enough values", TIME);
        if (fmi3GetFloat64(face, references, k, values, before) != fmi3OK) return fmi3Error;
        values[before++] = core_time(face->column);
        return fmi3GetFloat64(face, references + k + 1, count - k - 1, values + before, value_count - before);
    }
    WRITE_OUT;
    return (fmi3Status)core_get_reals(face->column, face->list, elements, values);
}

FMI3_Export fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                      const fmi3Float64 values[], size_t value_count) {
    WRITE_OUT;
    if (face->reads) return refuse(face, "value reference %u: no set is requested here within a step", references[0]);
    return (fmi3Status)core_set_reals(face->column, face->list, elements, values);
}

#define GIVEN_TO(own) const fmi3ValueReference references[], size_t count, own values[], size_t value_count
#define BEGIN WRITE_OUT
#define LIST face->list
#define ELEMENTS elements

GETTER(Int64, INTEGER, core_whole) /* enumerations, too */
GETTER(Boolean, BOOLEAN, !!core_whole)
GETTER(String, STRING, core_text)
SETTERS(Int64)

FMI3_Export fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference references[], size_t count,
                                     const fmi3String values[], size_t value_count) {
    WRITE_OUT;
    return (fmi3Status)core_set_texts(face->column, face->list, elements, values);
}

/* --- steps */

/* The followed inputs keep the values that their lines led to. */
static void keep_last(Face *face) {
    for (size_t k = 0; k < face->followed; k++) {
        core_put_real(face->column, face->inputs[k], face->last[k]);
        core_put_real(face->column, face->slopes[k], 0.0);
    }
}

/* One piece of a step, up to `end`, `past` s after the step began: the importer is asked for the followed inputs at its
   end, which a line leads to and which they keep. The others continue by their slopes. */
static Status piece(Face *face, double start, double width, double end, double past) {
    bool early = false;
    double when = end;
    if (core_get_reals(face->column, face->inputs, face->followed, face->first) != ST_OK) return ST_ERROR;
    face->update(face->environment, end, true, false, false, false, &early, &when);
    if (core_get_reals(face->column, face->inputs, face->followed, face->last) != ST_OK) return ST_ERROR;
    for (size_t k = 0; k < face->followed; k++) {
        if (!isfinite(face->last[k])) face->first[k] = face->last[k]; /* the input is refused, not its slope */
        face->line[k] = isfinite(face->last[k]) ? (face->last[k] - face->first[k]) / width : 0.0;
    }
    if (core_set_reals(face->column, face->inputs, face->followed, face->first) != ST_OK ||
        core_set_reals(face->column, face->slopes, face->followed, face->line) != ST_OK)
        return ST_ERROR;
    Status status = core_step(face->column, start, width);
    if (status != ST_OK) return status;
    core_continue_inputs(face->column, face->set, past);
    keep_last(face);
    face->reads = true;
    face->update(face->environment, end, false, true, true, false, &early, &when);
    face->reads = false;
    return ST_OK;
}

/* A step in pieces no longer than the samples of a motion usually are. After it the inputs that are not followed are as
   they were set, as after a step in one; on a fault the column is as before. */
static Status followed_step(Face *face, double start, double step) {
    if (core_can_step(face->column, start, step) != ST_OK) return ST_ERROR;
    double pieces = fmax(1.0, ceil(step / core_usual_step - 1e-6));
    Saved *before = NULL;
    Status status = core_save(face->column, &before);
    core_take_inputs(face->column, face->set);
    for (double k = 0.0; k < pieces && status == ST_OK; k += 1.0) {
        double begin = start + k / pieces * step;
        double end = k + 1.0 < pieces ? start + (k + 1.0) / pieces * step : start + step;
        status = piece(face, begin, pieces > 1.0 ? end - begin : step, end, end - start);
    }
    if (status == ST_OK) {
        core_keep_inputs(face->column, face->set, start);
        keep_last(face);
    }
    if (status != ST_OK && before) core_restore(face->column, before);
    core_release(before);
    return status;
}

FMI3_Export fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 start, fmi3Float64 step, fmi3Boolean no_return,
                                  fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                                  fmi3Float64 *last_time) {
    Face *face = instance;
    (void)no_return;
    if (!face) return fmi3Error;
    Status status = face->followed ? followed_step(face, start, step) : core_step(face->column, start, step);
    if (event) *event = false;
    if (terminate) *terminate = false;
    if (early) *early = false;
    if (last_time) *last_time = core_time(face->column);
    return (fmi3Status)status;
}

/* --- derivatives */

FMI3_Export fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[],
                                                size_t count, const fmi3Int32 orders[], fmi3Float64 values[],
                                                size_t value_count) {
    Face *face = instance;
    if (!face || !core_has(face->column, references, count, "value references") ||
        !core_has(face->column, orders, count, "orders") || !core_has(face->column, values, value_count, "values"))
        return fmi3Error;
    for (size_t k = 0, at = 0; k < count; k++) { /* one order for each variable, whatever its size */
        size_t extent = core_extent(references[k]);
        if (!extent || at + extent > value_count)
            return refuse(face, "value reference %u: is none, or there are not enough values", references[k]);
        for (size_t i = 0; i < extent; i++, at++) {
            Reference element = references[k] + (Reference)i;
            if (core_rates(face->column, &element, 1, &orders[k], &values[at]) != ST_OK) return fmi3Error;
        }
    }
    return fmi3OK;
}

FMI3_Export fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                                    size_t unknown_count, const fmi3ValueReference knowns[],
                                                    size_t known_count, const fmi3Float64 seeds[], size_t seed_count,
                                                    fmi3Float64 values[], size_t value_count) {
    Face *face = instance;
    if (!face) return fmi3Error;
    if (!core_has(face->column, unknowns, unknown_count, "value references") ||
        !core_has(face->column, values, value_count, "values"))
        return fmi3Error;
    if (!core_has(face->column, knowns, known_count, "value references") ||
        !core_has(face->column, seeds, seed_count, "seeds"))
        return fmi3Error;
    /* the elements of both: of the inputs in the second half of the list */
    size_t inputs = written_out(face, knowns, known_count, seed_count);
    if (!inputs && (known_count || seed_count)) return fmi3Error;
    Reference *along = face->list + core_most();
    memcpy(along, face->list, inputs * sizeof *along);
    size_t elements = written_out(face, unknowns, unknown_count, value_count);
    if (!elements) return fmi3Error;
    return (fmi3Status)core_directional(face->column, face->list, elements, along, inputs, seeds, values);
}

/* --- calls of the standard that the model description rules out */

#pragma GCC diagnostic ignored "-Wunused-parameter"

static fmi3Status not_offered(fmi3Instance instance, const char *call) {
    const Face *face = instance;
    if (face) core_say(face->column, ST_ERROR, "%s: is not offered", call);
    return fmi3Error;
}

#define NOT_OFFERED(name, ...)                                                                                         \
    FMI3_Export fmi3Status name(fmi3Instance instance, __VA_ARGS__) { return not_offered(instance, #name); }
#define NO_MODE(name)                                                                                                  \
    FMI3_Export fmi3Status name(fmi3Instance instance) { return not_offered(instance, #name); }
#define REFERENCES const fmi3ValueReference references[], size_t count
#define NO_KIND(kind)                                                                                                  \
    NOT_OFFERED(fmi3Get##kind, REFERENCES, fmi3##kind values[], size_t value_count)                                    \
    NOT_OFFERED(fmi3Set##kind, REFERENCES, const fmi3##kind values[], size_t value_count)

NO_KIND(Float32) NO_KIND(Int8) NO_KIND(UInt8) NO_KIND(Int16) NO_KIND(UInt16) NO_KIND(Int32) NO_KIND(UInt32)
NO_KIND(UInt64)
NOT_OFFERED(fmi3GetBinary, REFERENCES, size_t sizes[], fmi3Binary values[], size_t value_count)
NOT_OFFERED(fmi3SetBinary, REFERENCES, const size_t sizes[], const fmi3Binary values[], size_t value_count)
NOT_OFFERED(fmi3GetClock, REFERENCES, fmi3Clock values[])
NOT_OFFERED(fmi3SetClock, REFERENCES, const fmi3Clock values[])

NOT_OFFERED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference reference, size_t *count)
NOT_OFFERED(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t elements[], fmi3ValueReference others[],
            size_t other_elements[], fmi3DependencyKind kinds[], size_t count)
NOT_OFFERED(fmi3GetAdjointDerivative, REFERENCES, const fmi3ValueReference knowns[], size_t known_count,
            const fmi3Float64 seeds[], size_t seed_count, fmi3Float64 values[], size_t value_count)

NO_MODE(fmi3EnterEventMode) NO_MODE(fmi3EnterConfigurationMode) NO_MODE(fmi3ExitConfigurationMode)
NO_MODE(fmi3EvaluateDiscreteStates) NO_MODE(fmi3EnterContinuousTimeMode) NO_MODE(fmi3EnterStepMode)
NOT_OFFERED(fmi3GetIntervalDecimal, REFERENCES, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
NOT_OFFERED(fmi3GetIntervalFraction, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
            fmi3IntervalQualifier qualifiers[])
NOT_OFFERED(fmi3GetShiftDecimal, REFERENCES, fmi3Float64 shifts[])
NOT_OFFERED(fmi3GetShiftFraction, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
NOT_OFFERED(fmi3SetIntervalDecimal, REFERENCES, const fmi3Float64 intervals[])
NOT_OFFERED(fmi3SetIntervalFraction, REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_OFFERED(fmi3SetShiftDecimal, REFERENCES, const fmi3Float64 shifts[])
NOT_OFFERED(fmi3SetShiftFraction, REFERENCES, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOT_OFFERED(fmi3UpdateDiscreteStates, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
            fmi3Boolean *values_changed, fmi3Boolean *event_defined, fmi3Float64 *event_time)
NOT_OFFERED(fmi3CompletedIntegratorStep, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate)
NOT_OFFERED(fmi3SetTime, fmi3Float64 time)
NOT_OFFERED(fmi3SetContinuousStates, const fmi3Float64 states[], size_t count)
NOT_OFFERED(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t count)
NOT_OFFERED(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t count)
NOT_OFFERED(fmi3GetContinuousStates, fmi3Float64 states[], size_t count)
NOT_OFFERED(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t count)
NOT_OFFERED(fmi3GetNumberOfEventIndicators, size_t *count)
NOT_OFFERED(fmi3GetNumberOfContinuousStates, size_t *count)
NOT_OFFERED(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)

FMI3_Export fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging,
                                                      fmi3InstanceEnvironment environment,
                                                      fmi3LogMessageCallback logger) {
    if (logger) logger(environment, fmi3Error, "logStatusError", "is for co-simulation only");
    return NULL;
}

FMI3_Export fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, fmi3ClockUpdateCallback clock,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    if (logger) logger(environment, fmi3Error, "logStatusError", "is for co-simulation only");
    return NULL;
}
