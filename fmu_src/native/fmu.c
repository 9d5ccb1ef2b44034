/* FMI 2.0 for co-simulation around the kernels: life of an instance, legal calls, messages, state. No numerics.

   table.h holds what differs from one FMU to another. A kernel is called as numba compiles it: it leaves its result
   behind the first pointer; the second is for exceptions, which kernels do not have. */

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

typedef enum { REAL, INTEGER, BOOLEAN, STRING } Kind;
typedef enum { INPUT, OUTPUT, PARAMETER } Role;
typedef struct { const char *name, *unit; Kind kind; Role role; int tunable, place; } Variable;
enum { MOST_WORDS = 8 }; /* of a choice; table.h makes sure */
typedef struct { int reference, count; const char *words[MOST_WORDS]; int codes[MOST_WORDS]; } Choice;
typedef struct {
    int reference;
    double low, high;
    int optional; /* 0 stands for "not given" */
    const char *meaning;
    int bound, strict; /* another variable that is not to be exceeded, or has to be larger */
    const char *relation;
} Check;
typedef struct { int code; const char *text; } Reason;

#include "table.h"

#define FORMULATION (&choices[0])
#define INTEGRATOR (&choices[1])
#define WITHOUT (&choices[2])
enum { SETTINGS = 6, GIVEN_FORMULATION = 3, GIVEN_INTEGRATOR = 4, GIVEN_WITHOUT = 5 };
#define TIME_SLACK 1e-6 /* of a step: how far a communication point may be from where the last step ended */
#define STEP_SLACK 1e-6 /* of a sampling interval: a step that is no longer than that but for rounding */
enum { MESSAGE = 1024, NUMBER = 32, HEADER = 96 };

/* --- kernels */

#define COLUMN_ARRAYS int64_t, double *, double *, int64_t *, double *, double *
#define RECORD_ARRAYS int64_t, const double *, const double *, const double *, double, double
int kernel_assemble(int64_t *, void **, int64_t, const double *, int64_t, double *, double *, int64_t *, double *,
                    double *, double *, double *);
int kernel_follow(int64_t *, void **, COLUMN_ARRAYS, const double *, double, double, RECORD_ARRAYS, double *);
int kernel_look(int64_t *, void **, COLUMN_ARRAYS, const double *, int64_t, int64_t, double, double, RECORD_ARRAYS,
                double *, double *);
int kernel_rates(int64_t *, void **, COLUMN_ARRAYS, double, double *, double *, double *, double *);
int kernel_feedthrough(int64_t *, void **, COLUMN_ARRAYS, const double *, double, double, double *, double *, double *,
                       double *);

/* --- an instance: one block of memory */

typedef enum { INSTANTIATED = 1, INITIALIZATION = 2, STEPPING = 4, TERMINATED = 8 } Mode;

/* All that differs from one moment to another: getting, setting and serializing the state copies it as it is. */
typedef struct {
    int64_t mode;
    int64_t built; /* whether model and motion belong to the parameters as they stand */
    int64_t started; /* whether there is a model at all */
    int64_t retune; /* whether a tunable parameter was set and has not acted yet */
    int64_t inputs_stand; /* whether the inputs are those of the last step */
    int64_t shaken; /* whether the base has moved yet */
    int64_t overturn_joint;
    int64_t has_record;
    double time, input_time, scale; /* s, s from which the slopes of the inputs count, factor on the record */
    double reals[REALS];
    char texts[TEXTS][TEXT];
    double inputs[SOLVER_INPUTS];
    double state[STATE];
    int64_t counters[COUNTERS];
    double model[MODEL];
} Moment;

typedef struct {
    Moment now;
    Moment before; /* to go back to */
    double work[WORK], row[ROW], split[SPLIT], other_row[ROW], other_split[SPLIT], told[2];
    int outdated; /* whether the outputs belong to an earlier time, input or parameter */
    int coarse_told, logging;
    fmi2Status last_step;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[TEXT];
} Instance;

typedef struct { const char *owner; Moment moment; } Saved;

#define COLUMN(i) N, (i)->now.model, (i)->now.state, (i)->now.counters, (i)->now.inputs, (i)->work
#define RECORD(i) (i)->now.has_record ? SAMPLES : 0, record_time, record_ax, record_az, record_dt, (i)->now.scale

