/* Around the kernels: life of an instance, legal calls, messages, state, the record inside. No numerics.

   The kernels are those of a column or structure, which may fall (FALLS), or of a body that a column is coupled with.
   contract.h declares the kernels and the constants of their tables, table.h holds the data of one FMU;
   both are generated (table.py). */

#include "core.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "contract.h"

typedef struct { const char *name, *unit; Kind kind; Role role; int tunable, place; } Variable;
typedef struct { int count; const int *rows; int is_array; } Family; /* rows of variables by their numbers within it */
typedef struct { Reference input, slope; } Line;
typedef struct { int code; const char *word; } Item;
typedef enum { ONE_WORD, ANY_WORDS } Way; /* how a choice is made */
typedef struct { int row, place; Way way; int count; const Item *items; } Choice; /* place: among what is given */
typedef struct {
    int row; /* of the parameter; -1: of a number that never changes */
    const char *name;
    double fixed, low, high;
    int optional; /* 0 stands for "not given" */
    const char *meaning;
    int bound, otherwise; /* another variable that is not to be exceeded; where that is 0 */
    int needs; /* another variable that may not be 0 */
    int strict; /* whether the bound has to be larger */
    const char *relation;
} Check;
typedef struct { int64_t code; const char *text; } Reason;
typedef struct { const char *name, *relation; } Misfit;
typedef struct { int count; double low, high; int whole, may_lack, of_inputs; } Range; /* of neighbours (state_ranges.py) */
typedef struct { int place, by_least; } Peak; /* in the state; by_least: the largest of 1 - value is kept */

#include "table.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
enum { MESSAGE = 1024, NUMBER = 32, HEADER = 96 };
enum { INPUT_ROOM = BASE_INPUTS + !BASE_INPUTS, SPLIT_ROOM = SPLIT + !SPLIT }; /* C knows no array of nothing */
_Static_assert(sizeof STATE_FORMAT + sizeof IDENTITY + 17 <= HEADER, "the head of a serialized state");
_Static_assert(COUNT(given) == GIVEN && COUNT(slope_of) == INPUT_ROOM, "what the kernels are given");
_Static_assert(COUNT(real_starts) == REALS && COUNT(whole_starts) == WHOLES && COUNT(text_starts) == TEXTS, "starts");
_Static_assert(AT_ROW + ROW == AT_SPLIT && AT_SPLIT + SPLIT <= REALS, "outputs begin with row and split");
_Static_assert(!FALLS || (AT_SPLIT + SPLIT == AT_PEAKS && AT_PEAKS + PEAKS <= REALS), "then peaks");

const char *const core_identity = IDENTITY;
const double core_usual_step = USUAL_STEP;

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
    int64_t has_record;
    int64_t tolerance_set; /* whether the host set the solver's tolerance: then that of the experiment does not count */
    double time, input_time, scale; /* s, s from which the slopes of the inputs count, factor on the record */
    double reals[REALS];
    int64_t wholes[WHOLES]; /* Integers, Booleans and enumerations */
    char texts[TEXTS][TEXT];
    double base[BASE];
    double state[STATE];
    int64_t counts[COUNTS];
    double model[MODEL];
} Moment;
_Static_assert(sizeof(Moment) == 8 * sizeof(int64_t) + 3 * sizeof(double) + sizeof(double) * (REALS + BASE + STATE + MODEL) +
                                     sizeof(int64_t) * (WHOLES + COUNTS) + TEXTS * TEXT,
               "is_possible and is_whole check every member of a moment: add a new one there, then here");

/* Whether an input alternates and grows, as fmu_src/alternation.py counts. */
typedef struct { double last, change, largest, before; int in_a_row; } Alternation;

struct Instance {
    Moment now;
    Moment before; /* to go back to */
    double work[WORK], row[ROW], split[SPLIT_ROOM], other_row[ROW], other_split[SPLIT_ROOM], detail[DETAILS];
    double described[GIVEN]; /* arguments of `assemble`: too long for the stack of a thread */
    double stop; /* s, where the experiment ends; it is no part of the state */
    int outdated; /* whether the outputs belong to an earlier time, input or parameter */
    int coarse_warned, unstable_warned, idle_warned, long_warned;
    int stepped; /* whether this instance has made a step */
    Alternation alternations[INPUT_ROOM];
    double watched; /* s, start of the last step that the alternations count */
    Status last_step;
    Teller *teller;
    void *host;
};

struct Saved { const char *owner; Moment moment; };

/* Arguments of the kernels by name: the arrays of a body, and the record. Those that a kernel does not take are unused. */
#define COLUMN(i)                                                                                                      \
    .n = N, .model = (i)->now.model, .state = (i)->now.state, .counts = (i)->now.counts,                               \
    .base = (i)->now.base, .work = (i)->work
#define RECORD(i)                                                                                                      \
    .times = record_time, .times_size = (i)->now.has_record ? SAMPLES : 0, .ax = record_ax, .ay = record_ay,           \
    .az = record_az, .scale = (i)->now.scale

static const char *mode_name(int64_t mode) {
    switch (mode) {
        case INSTANTIATED: return "instantiated";
        case INITIALIZATION: return "initialization";
        case STEPPING: return "stepping";
        default: return "terminated";
    }
}

static const char *kind_name(Kind kind) {
    static const char *const names[] = {[REAL] = "Real", [INTEGER] = "Integer", [BOOLEAN] = "Boolean",
                                        [STRING] = "String"};
    return names[kind];
}

/* --- messages */

