/* How the last step ended, by the calls of FMI 2.0, which the native face and the guard answer alike. Who includes this
   has the type Face and these functions. */

static fmi2Status refuse(Face *face, fmi2Status status, const char *text); /* logs it */
static int has(const Face *face, const void *value); /* if not, an error is logged */
static fmi2Status last_step(const Face *face);
static fmi2Status last_time(const Face *face, fmi2Real *value);

/* The host's logger takes a text for a format. */
static void escape(const char *text, char *escaped, size_t room) {
    size_t length = 0;
    for (const char *at = text; *at && length + 2 < room; at++) {
        if (*at == '%') escaped[length++] = '%';
        escaped[length++] = *at;
    }
    escaped[length] = 0;
}

static fmi2Status no_status(Face *face, int kind) {
    char text[64];
    if (!face) return fmi2Error;
    snprintf(text, sizeof text, "status %d: is not known of this kind", kind);
    return refuse(face, fmi2Discard, text);
}

#define STATUS(call, type, known, answer)                                                                              \
    FMI2_Export fmi2Status fmi2Get##call(fmi2Component component, const fmi2StatusKind kind, type *value) {            \
        Face *face = component;                                                                                        \
        if (!face || kind != known) return no_status(face, kind);                                                      \
        if (!has(face, value)) return fmi2Error;                                                                       \
        answer;                                                                                                        \
    }

STATUS(Status, fmi2Status, fmi2DoStepStatus, *value = last_step(face); return fmi2OK)
STATUS(RealStatus, fmi2Real, fmi2LastSuccessfulTime, return last_time(face, value))
STATUS(BooleanStatus, fmi2Boolean, fmi2Terminated, *value = fmi2False; return fmi2OK) /* never asks for the end */
STATUS(StringStatus, fmi2String, fmi2PendingStatus, *value = ""; return fmi2OK)

FMI2_Export fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)value;
    return no_status(component, kind);
}