static const char *mode_name(int64_t mode) {
    switch (mode) {
        case INSTANTIATED: return "instantiated";
        case INITIALIZATION: return "initialization";
        case STEPPING: return "stepping";
        default: return "terminated";
    }
}

/* --- what is said */

static void say(Instance *instance, fmi2Status status, const char *format, ...) {
    static const char *const categories[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                             "logStatusFatal", "logAll"};
    char text[MESSAGE], escaped[2 * MESSAGE];
    va_list arguments;
    if (!instance->logger || (status == fmi2OK && !instance->logging)) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    size_t length = 0;
    for (const char *at = text; *at; at++) { /* the host's logger takes it for a format */
        if (*at == '%') escaped[length++] = '%';
        escaped[length++] = *at;
    }
    escaped[length] = 0;
    instance->logger(instance->environment, instance->name, status, categories[status], escaped);
}

/* The shortest decimal that is read as the same number, as Python writes it. */
static const char *shown(double value, char *text) {
    char digits[NUMBER];
    if (isnan(value)) return strcpy(text, "nan");
    if (isinf(value)) return strcpy(text, value > 0.0 ? "inf" : "-inf");
    int precision = 0;
    do snprintf(digits, sizeof digits, "%.*e", precision, value);
    while (strtod(digits, NULL) != value && ++precision < 17);
    char *tail = strchr(digits, 'e');
    int exponent = atoi(tail + 1);
    if (exponent < -4 || exponent >= 16) {
        int size = (int)(tail - digits);
        snprintf(text, NUMBER, "%.*se%c%02d", size, digits, exponent < 0 ? '-' : '+', abs(exponent));
    } else {
        int decimals = precision - exponent;
        snprintf(text, NUMBER, "%.*f", decimals < 1 ? 1 : decimals, value);
    }
    for (char *at = text; *at; at++)
        if (*at == ',') *at = '.'; /* the host's locale */
    return text;
}

static const char *reason_of(int64_t code) {
    for (size_t k = 0; k < sizeof reasons / sizeof *reasons; k++)
        if (reasons[k].code == code) return reasons[k].text;
    return "unknown";
}

/* --- parameters */

static const char *trimmed(const char *begin, const char *end, size_t *length) {
    while (begin < end && (*begin == ' ' || *begin == '\t')) begin++;
    while (end > begin && (end[-1] == ' ' || end[-1] == '\t')) end--;
    *length = (size_t)(end - begin);
    return begin;
}

static int code_of(const Choice *choice, const char *word, size_t length) {
    for (int k = 0; k < choice->count; k++)
        if (strlen(choice->words[k]) == length && !memcmp(choice->words[k], word, length)) return choice->codes[k];
    return -1;
}

static void describe_choice(const Choice *choice, const char *word, size_t length, char *reason) {
    int used = snprintf(reason, MESSAGE, "%s = '%.*s': must be one of ", variables[choice->reference].name,
                        (int)length, word);
    for (int k = 0; k < choice->count; k++)
        used += snprintf(reason + used, (size_t)(MESSAGE - used), "%s%s", k ? ", " : "", choice->words[k]);
}

static double real_of(const double *reals, int reference) { return reals[variables[reference].place]; }

static const char *text_of(const Moment *moment, int reference) { return moment->texts[variables[reference].place]; }

/* Whether one of these checks finds fault with a Real parameter. */
static int find_fault(const double *reals, size_t from, size_t to, char *reason) {
    char value[NUMBER], bound[NUMBER];
    for (size_t k = from; k < to; k++) {
        const Check *check = &checks[k];
        double given_value = real_of(reals, check->reference);
        const char *name = variables[check->reference].name;
        if (check->optional && given_value == 0.0) continue;
        if (!(check->low <= given_value && given_value <= check->high)) {
            snprintf(reason, MESSAGE, "%s = %s: %s", name, shown(given_value, value), check->meaning);
            return 1;
        }
        if (check->bound < 0) continue;
        double most = real_of(reals, check->bound);
        if (check->strict ? !(given_value < most) : given_value > most) {
            snprintf(reason, MESSAGE, "%s = %s: %s = %s m", name, shown(given_value, value), check->relation,
                     shown(most, bound));
            return 1;
        }
    }
    return 0;
}