Status core_say(const Instance *instance, Status status, const char *format, ...) {
    char text[MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    instance->teller(instance->host, status, text);
    return status;
}

/* Add to a text that may already be full. */
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
static void append(char *text, const char *format, ...) {
    size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + used, MESSAGE - used, format, arguments);
    va_end(arguments);
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
    for (size_t k = 0; k < COUNT(reasons); k++)
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

static double real_at(const Moment *moment, int row) { return moment->reals[variables[row].place]; }

/* The kernels' code of a word; -1 and a reason if it is unknown. */
static int code_of_word(const Choice *choice, const char *word, size_t length, char *reason) {
    for (int k = 0; k < choice->count; k++) {
        const Item *item = &choice->items[k];
        if (strlen(item->word) == length && !memcmp(item->word, word, length)) return item->code;
    }
    snprintf(reason, MESSAGE, "%s = '%.*s': must be one of ", variables[choice->row].name, (int)length, word);
    for (int k = 0; k < choice->count; k++) append(reason, "%s%s", k ? ", " : "", choice->items[k].word);
    return -1;
}

/* The sum of the kernels' codes of words with commas between; -1 and a reason if one is unknown. */
static int codes_of_words(const Choice *choice, const char *words, char *reason) {
    int codes = 0;
    for (const char *at = words; *at;) {
        const char *end = strchr(at, ',');
        size_t length;
        if (!end) end = at + strlen(at);
        const char *word = trimmed(at, end, &length);
        int code = length ? code_of_word(choice, word, length, reason) : 0;
        if (code < 0) return -1;
        codes |= code;
        at = *end ? end + 1 : end;
    }
    return codes;
}

/* The kernels' code of a choice; -1 and a reason if it cannot be. */
static int chosen(const Choice *choice, const Moment *moment, char *reason) {
    const char *words = moment->texts[variables[choice->row].place];
    return choice->way == ONE_WORD ? code_of_word(choice, words, strlen(words), reason)
                                   : codes_of_words(choice, words, reason);
}

/* Whether a check refuses a Real parameter. */
static int find_fault(const Moment *moment, char *reason) {
    char value[NUMBER], bound[NUMBER];
    for (int k = 0; k < CHECKS; k++) {
        const Check *check = &checks[k];
        double given_value = check->row < 0 ? check->fixed : real_at(moment, check->row);
        if (check->optional && given_value == 0.0) continue;
        if (!(check->low <= given_value && given_value <= check->high)) {
            snprintf(reason, MESSAGE, "%s = %s: %s", check->name, shown(given_value, value), check->meaning);
            return 1;
        }
        if (check->needs >= 0 && real_at(moment, check->needs) == 0.0) {
            snprintf(reason, MESSAGE, "%s = %s: %s", check->name, shown(given_value, value), check->relation);
            return 1;
        }
        if (check->bound < 0) continue;
        double most = real_at(moment, check->bound);
        if (most == 0.0 && check->otherwise >= 0) most = real_at(moment, check->otherwise);
        if (check->strict ? !(given_value < most) : given_value > most) {
            snprintf(reason, MESSAGE, "%s = %s: %s = %s m", check->name, shown(given_value, value), check->relation,
                     shown(most, bound));
            return 1;
        }
    }
    return 0;
}

/* Arguments of `assemble`, from the parameters as they stand. */
static int describe(const Moment *now, double described[GIVEN], char *reason) {
    for (int k = 0; k < GIVEN; k++) described[k] = given[k] < 0 ? given_fixed[k] : now->reals[given[k]];
    if (find_fault(now, reason)) return 0;
    for (int k = 0; k < CHOICES; k++) {
        int code = chosen(&choices[k], now, reason);
        if (code < 0) return 0;
        described[choices[k].place] = code;
    }
    return 1;
}

/* Model, and with `from_rest` motion, from the parameters as they stand. On a fault both are as before. */
static int build(Instance *instance, int from_rest, char *reason) {
    Moment *now = &instance->now;
    double *described = instance->described;
    char text[NUMBER];
    const char *record = now->texts[AT_RECORD];
    if (!describe(now, described, reason)) return 0;
    int has_record = HAS_RECORD && *record != 0;
    if (has_record && (!SAMPLES || strcmp(record, RECORD_NAME))) {
        snprintf(reason, MESSAGE,
                 RECORD_KEY " = '%.600s': this FMU reads no files, must be empty%s%s; build_fmu.py --record puts a "
                 "record inside",
                 record, SAMPLES ? " or " : "", SAMPLES ? RECORD_NAME : "");
        return 0;
    }
    if (has_record && fabs(now->reals[AT_RECORD_SCALE]) > MOST_RECORD_SCALE) {
        char most[NUMBER];
        snprintf(reason, MESSAGE, "base.record_scale = %s: must be at most %s, so that no acceleration exceeds 1e6 m/s2",
                 shown(now->reals[AT_RECORD_SCALE], text), shown(MOST_RECORD_SCALE, most));
        return 0;
    }
    double *scratch = malloc(sizeof(double) * ROOM);
    if (!scratch) return snprintf(reason, MESSAGE, "out of memory"), 0;
    memcpy(instance->before.model, now->model, sizeof now->model);
    int64_t made = assemble((Assemble){COLUMN(instance), .given = described, .from_rest = from_rest,
                                       .scratch = scratch, .detail = instance->detail});
    free(scratch);
    if (made != 0) {
        memcpy(now->model, instance->before.model, sizeof now->model);
        if (made == TOO_LARGE)
            snprintf(reason, MESSAGE, "block[%d].inertia = inf: " MUST_INERTIA, (int)instance->detail[0]);
        else if (made == MISFIT) {
            const double *why = instance->detail; /* joint, kind, strip, length, bound */
            const Misfit *misfit = &misfits[(int)why[1] - 1];
            char bound[NUMBER];
            snprintf(reason, MESSAGE, "joint[%d].%s", (int)why[0], misfit->name);
            if (why[2] >= 0) append(reason, "[%d]", (int)why[2]);
            append(reason, " = %s: %s = %s m", shown(why[3], text), misfit->relation, shown(why[4], bound));
        } else if (made == NO_REST)
            snprintf(reason, MESSAGE, "the column cannot stand: its blocks, offset or inclined as they are, or with "
                                      "such joints, have no stable rest under their weight");
        else if (made == UNKNOWN_SECTION)
            snprintf(reason, MESSAGE, "block[%d]: this FMU has no kernels of its section or contact",
                     (int)instance->detail[0]);
        else
            snprintf(reason, MESSAGE, "joints that slide, and blocks that are off their axis, need the linear law in "
                                      "every joint, which this FMU has not");
        return 0;
    }
    now->built = now->started = 1;
    now->retune = 0;
    if (from_rest) {
        now->has_record = has_record;
        if (HAS_RECORD) {
            now->scale = now->reals[AT_RECORD_SCALE];
            now->reals[AT_RECORD_PGA] = has_record ? fabs(now->scale) * RECORD_LARGEST : 0.0;
        }
        if (FALLS) {
            now->reals[AT_OVERTURN_TIME] = -1.0;
            now->wholes[AT_FALLEN] = now->wholes[AT_OVERTURNED] = 0;
            now->wholes[AT_VERDICT] = VERDICT_UNDECIDED;
        }
        now->inputs_stand = 0;
    }
    instance->outdated = 1;
    return 1;
}

/* Fill row and split with the outputs as they are now. */
static int64_t look_now(Instance *instance) {
    Moment *now = &instance->now;
    return look((Look){COLUMN(instance), RECORD(instance), .inputs = now->reals, .new_inputs = !now->inputs_stand,
                       .upright = now->mode == INITIALIZATION, .elapsed = now->time - now->input_time, .t = now->time,
                       .row = &now->reals[AT_ROW], .split = &now->reals[AT_SPLIT]});
}

/* Fill row and split of the instance with the rates of the outputs. */
static int64_t rates_now(Instance *instance) {
    return rates((Rates){COLUMN(instance), RECORD(instance), .t = instance->now.time, .row = instance->row,
                         .split = instance->split, .other = instance->other_row, .other_split = instance->other_split});
}

/* Bring the outputs up to date. */
static int update(Instance *instance, char *reason) {
    Moment *now = &instance->now;
    if (now->mode == INSTANTIATED) return snprintf(reason, MESSAGE, SAY_TOO_EARLY), 0;
    if (now->mode == INITIALIZATION && !now->built && !build(instance, 1, reason)) return 0;
    if (!now->started || !instance->outdated) return 1;
    if (now->retune && !build(instance, 0, reason)) return 0;
    int64_t code = look_now(instance);
    if (code < 0) return snprintf(reason, MESSAGE, "at t = %.6g s: %s", now->time, reason_of(code)), 0;
    if (FALLS) {
        for (int k = 0; k < PEAKS; k++) {
            double kept = now->state[peaks[k].place];
            now->reals[AT_PEAKS + k] = peaks[k].by_least ? 1.0 - kept : kept;
        }
        int64_t fallen = now->counts[COUNT_OVERTURNED], resting = now->counts[COUNT_RESTING];
        now->wholes[AT_VERDICT] = fallen ? VERDICT_OVERTURNED : resting ? VERDICT_STANDING : VERDICT_UNDECIDED;
        now->wholes[AT_FALLEN] = fallen;
        now->wholes[AT_OVERTURNED] = fallen > 0;
        now->reals[AT_OVERTURN_TIME] = fallen ? now->state[STATE_OVERTURN_TIME] : -1.0;
    }
    instance->outdated = 0;
    return 1;
}

/* --- how the base moves: as its inputs say, or bodies at it */

/* The kernels' code of how the base moves, and its word. */
static int drive_of(const Moment *now, const char **word) {
    char reason[MESSAGE];
    if (DRIVE_CHOICE < 0) return 0;
    const Choice *choice = &choices[DRIVE_CHOICE < 0 ? 0 : DRIVE_CHOICE];
    int code = chosen(choice, now, reason);
    if (word) *word = now->texts[variables[choice->row].place];
    return code < 0 ? 0 : code;
}

/* Say once that an input does nothing, if it does, as the base is driven. is_coupled: after the first exchange. */
static void warn_of_idle(Instance *instance, int input, int is_coupled) {
    static const char *const ways[] = {SAY_BY_ACCELERATION, SAY_BY_BODY, SAY_BY_HORIZONTAL}; /* by the code */
    const char *word = "", *name = variables[input].name;
    int owner = strncmp(name, "base", 4) ? 1 : 2; /* once of the base's inputs, once of those of bodies */
    if (instance->idle_warned & owner || !idle[input]) return;
    int drive = drive_of(&instance->now, &word), ever = (idle[input] >> (2 * drive)) & IDLE_EVER;
    if (!ever && !(is_coupled && (idle[input] >> (2 * drive)) & IDLE_LATER)) return;
    instance->idle_warned |= owner;
    core_say(instance, ST_WARNING, SAY_IDLE, name, ever ? "" : SAY_IDLE_LATER, word, ways[drive]);
}

/* The same of an input that is to be set in a run, if this changes it. */
static void watch_input(Instance *instance, int input, double value) {
    const Moment *now = &instance->now;
    if (now->mode == STEPPING && value != now->reals[input])
        warn_of_idle(instance, input, BASE_COUPLED >= 0 && now->base[BASE_COUPLED < 0 ? 0 : BASE_COUPLED] != 0.0);
}

/* Whether the base has moved in the last step, or a port was loaded. */
static int has_moved(const Moment *now, double start) {
    double least = drive_of(now, NULL) ? STILL : 0.0;
    if (now->has_record && now->scale != 0.0 && now->time > RECORD_BEGINS && start < RECORD_ENDS) return 1;
    for (int k = 0; k < MOTIONS; k++)
        if (fabs(now->base[motion_in_base[k]]) > least) return 1;
    for (int k = AT_LOADS; k < AT_LOADS + LOADS; k++)
        if (now->reals[k] != 0.0) return 1;
    return 0;
}

/* --- life */

static int wrong_mode(const Instance *instance, int allowed, const char *what) {
    if (instance->now.mode & allowed) return 0;
    core_say(instance, ST_ERROR, SAY_WRONG_MODE, what, mode_name(instance->now.mode));
    return 1;
}

Instance *core_new(Teller *teller, void *host) {
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) return NULL;
    instance->teller = teller;
    instance->host = host;
    core_reset(instance);
    return instance;
}

