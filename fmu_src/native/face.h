/* Life and state, which FMI 2.0 and 3.0 ask for alike. A face includes this after its type Face, with the names of its
   version: FMI(name), STATE(before, after), EXPORT and Component. */

_Static_assert((int)ST_OK == FMI(OK) && (int)ST_WARNING == FMI(Warning) && (int)ST_DISCARD == FMI(Discard) &&
                   (int)ST_ERROR == FMI(Error),
               "the statuses of FMI are those of the core");

static const char *category_of(Status status) {
    static const char *const categories[] = {[ST_OK] = "logAll", [ST_WARNING] = "logStatusWarning",
                                             [ST_DISCARD] = "logStatusDiscard", [ST_ERROR] = "logStatusError"};
    return categories[status];
}

#define CALL(name) EXPORT FMI(Status) FMI(name)

/* The body of a call: the core carries it out if the instance exists. */
#define ANSWER(call)                                                                                                   \
    Face *face = instance;                                                                                             \
    return face ? (FMI(Status))(call) : FMI(Error)

/* A call that gets variables of a kind which the core gives one by one; a face says what the call is given (GIVEN_TO),
   how it begins (BEGIN), and which list of references then counts (LIST, ELEMENTS). */
#define GETTER(name, kind, value)                                                                                      \
    CALL(Get##name)(Component instance, GIVEN_TO(FMI(name))) {                                                         \
        BEGIN;                                                                                                         \
        if (core_readable(face->column, LIST, ELEMENTS, kind, values) != ST_OK) return FMI(Error);                     \
        for (size_t k = 0; k < ELEMENTS; k++) values[k] = value(face->column, LIST[k]);                                \
        return FMI(OK);                                                                                                \
    }
/* Calls that set whole numbers, of which no input is one, and Booleans, of which none can be set. */
#define SETTERS(whole)                                                                                                 \
    CALL(Set##whole)(Component instance, GIVEN_TO(const FMI(whole))) {                                                 \
        BEGIN;                                                                                                         \
        if (core_settable(face->column, LIST, ELEMENTS, INTEGER, values) != ST_OK) return FMI(Error);                  \
        for (size_t k = 0; k < ELEMENTS; k++) core_put_whole(face->column, LIST[k], values[k]);                        \
        core_has_changed(face->column, ELEMENTS > 0, 0);                                                               \
        return FMI(OK);                                                                                                \
    }                                                                                                                  \
    CALL(SetBoolean)(Component instance, GIVEN_TO(const FMI(Boolean))) {                                               \
        BEGIN;                                                                                                         \
        return (FMI(Status))core_settable(face->column, LIST, ELEMENTS, BOOLEAN, values);                              \
    }

EXPORT void FMI(FreeInstance)(Component instance) {
    Face *face = instance;
    if (face) core_free(face->column);
    free(face);
}

CALL(SetDebugLogging)(Component instance, FMI(Boolean) on, size_t count, const FMI(String) categories[]) {
    (void)count, (void)categories;
    ANSWER((face->logging = on, ST_OK));
}

CALL(ExitInitializationMode)(Component instance) { ANSWER(core_exit_initialization(face->column)); }

CALL(Terminate)(Component instance) { ANSWER(core_terminate(face->column)); }

CALL(Reset)(Component instance) { ANSWER((core_reset(face->column), ST_OK)); }

EXPORT FMI(Status) STATE(Get, )(Component instance, STATE(, ) *state) {
    Face *face = instance;
    if (!face || !core_has(face->column, state, 1, "state")) return FMI(Error);
    Saved *saved = *state;
    if (core_save(face->column, &saved) != ST_OK) return FMI(Error);
    *state = saved;
    return FMI(OK);
}

EXPORT FMI(Status) STATE(Set, )(Component instance, STATE(, ) state) { ANSWER(core_restore(face->column, state)); }

EXPORT FMI(Status) STATE(Free, )(Component instance, STATE(, ) *state) {
    if (!instance) return FMI(Error);
    if (state) {
        core_release(*state);
        *state = NULL;
    }
    return FMI(OK);
}

EXPORT FMI(Status) STATE(Serialized, Size)(Component instance, STATE(, ) state, size_t *size) {
    Face *face = instance;
    if (!face || !core_has(face->column, state, 1, "state") || !core_has(face->column, size, 1, "size"))
        return FMI(Error);
    *size = core_bytes();
    return FMI(OK);
}

EXPORT FMI(Status) STATE(Serialize, )(Component instance, STATE(, ) state, FMI(Byte) bytes[], size_t size) {
    ANSWER(core_to_bytes(face->column, state, bytes, size));
}

EXPORT FMI(Status) DESERIALIZE(Component instance, const FMI(Byte) bytes[], size_t size, STATE(, ) *state) {
    Face *face = instance;
    Saved *saved = NULL;
    if (!face || !core_has(face->column, state, 1, "state")) return FMI(Error);
    if (core_from_bytes(face->column, bytes, size, &saved) != ST_OK) return FMI(Error);
    *state = saved;
    return FMI(OK);
}