/* Model, and with `afresh` motion, from the parameters as they stand. On a fault both are as before. */
static int build(Instance *instance, int afresh, char *reason) {
    Moment *now = &instance->now;
    size_t count = sizeof checks / sizeof *checks;
    double described[GIVEN];
    const char *formulation = text_of(now, FORMULATION->reference), *integrator = text_of(now, INTEGRATOR->reference);
    const char *without = text_of(now, WITHOUT->reference), *record = now->texts[AT_RECORD];
    char text[NUMBER];
    for (int k = 0; k < GIVEN; k++)
        described[k] = k >= SETTINGS || k < GIVEN_FORMULATION ? now->reals[given[k]] : 0.0;
    if (find_fault(now->reals, 0, count - 2, reason)) return 0;
    int code = code_of(FORMULATION, formulation, strlen(formulation));
    if (code < 0) return describe_choice(FORMULATION, formulation, strlen(formulation), reason), 0;
    described[GIVEN_FORMULATION] = code;
    code = code_of(INTEGRATOR, integrator, strlen(integrator));
    if (code < 0) return describe_choice(INTEGRATOR, integrator, strlen(integrator), reason), 0;
    described[GIVEN_INTEGRATOR] = code;
    int fixed_step = code == CENTRAL_DIFFERENCE;
    if (find_fault(now->reals, count - 2, count, reason)) return 0;
    int left_out = 0;
    for (const char *at = without; *at;) {
        const char *end = strchr(at, ',');
        size_t length;
        if (!end) end = at + strlen(at);
        const char *word = trimmed(at, end, &length);
        code = length ? code_of(WITHOUT, word, length) : 0;
        if (code < 0) return describe_choice(WITHOUT, word, length, reason), 0;
        left_out |= code;
        at = *end ? end + 1 : end;
    }
    described[GIVEN_WITHOUT] = left_out;
    int has_record = *record != 0;
    double scale = now->reals[AT_RECORD_SCALE];
    if (!isfinite(scale)) {
        snprintf(reason, MESSAGE, "base.record_scale = %s: must be a finite number", shown(scale, text));
        return 0;
    }
    if (has_record && (!SAMPLES || strcmp(record, RECORD_NAME))) {
        snprintf(reason, MESSAGE,
                 "base.record = '%.600s': this FMU reads no files, must be empty%s%s; build_fmu.py --record puts a "
                 "record inside",
                 record, SAMPLES ? " or " : "", SAMPLES ? RECORD_NAME : "");
        return 0;
    }
    double *room = malloc(sizeof(double) * (size_t)(fixed_step ? FIXED_STEP_ROOM : ROOM));
    if (!room) return snprintf(reason, MESSAGE, "out of memory"), 0;
    memcpy(instance->before.model, now->model, sizeof now->model);
    int64_t made;
    void *exception;
    kernel_assemble(&made, &exception, N, described, afresh, now->model, now->state, now->counters, now->inputs,
                    instance->work, room, instance->told);
    free(room);
    if (made != 0) {
        memcpy(now->model, instance->before.model, sizeof now->model);
        if (made == TOO_LARGE)
            snprintf(reason, MESSAGE, "block[%d].inertia = inf: must be a positive moment of inertia in kg m2",
                     (int)instance->told[0]);
        else
            snprintf(reason, MESSAGE,
                     "solver.step = %s: must be at most %.4g s, where central differences are stable",
                     shown(described[1], text), instance->told[0]);
        return 0;
    }
    now->built = now->started = 1;
    now->retune = 0;
    if (afresh) {
        now->has_record = has_record;
        now->scale = scale;
        now->reals[AT_RECORD_PGA] = has_record ? fabs(scale) * record_pga : 0.0;
        now->reals[AT_OVERTURN_TIME] = -1.0;
        now->overturn_joint = 0;
        now->inputs_stand = 0;
    }
    instance->outdated = 1;
    return 1;
}