void core_free(Instance *instance) { free(instance); }

void core_reset(Instance *instance) {
    Moment *now = &instance->now;
    memset(now, 0, sizeof *now);
    now->mode = INSTANTIATED;
    memcpy(now->reals, real_starts, sizeof now->reals);
    if (FALLS) now->reals[AT_OVERTURN_TIME] = -1.0;
    for (int k = 0; k < WHOLES; k++) now->wholes[k] = whole_starts[k];
    if (FALLS) now->wholes[AT_VERDICT] = VERDICT_UNDECIDED;
    for (int k = 0; k < TEXTS; k++) snprintf(now->texts[k], TEXT, "%s", text_starts[k]);
    instance->outdated = 1;
    instance->stop = INFINITY;
    instance->coarse_warned = instance->unstable_warned = instance->idle_warned = instance->long_warned = 0;
    instance->stepped = 0;
    memset(instance->alternations, 0, sizeof instance->alternations);
    instance->watched = -INFINITY;
    instance->last_step = ST_OK;
}

Status core_set_up(Instance *instance, double start, const double *stop, const double *tolerance) {
    Moment *now = &instance->now;
    char text[NUMBER], other[NUMBER];
    if (wrong_mode(instance, INSTANTIATED, SAY_WHEN_SET_UP)) return ST_ERROR;
    if (!isfinite(start)) return core_say(instance, ST_ERROR, SAY_START_TIME, shown(start, text));
    if (stop && !(*stop >= start))
        return core_say(instance, ST_ERROR, SAY_STOP_TIME, shown(*stop, text), shown(start, other));
    now->time = now->input_time = start;
    instance->stop = stop ? *stop : INFINITY;
    if (HAS_TOLERANCE && tolerance && !now->tolerance_set) {
        now->reals[AT_TOLERANCE] = *tolerance;
        core_say(instance, ST_OK, SAY_TOLERANCE, shown(*tolerance, text));
    }
    return ST_OK;
}

