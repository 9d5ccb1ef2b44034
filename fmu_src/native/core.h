/* One column in motion, for any interface: its life, its variables, its steps, its state, with types of its own.

   A face such as fmi2.c turns the calls of a standard into these. A function that returns ST_ERROR has logged why. */

#ifndef CORE_H
#define CORE_H

#include <stddef.h>
#include <stdint.h>

typedef enum { ST_OK, ST_WARNING, ST_DISCARD, ST_ERROR } Status;
typedef enum { REAL, INTEGER, BOOLEAN, STRING } Kind; /* an enumeration is an INTEGER */
typedef enum { INPUT, OUTPUT, PARAMETER } Role;

typedef uint32_t Reference;
typedef struct Instance Instance;
typedef struct Saved Saved;

/* Passes a message to the host; the text is plain. */
typedef void Teller(void *host, Status status, const char *text);

extern const char *const core_identity; /* text that binary and model description must share */
extern const double core_usual_step; /* s, of the samples of a motion: what a face may divide longer steps into */

Instance *core_new(Teller *teller, void *host); /* NULL: out of memory */
void core_free(Instance *instance);
Status core_say(const Instance *instance, Status status, const char *format, ...) /* returns the status */
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* --- life */

/* stop, tolerance: NULL where the host has none. */
Status core_set_up(Instance *instance, double start, const double *stop, const double *tolerance);
Status core_enter_initialization(Instance *instance);
Status core_exit_initialization(Instance *instance);
Status core_terminate(Instance *instance);
void core_reset(Instance *instance);

/* --- variables: the whole list is checked before anything is read or set */

/* Whether the host gave an array of `count`, or a place for a value; if not, an error is logged. */
int core_has(const Instance *instance, const void *array, size_t count, const char *what);

Status core_get_reals(Instance *instance, const Reference references[], size_t count, double values[]);
Status core_set_reals(Instance *instance, const Reference references[], size_t count, const double values[]);
Status core_set_texts(Instance *instance, const Reference references[], size_t count, const char *const values[]);

/* Whether these can be read now, and are up to date; then one by one. */
Status core_readable(Instance *instance, const Reference references[], size_t count, Kind kind, const void *values);
int64_t core_whole(const Instance *instance, Reference reference);
const char *core_text(const Instance *instance, Reference reference);

/* Whether these can be set now; then one by one, then that something has changed. */
Status core_settable(Instance *instance, const Reference references[], size_t count, Kind kind, const void *values);
void core_put_whole(Instance *instance, Reference reference, int64_t value);
void core_has_changed(Instance *instance, int parameters, int inputs);

/* How many variables a reference stands for, itself and those that follow it: one, all of an array by its first, or 0. */
size_t core_extent(Reference reference);
size_t core_most(void); /* variables in all */
int core_line(Reference input, Reference *slope); /* whether the input has a slope of its own within a step */
size_t core_lines(void); /* inputs that have one */

/* --- steps */

Status core_step(Instance *instance, double start, double step);
Status core_can_step(Instance *instance, double start, double step); /* whether the call is right, inputs aside */
Status core_last_step(const Instance *instance);
double core_time(const Instance *instance); /* s, where the last step ended */

/* For a step that a face makes in pieces: inputs by their places. The inputs as they are; then set, `past` s after they
   were, by their slopes; then as they were again, with outputs that stay those of the last step, begun at `start`. */
size_t core_inputs(void);
void core_take_inputs(const Instance *instance, double values[]);
void core_continue_inputs(Instance *instance, const double values[], double past);
void core_keep_inputs(Instance *instance, const double values[], double start);
void core_put_real(Instance *instance, Reference reference, double value); /* unchecked, outputs stay, too */

/* --- derivatives by time and by inputs */

Status core_set_slopes(Instance *instance, const Reference references[], size_t count, const int orders[],
                       const double values[]);
Status core_rates(Instance *instance, const Reference references[], size_t count, const int orders[], double values[]);
Status core_directional(Instance *instance, const Reference unknowns[], size_t unknown_count, const Reference knowns[],
                        size_t known_count, const double seeds[], double values[]);

/* --- state */

Status core_save(Instance *instance, Saved **saved); /* into *saved, if that is not NULL */
Status core_restore(Instance *instance, const Saved *saved);
void core_release(Saved *saved);
size_t core_bytes(void);
Status core_to_bytes(const Instance *instance, const Saved *saved, void *bytes, size_t size);
Status core_from_bytes(Instance *instance, const void *bytes, size_t size, Saved **saved);

#endif