/* Bring the outputs up to date. */
static int update(Instance *instance, char *reason) {
    Moment *now = &instance->now;
    int64_t code;
    void *exception;
    if (now->mode == INSTANTIATED) {
        snprintf(reason, MESSAGE, "outputs can be read from initialization on");
        return 0;
    }
    if (now->mode == INITIALIZATION && !now->built && !build(instance, 1, reason)) return 0;
    if (!now->started || !instance->outdated) return 1;
    if (now->retune && !build(instance, 0, reason)) return 0;
    kernel_look(&code, &exception, COLUMN(instance), now->reals, !now->inputs_stand, now->mode == INITIALIZATION,
                now->time - now->input_time, now->time, RECORD(instance), &now->reals[BASE_INPUTS],
                &now->reals[AT_SPLIT]);
    if (code < 0) {
        snprintf(reason, MESSAGE, "at t = %.6g s: %s", now->time, reason_of(code));
        return 0;
    }
    now->overturn_joint = now->counters[COUNTER_OVERTURNED];
    now->reals[AT_OVERTURN_TIME] = now->overturn_joint ? now->state[STATE_OVERTURN_TIME] : -1.0;
    instance->outdated = 0;
    return 1;
}

/* --- legal calls */

static int wrong_mode(Instance *instance, int allowed, const char *what) {
    if (instance->now.mode & allowed) return 0;
    say(instance, fmi2Error, "%s: not in the state %s", what, mode_name(instance->now.mode));
    return 1;
}

static int known(Instance *instance, fmi2ValueReference reference, Kind kind) {
    static const char *const names[] = {"Real", "Integer", "Boolean", "String"};
    char time[NUMBER];
    if (reference < VARIABLES && variables[reference].kind == kind) return 1;
    say(instance, fmi2Error, "variables at t = %s s: value reference %u: is not that of a %s variable",
        shown(instance->now.time, time), reference, names[kind]);
    return 0;
}

static int readable(Instance *instance, const fmi2ValueReference references[], size_t count, Kind kind) {
    char reason[MESSAGE], time[NUMBER];
    int outputs = 0;
    for (size_t k = 0; k < count; k++) {
        fmi2ValueReference reference = references[k];
        if (!(reference < VARIABLES && variables[reference].kind == kind)) return known(instance, reference, kind);
        outputs |= variables[reference].role == OUTPUT;
    }
    if (!outputs || (!instance->outdated && instance->now.mode != INSTANTIATED) || update(instance, reason)) return 1;
    say(instance, fmi2Error, "variables at t = %s s: %s", shown(instance->now.time, time), reason);
    return 0;
}

static int settable(Instance *instance, const fmi2ValueReference references[], size_t count, Kind kind) {
    static const char *const names[] = {"Real", "Integer", "Boolean", "String"};
    if (instance->now.mode == TERMINATED) {
        say(instance, fmi2Error, "nothing can be set, the run is terminated");
        return 0;
    }
    for (size_t k = 0; k < count; k++) {
        fmi2ValueReference reference = references[k];
        if (!(reference < VARIABLES && variables[reference].kind == kind && variables[reference].role != OUTPUT)) {
            say(instance, fmi2Error, "value reference %u: is not an input or a parameter of the kind %s", reference,
                names[kind]);
            return 0;
        }
        const Variable *variable = &variables[reference];
        if (instance->now.mode == STEPPING && variable->role == PARAMETER && !variable->tunable) {
            say(instance, fmi2Error, "%s: can be set before the end of initialization only", variable->name);
            return 0;
        }
    }
    return 1;
}

static void has_changed(Instance *instance, int parameter) {
    Moment *now = &instance->now;
    if (parameter) {
        now->built = 0;
        now->retune = now->mode == STEPPING;
    }
    now->input_time = now->time;
    now->inputs_stand = 0;
    instance->outdated = 1;
}

/* --- life */

static void begin(Instance *instance) {
    Moment *now = &instance->now;
    memset(now, 0, sizeof *now);
    now->mode = INSTANTIATED;
    memcpy(now->reals, real_starts, sizeof now->reals);
    now->reals[AT_OVERTURN_TIME] = -1.0;
    for (int k = 0; k < TEXTS; k++) snprintf(now->texts[k], TEXT, "%s", text_starts[k]);
    instance->outdated = 1;
    instance->coarse_told = 0;
    instance->last_step = fmi2OK;
}

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    (void)resources, (void)visible;
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    snprintf(instance->name, TEXT, "%s", name ? name : "");
    instance->logger = functions ? functions->logger : NULL;
    instance->environment = functions ? functions->componentEnvironment : NULL;
    instance->logging = logging;
    const char *fault = NULL;
    if (!name || !*name) fault = "the instance needs a name";
    else if (type != fmi2CoSimulation) fault = "is for co-simulation only";
    else if (!guid || strcmp(guid, GUID)) fault = "the GUID is not that of this FMU: binary and model description differ";
    if (fault) {
        say(instance, fmi2Error, "%s", fault);
        free(instance);
        return NULL;
    }
    begin(instance);
    return instance;
}