Status core_enter_initialization(Instance *instance) {
    if (wrong_mode(instance, INSTANTIATED, SAY_WHEN_ENTERED)) return ST_ERROR;
    instance->now.mode = INITIALIZATION;
    return ST_OK;
}

Status core_exit_initialization(Instance *instance) {
    char reason[MESSAGE];
    if (wrong_mode(instance, INITIALIZATION, SAY_WHEN_EXITED)) return ST_ERROR;
    if (!instance->now.built && !build(instance, 1, reason)) return core_say(instance, ST_ERROR, "%s", reason);
    instance->outdated = 1;
    instance->now.inputs_stand = 0;
    (void)update(instance, reason); /* stands on the base as it is turned now; outputs report errors */
    instance->outdated = 1;
    instance->now.mode = STEPPING;
    for (int k = 0; k < BASE_INPUTS; k++)
        if (instance->now.reals[k] != real_starts[k]) warn_of_idle(instance, k, 0);
    core_say(instance, ST_OK, SAY_PREFERRED, USUAL_STEP);
    return ST_OK;
}

Status core_terminate(Instance *instance) {
    if (wrong_mode(instance, STEPPING, SAY_WHEN_TERMINATED)) return ST_ERROR;
    if (FALLS && !instance->now.shaken && instance->stepped)
        core_say(instance, ST_WARNING, "%s", drive_of(&instance->now, NULL) ? SAY_NOT_DRIVEN : SAY_NOT_SHAKEN);
    instance->now.mode = TERMINATED;
    return ST_OK;
}

/* --- variables */

/* The row of a value reference; NULL if no variable has it. */
static const Variable *find(Reference reference) {
    Reference family = (reference - 1u) / FAMILY, number = (reference - 1u) % FAMILY;
    if (family >= COUNT(family_index) || number >= (Reference)family_index[family].count) return NULL;
    int row = family_index[family].rows[number];
    return row < 0 ? NULL : &variables[row];
}

size_t core_extent(Reference reference) {
    Reference family = (reference - 1u) / FAMILY, number = (reference - 1u) % FAMILY;
    if (!find(reference)) return 0;
    if (!family_index[family].is_array) return 1;
    return number ? 0 : (size_t)family_index[family].count;
}

size_t core_most(void) { return COUNT(variables); }

int core_line(Reference input, Reference *slope) {
    for (int k = 0; k < LINES; k++)
        if (lines[k].input == input && core_extent(input) == 1) return *slope = lines[k].slope, 1;
    return 0;
}

size_t core_lines(void) { return LINES; }

int core_has(const Instance *instance, const void *array, size_t count, const char *what) {
    if (array || !count) return 1;
    core_say(instance, ST_ERROR, "%s: the pointer is NULL", what);
    return 0;
}

/* Whether both lists of a call are there. */
static int has_both(const Instance *instance, const Reference references[], const void *values, size_t count) {
    return core_has(instance, references, count, "value references") && core_has(instance, values, count, "values");
}