FMI2_Export void fmi2FreeInstance(fmi2Component component) { free(component); }

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count,
                                           const fmi2String categories[]) {
    (void)count, (void)categories;
    if (!component) return fmi2Error;
    ((Instance *)component)->logging = on;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                           fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    Instance *instance = component;
    char text[NUMBER];
    (void)has_stop, (void)stop;
    if (!instance || wrong_mode(instance, INSTANTIATED, "the experiment can be set up after instantiation or reset only"))
        return fmi2Error;
    if (!isfinite(start)) {
        say(instance, fmi2Error, "start time = %s: must be a finite time in s", shown(start, text));
        return fmi2Error;
    }
    instance->now.time = instance->now.input_time = start;
    if (has_tolerance)
        say(instance, fmi2OK, "the experiment's tolerance, %s, is not used: solver.tolerance is the solver's",
            shown(tolerance, text));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
    Instance *instance = component;
    if (!instance || wrong_mode(instance, INSTANTIATED, "initialization can begin after instantiation or reset only"))
        return fmi2Error;
    instance->now.mode = INITIALIZATION;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    Instance *instance = component;
    char reason[MESSAGE];
    if (!instance || wrong_mode(instance, INITIALIZATION, "initialization can end after it has begun only"))
        return fmi2Error;
    if (!instance->now.built && !build(instance, 1, reason)) {
        say(instance, fmi2Error, "%s", reason);
        return fmi2Error;
    }
    instance->outdated = 1;
    instance->now.inputs_stand = 0;
    (void)update(instance, reason); /* stands on the base as it is turned now; a fault is told when somebody looks */
    instance->outdated = 1;
    instance->now.mode = STEPPING;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Terminate(fmi2Component component) {
    Instance *instance = component;
    if (!instance || wrong_mode(instance, STEPPING, "a run can be terminated after initialization only"))
        return fmi2Error;
    const Moment *now = &instance->now;
    if (!now->shaken && now->state[STATE_TIME_FULL] + now->state[STATE_TIME_ROCKING] + now->state[STATE_TIME_FLIGHT] > 0.0)
        say(instance, fmi2Warning, "the base acceleration was zero for the whole run: is the input connected?");
    instance->now.mode = TERMINATED;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Reset(fmi2Component component) {
    if (!component) return fmi2Error;
    begin(component);
    return fmi2OK;
}

/* --- variables */

FMI2_Export fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                   fmi2Real values[]) {
    Instance *instance = component;
    if (!instance || !readable(instance, references, count, REAL)) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = real_of(instance->now.reals, (int)references[k]);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      fmi2Integer values[]) {
    Instance *instance = component;
    if (!instance || !readable(instance, references, count, INTEGER)) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = (fmi2Integer)instance->now.overturn_joint;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      fmi2Boolean values[]) {
    Instance *instance = component;
    if (!instance || !readable(instance, references, count, BOOLEAN)) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = instance->now.overturn_joint > 0;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                     fmi2String values[]) {
    Instance *instance = component;
    if (!instance || !readable(instance, references, count, STRING)) return fmi2Error;
    for (size_t k = 0; k < count; k++) values[k] = text_of(&instance->now, (int)references[k]);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                   const fmi2Real values[]) {
    Instance *instance = component;
    int parameter = 0;
    if (!instance || !settable(instance, references, count, REAL)) return fmi2Error;
    for (size_t k = 0; k < count; k++) {
        instance->now.reals[variables[references[k]].place] = values[k];
        parameter |= variables[references[k]].role == PARAMETER;
    }
    has_changed(instance, parameter);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      const fmi2Integer values[]) {
    (void)values;
    return component && settable(component, references, count, INTEGER) ? fmi2OK : fmi2Error;
}

FMI2_Export fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                      const fmi2Boolean values[]) {
    (void)values;
    return component && settable(component, references, count, BOOLEAN) ? fmi2OK : fmi2Error;
}