Status core_readable(Instance *instance, const Reference references[], size_t count, Kind kind, const void *values) {
    char reason[MESSAGE] = "", time[NUMBER];
    int outputs = 0;
    if (!has_both(instance, references, values, count)) return ST_ERROR;
    for (size_t k = 0; k < count && !reason[0]; k++) {
        const Variable *variable = find(references[k]);
        if (!variable || variable->kind != kind)
            snprintf(reason, MESSAGE, SAY_NO_VARIABLE, references[k], kind_name(kind));
        else
            outputs |= variable->role == OUTPUT;
    }
    int stale = outputs && (instance->outdated || instance->now.mode == INSTANTIATED);
    if (!reason[0] && (!stale || update(instance, reason))) return ST_OK;
    return core_say(instance, ST_ERROR, SAY_NOT_READ, shown(instance->now.time, time), reason);
}

Status core_settable(Instance *instance, const Reference references[], size_t count, Kind kind, const void *values) {
    if (!has_both(instance, references, values, count)) return ST_ERROR;
    if (instance->now.mode == TERMINATED) return core_say(instance, ST_ERROR, SAY_NOTHING_SET);
    for (size_t k = 0; k < count; k++) {
        const Variable *variable = find(references[k]);
        if (!variable || variable->kind != kind || variable->role == OUTPUT)
            return core_say(instance, ST_ERROR, SAY_NOT_SETTABLE, references[k], kind_name(kind));
        if (instance->now.mode == STEPPING && variable->role == PARAMETER && !variable->tunable)
            return core_say(instance, ST_ERROR, SAY_FIXED, variable->name);
    }
    return ST_OK;
}

void core_has_changed(Instance *instance, int parameters, int inputs) {
    Moment *now = &instance->now;
    if (parameters) {
        now->built = 0;
        now->retune = now->mode == STEPPING;
    }
    if (inputs) now->input_time = now->time; /* a parameter leaves the slopes of the inputs as they run */
    now->inputs_stand = 0;
    instance->outdated = 1;
}

Status core_get_reals(Instance *instance, const Reference references[], size_t count, double values[]) {
    if (core_readable(instance, references, count, REAL, values) != ST_OK) return ST_ERROR;
    for (size_t k = 0; k < count; k++) values[k] = instance->now.reals[find(references[k])->place];
    return ST_OK;
}

Status core_set_reals(Instance *instance, const Reference references[], size_t count, const double values[]) {
    int parameters = 0, inputs = 0;
    if (core_settable(instance, references, count, REAL, values) != ST_OK) return ST_ERROR;
    for (size_t k = 0; k < count; k++) {
        const Variable *variable = find(references[k]);
        if (variable->role == INPUT) watch_input(instance, variable->place, values[k]);
        instance->now.reals[variable->place] = values[k];
        if (HAS_TOLERANCE && variable->place == AT_TOLERANCE) instance->now.tolerance_set = 1;
        parameters |= variable->role == PARAMETER;
        inputs |= variable->role == INPUT;
    }
    core_has_changed(instance, parameters, inputs);
    return ST_OK;
}

int64_t core_whole(const Instance *instance, Reference reference) { return instance->now.wholes[find(reference)->place]; }

void core_put_whole(Instance *instance, Reference reference, int64_t value) {
    instance->now.wholes[find(reference)->place] = value;
}

const char *core_text(const Instance *instance, Reference reference) {
    return instance->now.texts[find(reference)->place];
}

Status core_set_texts(Instance *instance, const Reference references[], size_t count, const char *const values[]) {
    if (core_settable(instance, references, count, STRING, values) != ST_OK) return ST_ERROR;
    for (size_t k = 0; k < count; k++)
        if (!values[k] || strlen(values[k]) >= TEXT)
            return core_say(instance, ST_ERROR, "%s: must be a text of less than %d bytes", find(references[k])->name,
                            TEXT);
    for (size_t k = 0; k < count; k++) strcpy(instance->now.texts[find(references[k])->place], values[k]);
    core_has_changed(instance, count > 0, 0);
    return ST_OK;
}

/* --- steps */

/* Why a step with these times is refused; a shorter one would not help. */
static int wrong_call(const Instance *instance, double start, double step, char *reason) {
    const Moment *now = &instance->now;
    char text[NUMBER];
    if (now->mode != STEPPING)
        return snprintf(reason, MESSAGE, "%s", now->mode == TERMINATED ? SAY_ENDED : SAY_NOT_BEGUN), 1;
    if (!(isfinite(step) && step > 0.0)) return snprintf(reason, MESSAGE, SAY_NOT_POSITIVE), 1;
    if (!(fabs(start - now->time) <= TIME_SLACK * step + 1e-12 * fabs(now->time)))
        return snprintf(reason, MESSAGE, SAY_LAST_ENDED, shown(now->time, text)), 1;
    if (start + step - instance->stop > TIME_SLACK * step + 1e-12 * fabs(instance->stop))
        return snprintf(reason, MESSAGE, SAY_BEYOND, shown(instance->stop, text)), 1;
    return 0;
}

static int wrong_input(const Instance *instance, char *reason) {
    char text[NUMBER];
    for (int k = 0; k < BASE_INPUTS; k++) { /* inputs come first */
        double value = instance->now.reals[k];
        if (!isfinite(value))
            return snprintf(reason, MESSAGE, SAY_NOT_FINITE, variables[k].name, shown(value, text), variables[k].unit), 1;
    }
    return 0;
}

static int alternates(Alternation *of, double value) {
    double change = value - of->last;
    if (!(change * of->change < 0.0) || fabs(change) < ALTERNATES_BACK * of->largest) {
        of->in_a_row = 0;
        of->before = fmax(of->largest, fabs(value));
    }
    of->in_a_row++;
    of->last = value;
    of->change = change;
    of->largest = fmax(of->largest, fabs(value));
    return of->in_a_row >= ALTERNATES_MANY && of->largest > ALTERNATES_GROWTH * of->before;
}