FMI2_Export fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                     const fmi2String values[]) {
    Instance *instance = component;
    if (!instance || !settable(instance, references, count, STRING)) return fmi2Error;
    for (size_t k = 0; k < count; k++)
        if (!values[k] || strlen(values[k]) >= TEXT) {
            say(instance, fmi2Error, "%s: must be a text of less than %d bytes", variables[references[k]].name, TEXT);
            return fmi2Error;
        }
    for (size_t k = 0; k < count; k++) strcpy(instance->now.texts[variables[references[k]].place], values[k]);
    has_changed(instance, count > 0);
    return fmi2OK;
}

/* --- steps */

static int step_problem(Instance *instance, double start, double step, char *reason) {
    const Moment *now = &instance->now;
    char text[NUMBER];
    if (now->mode != STEPPING) {
        const char *fault = now->mode == TERMINATED ? "the run is terminated" : "the slave is not initialized";
        return snprintf(reason, MESSAGE, "%s", fault), 1;
    }
    if (!(isfinite(step) && step > 0.0)) return snprintf(reason, MESSAGE, "the step must be a positive time"), 1;
    if (!(fabs(start - now->time) <= TIME_SLACK * step + 1e-12 * fabs(now->time)))
        return snprintf(reason, MESSAGE, "the last step ended at t = %s s", shown(now->time, text)), 1;
    for (int k = 0; k < BASE_INPUTS; k++)
        if (!isfinite(now->reals[k]))
            return snprintf(reason, MESSAGE, "%s = %s: must be a finite number in %s",
                            variables[input_references[k]].name, shown(now->reals[k], text),
                            variables[input_references[k]].unit), 1;
    return 0;
}

static int advance(Instance *instance, double start, double step, char *reason) {
    Moment *now = &instance->now;
    int64_t code;
    void *exception;
    memcpy(instance->before.state, now->state, sizeof now->state);
    memcpy(instance->before.counters, now->counters, sizeof now->counters);
    if (now->retune && !build(instance, 0, reason)) return 0;
    now->input_time = start;
    kernel_follow(&code, &exception, COLUMN(instance), now->reals, start, step, RECORD(instance), instance->told);
    if (code < 0) {
        memcpy(now->state, instance->before.state, sizeof now->state);
        memcpy(now->counters, instance->before.counters, sizeof now->counters);
        now->inputs_stand = 0;
        instance->outdated = 1;
        snprintf(reason, MESSAGE, "at t = %.6g s: %s", instance->told[0], reason_of(code));
        return 0;
    }
    now->time = start + step;
    now->inputs_stand = instance->outdated = 1;
    if (!now->shaken) {
        now->shaken = now->has_record;
        for (int k = 0; k < BASE_INPUTS; k++) now->shaken |= now->reals[k] != 0.0;
    }
    if (now->has_record && !instance->coarse_told && step > record_dt * (1.0 + STEP_SLACK)) {
        char text[NUMBER];
        instance->coarse_told = 1;
        say(instance, fmi2Warning,
            "communication step = %s s, the record's is %.6g s: the motion is followed sample by sample, but the "
            "outputs show it at the communication points only",
            shown(step, text), record_dt);
    }
    return 1;
}

FMI2_Export fmi2Status fmi2DoStep(fmi2Component component, fmi2Real start, fmi2Real step, fmi2Boolean no_return) {
    Instance *instance = component;
    char reason[MESSAGE], first[NUMBER], second[NUMBER];
    (void)no_return;
    if (!instance) return fmi2Error;
    instance->last_step = fmi2OK;
    if (step_problem(instance, start, step, reason) || !advance(instance, start, step, reason)) {
        say(instance, fmi2Discard, "step from t = %s s of %s s not made: %s", shown(start, first), shown(step, second),
            reason);
        instance->last_step = fmi2Discard;
    }
    return instance->last_step;
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component component) {
    if (component) say(component, fmi2Error, "no step can be cancelled: every step is finished when fmi2DoStep returns");
    return fmi2Error;
}

static fmi2Status no_status(Instance *instance, int kind) {
    if (instance) say(instance, fmi2Discard, "status %d: is not known of this kind", kind);
    return instance ? fmi2Discard : fmi2Error;
}

FMI2_Export fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value) {
    if (!component || kind != fmi2DoStepStatus) return no_status(component, kind);
    *value = ((Instance *)component)->last_step;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value) {
    if (!component || kind != fmi2LastSuccessfulTime) return no_status(component, kind);
    *value = ((Instance *)component)->now.time;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)value;
    return no_status(component, kind);
}

FMI2_Export fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value) {
    if (!component || kind != fmi2Terminated) return no_status(component, kind);
    *value = fmi2False; /* the slave never asks for the end of the run */
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind, fmi2String *value) {
    if (!component || kind != fmi2PendingStatus) return no_status(component, kind);
    *value = "";
    return fmi2OK;
}

/* --- derivatives */

FMI2_Export fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                                   size_t count, const fmi2Integer orders[], const fmi2Real values[]) {
    Instance *instance = component;
    if (!instance || !settable(instance, references, count, REAL)) return fmi2Error;
    for (size_t k = 0; k < count; k++) {
        fmi2ValueReference reference = references[k];
        const char *name = variables[reference].name;
        if (variables[reference].role != INPUT) {
            say(instance, fmi2Error, "%s: is not an input", name);
            return fmi2Error;
        }
        if (orders[k] != 1) {
            say(instance, fmi2Error, "derivative of %s of the order %d: must be of the order 1", name, orders[k]);
            return fmi2Error;
        }
        if (slope_of[variables[reference].place] < 0 && values[k] != 0.0) {
            say(instance, fmi2Error, "%s: is held within a step, its derivative must be 0", name);
            return fmi2Error;
        }
    }
    for (size_t k = 0; k < count; k++) {
        int slope = slope_of[variables[references[k]].place];
        if (slope >= 0) instance->now.reals[slope] = values[k];
    }
    has_changed(instance, 0);
    return fmi2OK;
}

/* Where row or split hold what belongs to an output that follows the motion; NULL for other variables. */
static const double *visible(const Instance *instance, fmi2ValueReference reference) {
    if (reference >= VARIABLES || variables[reference].kind != REAL) return NULL;
    int place = variables[reference].place;
    if (BASE_INPUTS <= place && place < BASE_INPUTS + ROW) return &instance->row[place - BASE_INPUTS];
    if (AT_SPLIT <= place && place < AT_SPLIT + SPLIT) return &instance->split[place - AT_SPLIT];
    return NULL;
}

static int is_continuous_output(Instance *instance, fmi2ValueReference reference) {
    if (visible(instance, reference)) return 1;
    say(instance, fmi2Error, "value reference %u: is not that of a continuous output", reference);
    return 0;
}

FMI2_Export fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                                    size_t count, const fmi2Integer orders[], fmi2Real values[]) {
    Instance *instance = component;
    char reason[MESSAGE];
    int64_t code;
    void *exception;
    if (!instance || wrong_mode(instance, INITIALIZATION | STEPPING | TERMINATED, "derivatives of outputs"))
        return fmi2Error;
    for (size_t k = 0; k < count; k++) {
        if (!is_continuous_output(instance, references[k])) return fmi2Error;
        if (orders[k] != 1) {
            say(instance, fmi2Error, "derivative of %s of the order %d: must be of the order 1",
                variables[references[k]].name, orders[k]);
            return fmi2Error;
        }
    }
    if (!update(instance, reason)) {
        say(instance, fmi2Error, "%s", reason);
        return fmi2Error;
    }
    kernel_rates(&code, &exception, COLUMN(instance), instance->now.time, instance->row, instance->split,
                 instance->other_row, instance->other_split);
    for (size_t k = 0; k < count; k++) values[k] = *visible(instance, references[k]);
    return code < 0 ? fmi2Error : fmi2OK;
}