/* Say once that the accelerations of the base, held from `start` on, diverge with the coupling. */
static void warn_of_instability(Instance *instance, double start) {
    if (instance->unstable_warned || !(start > instance->watched)) return;
    instance->watched = start;
    for (int k = 0; k < BASE_INPUTS; k++) {
        const Variable *input = &variables[k];
        char text[NUMBER], time[NUMBER];
        if (place_in_base[k] < 0) continue;
        double value = instance->now.base[place_in_base[k]];
        if (!alternates(&instance->alternations[k], value) || instance->unstable_warned) continue;
        instance->unstable_warned = 1;
        core_say(instance, ST_WARNING, SAY_UNSTABLE, input->name, shown(value, text), input->unit, shown(start, time));
    }
}

static Status advance(Instance *instance, double start, double step, char *reason) {
    Moment *now = &instance->now;
    if (now->retune && !build(instance, 0, reason)) return ST_DISCARD;
    memcpy(instance->before.state, now->state, sizeof now->state);
    memcpy(instance->before.counts, now->counts, sizeof now->counts);
    memcpy(instance->before.base, now->base, sizeof now->base);
    now->input_time = start;
    int64_t code = follow((Follow){COLUMN(instance), RECORD(instance), .inputs = now->reals, .start = start, .h = step,
                                   .row = instance->row, .split = instance->split});
    if (code < 0) {
        memcpy(now->state, instance->before.state, sizeof now->state);
        memcpy(now->counts, instance->before.counts, sizeof now->counts);
        memcpy(now->base, instance->before.base, sizeof now->base);
        now->inputs_stand = 0;
        instance->outdated = 1;
        snprintf(reason, MESSAGE, "at t = %.6g s: %s", start, reason_of(code));
        return code == TOO_MUCH_WORK ? ST_ERROR : ST_DISCARD;
    }
    now->time = start + step;
    instance->stepped = 1;
    now->inputs_stand = instance->outdated = 1;
    if (FALLS && !now->shaken) now->shaken = has_moved(now, start);
    if (FALLS && now->has_record && now->scale != 0.0 && !instance->coarse_warned && step > RECORD_DT * (1.0 + STEP_SLACK)) {
        char text[NUMBER];
        instance->coarse_warned = 1;
        core_say(instance, ST_WARNING, SAY_COARSE, shown(step, text), RECORD_DT);
    }
    if (BASE_ALLOWED >= 0 && !instance->long_warned && now->base[BASE_ALLOWED < 0 ? 0 : BASE_ALLOWED] > 0.0) {
        char text[NUMBER];
        instance->long_warned = 1;
        core_say(instance, ST_WARNING, SAY_TOO_LONG, shown(step, text), now->base[BASE_ALLOWED < 0 ? 0 : BASE_ALLOWED]);
    }
    if (FALLS) warn_of_instability(instance, start);
    return ST_OK;
}

static Status not_made(Instance *instance, Status status, double start, double step, const char *reason) {
    char first[NUMBER], second[NUMBER];
    core_say(instance, status, SAY_NOT_MADE, shown(start, first), shown(step, second), reason);
    return instance->last_step = status;
}

Status core_can_step(Instance *instance, double start, double step) {
    char reason[MESSAGE];
    return wrong_call(instance, start, step, reason) ? not_made(instance, ST_ERROR, start, step, reason) : ST_OK;
}

Status core_step(Instance *instance, double start, double step) {
    char reason[MESSAGE];
    if (core_can_step(instance, start, step) != ST_OK) return ST_ERROR;
    Status status = wrong_input(instance, reason) ? ST_DISCARD : advance(instance, start, step, reason);
    return status == ST_OK ? instance->last_step = ST_OK : not_made(instance, status, start, step, reason);
}

Status core_last_step(const Instance *instance) { return instance->last_step; }

double core_time(const Instance *instance) { return instance->now.time; }

/* --- inputs over the pieces of a step */

size_t core_inputs(void) { return BASE_INPUTS; }

void core_take_inputs(const Instance *instance, double values[]) {
    memcpy(values, instance->now.reals, BASE_INPUTS * sizeof *values);
}

void core_continue_inputs(Instance *instance, const double values[], double past) {
    for (int k = 0; k < BASE_INPUTS; k++) {
        int slope = slope_of[k], bend = slope < 0 ? -1 : slope_of[slope];
        double rate = slope < 0 ? 0.0 : values[slope] + 0.5 * past * (bend < 0 ? 0.0 : values[bend]);
        instance->now.reals[k] = values[k] + past * rate;
    }
}

void core_keep_inputs(Instance *instance, const double values[], double start) {
    memcpy(instance->now.reals, values, BASE_INPUTS * sizeof *values);
    instance->now.input_time = start;
}

void core_put_real(Instance *instance, Reference reference, double value) {
    instance->now.reals[find(reference)->place] = value;
}

/* --- derivatives */

static int first_order(const Instance *instance, const Variable *variable, int order) {
    if (order == 1) return 1;
    core_say(instance, ST_ERROR, "derivative of %s of the order %d: must be of the order 1", variable->name, order);
    return 0;
}

Status core_set_slopes(Instance *instance, const Reference references[], size_t count, const int orders[],
                       const double values[]) {
    if (!core_has(instance, orders, count, "orders")) return ST_ERROR;
    if (core_settable(instance, references, count, REAL, values) != ST_OK) return ST_ERROR;
    for (size_t k = 0; k < count; k++) {
        const Variable *variable = find(references[k]);
        if (variable->role != INPUT) return core_say(instance, ST_ERROR, "%s: is not an input", variable->name);
        if (!first_order(instance, variable, orders[k])) return ST_ERROR;
        if (slope_of[variable->place] < 0 && values[k] != 0.0)
            return core_say(instance, ST_ERROR, "%s: is held within a step, its derivative must be 0", variable->name);
    }
    for (size_t k = 0; k < count; k++) {
        int slope = slope_of[find(references[k])->place];
        if (slope < 0) continue;
        watch_input(instance, slope, values[k]);
        instance->now.reals[slope] = values[k];
    }
    core_has_changed(instance, 0, 1);
    return ST_OK;
}