FMI2_Export fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[],
                                                    size_t unknown_count, const fmi2ValueReference knowns[],
                                                    size_t known_count, const fmi2Real seeds[], fmi2Real values[]) {
    Instance *instance = component;
    char reason[MESSAGE];
    double along[BASE_INPUTS] = {0.0};
    int64_t code;
    void *exception;
    if (!instance || wrong_mode(instance, INITIALIZATION | STEPPING | TERMINATED, "directional derivatives"))
        return fmi2Error;
    const Moment *now = &instance->now;
    for (size_t k = 0; k < unknown_count; k++)
        if (!is_continuous_output(instance, unknowns[k])) return fmi2Error;
    for (size_t k = 0; k < known_count; k++) {
        if (knowns[k] >= VARIABLES || variables[knowns[k]].role != INPUT) {
            say(instance, fmi2Error, "value reference %u: is not that of an input", knowns[k]);
            return fmi2Error;
        }
        along[variables[knowns[k]].place] += seeds[k];
    }
    if (!update(instance, reason)) {
        say(instance, fmi2Error, "%s", reason);
        return fmi2Error;
    }
    kernel_feedthrough(&code, &exception, COLUMN(instance), along, now->time - now->input_time, now->time, instance->row,
                       instance->split, instance->other_row, instance->other_split);
    for (size_t k = 0; k < unknown_count; k++) values[k] = *visible(instance, unknowns[k]);
    return code < 0 ? fmi2Error : fmi2OK;
}

/* --- state */

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state) {
    Instance *instance = component;
    if (!instance || !state) return fmi2Error;
    Saved *saved = *state;
    if (!saved && !(saved = malloc(sizeof *saved))) {
        say(instance, fmi2Error, "out of memory");
        return fmi2Error;
    }
    saved->owner = GUID;
    memcpy(&saved->moment, &instance->now, sizeof saved->moment);
    *state = saved;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
    Instance *instance = component;
    const Saved *saved = state;
    if (!instance) return fmi2Error;
    if (!saved || saved->owner != GUID) {
        say(instance, fmi2Error, "the state cannot be set: it is not one of this FMU");
        return fmi2Error;
    }
    /* what the modal method keeps in work follows from the model */
    if (memcmp(instance->now.model, saved->moment.model, sizeof saved->moment.model))
        memset(instance->work, 0, sizeof instance->work);
    memcpy(&instance->now, &saved->moment, sizeof saved->moment);
    instance->outdated = 1;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state) {
    if (!component) return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

/* Bytes: format, whose it is and a checksum in text, then the moment as it is. */
static uint64_t checksum(const void *data, size_t size) { /* FNV-1a */
    const unsigned char *at = data;
    uint64_t hash = 14695981039346656037u;
    for (size_t k = 0; k < size; k++) hash = (hash ^ at[k]) * 1099511628211u;
    return hash;
}

static void write_header(char *header, const Moment *moment) {
    memset(header, 0, HEADER);
    snprintf(header, HEADER, "%s\n%s\n%016llx", STATE_FORMAT, GUID,
             (unsigned long long)checksum(moment, sizeof *moment));
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size) {
    if (!component || !state) return fmi2Error;
    *size = HEADER + sizeof(Moment);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                             size_t size) {
    const Saved *saved = state;
    if (!component || !saved || size < HEADER + sizeof(Moment)) return fmi2Error;
    write_header(bytes, &saved->moment);
    memcpy(bytes + HEADER, &saved->moment, sizeof(Moment));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *state) {
    Instance *instance = component;
    char header[HEADER];
    const char *fault = NULL;
    if (!instance || !state || !bytes) return fmi2Error;
    size_t format = strlen(STATE_FORMAT), guid = strlen(GUID);
    if (size < HEADER || memcmp(bytes, STATE_FORMAT, format))
        fault = "the bytes are not those of a serialized state of this format";
    else if (memcmp(bytes + format + 1, GUID, guid))
        fault = "the state is that of another column or was made by another version";
    else if (size != HEADER + sizeof(Moment))
        fault = "the bytes are not all of those of a serialized state";
    Saved *saved = fault ? NULL : malloc(sizeof *saved);
    if (saved) {
        saved->owner = GUID;
        memcpy(&saved->moment, bytes + HEADER, sizeof(Moment));
        write_header(header, &saved->moment);
        if (memcmp(header, bytes, HEADER)) {
            fault = "the bytes of the serialized state are damaged";
            free(saved);
        }
    } else if (!fault) {
        fault = "out of memory";
    }
    if (fault) {
        say(instance, fmi2Error, "the state cannot be set: %s", fault);
        return fmi2Error;
    }
    *state = saved;
    return fmi2OK;
}