/* Place in row or split of an output that follows the motion; NULL for other variables. */
static const double *visible(const Instance *instance, Reference reference) {
    const Variable *variable = find(reference);
    if (!variable || variable->kind != REAL) return NULL;
    int place = variable->place;
    if (AT_ROW <= place && place < AT_ROW + ROW) return &instance->row[place - AT_ROW];
    if (AT_SPLIT <= place && place < AT_SPLIT + SPLIT) return &instance->split[place - AT_SPLIT];
    return NULL;
}

static int is_continuous_output(const Instance *instance, Reference reference) {
    if (visible(instance, reference)) return 1;
    core_say(instance, ST_ERROR, "value reference %u: is not that of a continuous output", reference);
    return 0;
}

static int up_to_date(Instance *instance) {
    char reason[MESSAGE];
    if (update(instance, reason)) return 1;
    core_say(instance, ST_ERROR, "%s", reason);
    return 0;
}

/* Take derivatives for which a kernel has left a code, and return the status; an error is logged. */
static Status take(const Instance *instance, int64_t code, const Reference references[], size_t count,
                   double values[]) {
    if (code < 0) return core_say(instance, ST_ERROR, "%s", reason_of(code));
    for (size_t k = 0; k < count; k++) {
        values[k] = *visible(instance, references[k]);
        if (!isfinite(values[k]))
            return core_say(instance, ST_ERROR, "%s: its derivative is no finite number", find(references[k])->name);
    }
    return ST_OK;
}

Status core_rates(Instance *instance, const Reference references[], size_t count, const int orders[], double values[]) {
    if (wrong_mode(instance, INITIALIZATION | STEPPING | TERMINATED, "derivatives of outputs")) return ST_ERROR;
    if (!has_both(instance, references, values, count) || !core_has(instance, orders, count, "orders")) return ST_ERROR;
    for (size_t k = 0; k < count; k++)
        if (!is_continuous_output(instance, references[k]) || !first_order(instance, find(references[k]), orders[k]))
            return ST_ERROR;
    if (!up_to_date(instance)) return ST_ERROR;
    return take(instance, rates_now(instance), references, count, values);
}

Status core_directional(Instance *instance, const Reference unknowns[], size_t unknown_count, const Reference knowns[],
                        size_t known_count, const double seeds[], double values[]) {
    const Moment *now = &instance->now;
    double along[INPUT_ROOM] = {0.0};
    if (wrong_mode(instance, INITIALIZATION | STEPPING | TERMINATED, "directional derivatives")) return ST_ERROR;
    if (!has_both(instance, unknowns, values, unknown_count) || !has_both(instance, knowns, seeds, known_count))
        return ST_ERROR;
    for (size_t k = 0; k < unknown_count; k++)
        if (!is_continuous_output(instance, unknowns[k])) return ST_ERROR;
    for (size_t k = 0; k < known_count; k++) {
        const Variable *known = find(knowns[k]);
        if (!known || known->role != INPUT)
            return core_say(instance, ST_ERROR, "value reference %u: is not that of an input", knowns[k]);
        along[known->place] += seeds[k];
    }
    if (!up_to_date(instance)) return ST_ERROR;
    int64_t code = feedthrough((Feedthrough){COLUMN(instance), RECORD(instance), .inputs = now->reals, .seeds = along,
                                             .elapsed = now->time - now->input_time,
                                             .t = now->time, .row = instance->row, .split = instance->split,
                                             .other = instance->other_row, .other_split = instance->other_split});
    return take(instance, code, unknowns, unknown_count, values);
}

/* --- state */

Status core_save(Instance *instance, Saved **saved) {
    if (!*saved && !(*saved = malloc(sizeof **saved))) return core_say(instance, ST_ERROR, "out of memory");
    (*saved)->owner = core_identity;
    memcpy(&(*saved)->moment, &instance->now, sizeof instance->now);
    return ST_OK;
}

Status core_restore(Instance *instance, const Saved *saved) {
    if (!saved || saved->owner != core_identity)
        return core_say(instance, ST_ERROR, SAY_NOT_SET, "it is not one of this FMU");
    /* what the modal method keeps in work follows from the model */
    if (memcmp(instance->now.model, saved->moment.model, sizeof saved->moment.model))
        memset(instance->work, 0, sizeof instance->work);
    memcpy(&instance->now, &saved->moment, sizeof saved->moment);
    instance->outdated = 1;
    return ST_OK;
}

void core_release(Saved *saved) { free(saved); }

/* Bytes: format, whose it is and a checksum in text, then the moment as it is. */
static uint64_t checksum(const void *data, size_t size) { /* FNV-1a */
    const unsigned char *at = data;
    uint64_t hash = 14695981039346656037u;
    for (size_t k = 0; k < size; k++) hash = (hash ^ at[k]) * 1099511628211u;
    return hash;
}

static void write_header(char *header, const Moment *moment) {
    memset(header, 0, HEADER);
    snprintf(header, HEADER, STATE_FORMAT "\n" IDENTITY "\n%016llx",
             (unsigned long long)checksum(moment, sizeof *moment));
}

size_t core_bytes(void) { return HEADER + sizeof(Moment); }

Status core_to_bytes(const Instance *instance, const Saved *saved, void *bytes, size_t size) {
    if (!core_has(instance, saved, 1, "state") || !core_has(instance, bytes, 1, "bytes")) return ST_ERROR;
    if (size < core_bytes())
        return core_say(instance, ST_ERROR, "%llu bytes: the state takes %llu", (unsigned long long)size,
                        (unsigned long long)core_bytes());
    write_header(bytes, &saved->moment);
    memcpy((char *)bytes + HEADER, &saved->moment, sizeof saved->moment);
    return ST_OK;
}

/* Whether numbers, or whole ones, are within their ranges. loose: whether those that follow from inputs may be any. */
static int are_within(const Range ranges[], size_t count, const double *numbers, const int64_t *wholes, int loose) {
    for (size_t k = 0, at = 0; k < count; k++) {
        const Range *range = &ranges[k];
        for (int i = 0; i < range->count; i++, at++) {
            double value = wholes ? (double)wholes[at] : numbers[at];
            if ((range->of_inputs && loose) || (range->may_lack && isnan(value))) continue;
            if (!(range->low <= value && value <= range->high) || (range->whole && value != floor(value))) return 0;
        }
    }
    return 1;
}

/* Whether a moment read from bytes is one that an instance can be in: the kernels trust all of it. */
static int is_possible(const Moment *moment) {
    const int64_t flags[] = {moment->built,  moment->started,    moment->retune,       moment->inputs_stand,
                             moment->shaken, moment->has_record, moment->tolerance_set};
    int loose = !moment->inputs_stand, moves = moment->mode == STEPPING || moment->mode == TERMINATED;
    for (size_t k = 0; k < COUNT(flags); k++)
        if (flags[k] != 0 && flags[k] != 1) return 0;
    if (!moves && moment->mode != INSTANTIATED && moment->mode != INITIALIZATION) return 0;
    if (moves && (!moment->started || moment->built == moment->retune)) return 0;
    if (moment->built && !moment->started) return 0;
    if (moment->has_record && (!SAMPLES || !(fabs(moment->scale) <= MOST_RECORD_SCALE))) return 0;
    if (HAS_RECORD && !isfinite(moment->reals[AT_RECORD_PGA])) return 0;
    for (int k = 0; k < BASE_INPUTS && !loose; k++)
        if (!isfinite(moment->reals[k])) return 0;
    for (int k = 0; k < TEXTS; k++)
        if (!memchr(moment->texts[k], 0, TEXT)) return 0;
    if (!are_within(state_ranges, COUNT(state_ranges), moment->state, NULL, loose) ||
        !are_within(counts_ranges, COUNT(counts_ranges), NULL, moment->counts, loose) ||
        !are_within(base_ranges, COUNT(base_ranges), moment->base, NULL, loose))
        return 0;
    if (BASE_SEGMENT >= 0 && !(moment->base[BASE_SEGMENT < 0 ? 0 : BASE_SEGMENT] <= (double)SAMPLES)) return 0;
    return fabs(moment->time) <= MOST_TIME && fabs(moment->input_time) <= MOST_TIME && isfinite(moment->scale);
}

/* Whether outputs and their rates follow from a moment whose model is its own, whatever the inputs are. Changes the
   scratch. */
static int has_outputs(Instance *scratch) {
    Moment *now = &scratch->now;
    int usual = 1;
    for (int k = 0; k < BASE_INPUTS; k++) usual &= fabs(now->reals[k]) <= MOST_TRIED;
    if (!usual && !now->inputs_stand) memcpy(now->reals, real_starts, BASE_INPUTS * sizeof *now->reals);
    if (look_now(scratch) < 0) return 1; /* which becomes an Error when outputs are got */
    for (int k = AT_ROW; k < AT_SPLIT + SPLIT; k++)
        if (!(fabs(now->reals[k]) <= MOST)) return 0;
    int64_t code = rates_now(scratch);
    for (int k = 0; code >= 0 && k < ROW; k++)
        if (!isfinite(scratch->row[k])) return 0;
    for (int k = 0; code >= 0 && k < SPLIT; k++)
        if (!isfinite(scratch->split[k])) return 0;
    return 1;
}

/* Whether the model of a moment, which holds sizes and codes, is that of the parameters, and gives outputs; a parameter
   set since does not count, because the model is rebuilt before its next use. */
static int is_whole(const Moment *moment) {
    char reason[MESSAGE];
    if (!moment->started) return 1;
    Instance *scratch = calloc(1, sizeof *scratch);
    if (!scratch) return 0;
    scratch->now = *moment;
    int built = build(scratch, 0, reason);
    int same = !memcmp(scratch->now.model, moment->model, sizeof moment->model);
    memcpy(scratch->now.state, moment->state, sizeof moment->state);
    int whole = moment->built ? built && same && has_outputs(scratch) : !built || has_outputs(scratch);
    free(scratch);
    return whole;
}

Status core_from_bytes(Instance *instance, const void *bytes, size_t size, Saved **saved) {
    static const char format[] = STATE_FORMAT, identity[] = IDENTITY;
    const char *at = bytes, *fault = NULL;
    char header[HEADER];
    Saved *made = NULL;
    if (!core_has(instance, bytes, 1, "bytes")) return ST_ERROR;
    if (size < HEADER || memcmp(at, format, sizeof format - 1))
        fault = "the bytes are not those of a serialized state of this format";
    else if (memcmp(at + sizeof format, identity, sizeof identity - 1))
        fault = "the state is that of another column or structure, or was made by another version";
    else if (size != core_bytes())
        fault = "the bytes are not all of those of a serialized state";
    else if (!(made = malloc(sizeof *made)))
        fault = "out of memory";
    else {
        made->owner = core_identity;
        memcpy(&made->moment, at + HEADER, sizeof made->moment);
        write_header(header, &made->moment);
        if (memcmp(header, at, HEADER)) fault = "the bytes of the serialized state are damaged";
        else if (!is_possible(&made->moment) || !is_whole(&made->moment))
            fault = "the bytes are those of no state that this FMU can be in";
    }
    if (fault) {
        free(made);
        return core_say(instance, ST_ERROR, SAY_NOT_SET, fault);
    }
    *saved = made;
    return ST_OK;
}
