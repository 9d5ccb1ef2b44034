/* A co-simulation FMU that does nothing: the cost of any FMU with as many variables for a master. */
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

#define FMI2_OK(name, ...) \
    FMI2_Export fmi2Status name(__VA_ARGS__) { return fmi2OK; }

typedef struct { double reals[VARIABLES]; } Instance;

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }
FMI2_Export fmi2Component fmi2Instantiate(fmi2String a, fmi2Type b, fmi2String c, fmi2String d,
                                          const fmi2CallbackFunctions *e, fmi2Boolean f, fmi2Boolean g) {
    return calloc(1, sizeof(Instance));
}
FMI2_Export void fmi2FreeInstance(fmi2Component c) { free(c); }
FMI2_Export fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) v[k] = ((Instance *)c)->reals[r[k]];
    return fmi2OK;
}
FMI2_Export fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) ((Instance *)c)->reals[r[k]] = v[k];
    return fmi2OK;
}
FMI2_Export fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) {
    memset(v, 0, n * sizeof *v);
    return fmi2OK;
}
FMI2_Export fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]) {
    memset(v, 0, n * sizeof *v);
    return fmi2OK;
}
FMI2_Export fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]) {
    for (size_t k = 0; k < n; k++) v[k] = "";
    return fmi2OK;
}
FMI2_OK(fmi2SetDebugLogging, fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[])
FMI2_OK(fmi2SetupExperiment, fmi2Component c, fmi2Boolean b, fmi2Real t, fmi2Real s, fmi2Boolean d, fmi2Real e)
FMI2_OK(fmi2EnterInitializationMode, fmi2Component c)
FMI2_OK(fmi2ExitInitializationMode, fmi2Component c)
FMI2_OK(fmi2Terminate, fmi2Component c)
FMI2_OK(fmi2Reset, fmi2Component c)
FMI2_OK(fmi2SetInteger, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[])
FMI2_OK(fmi2SetBoolean, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[])
FMI2_OK(fmi2SetString, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[])
FMI2_OK(fmi2GetFMUstate, fmi2Component c, fmi2FMUstate *s)
FMI2_OK(fmi2SetFMUstate, fmi2Component c, fmi2FMUstate s)
FMI2_OK(fmi2FreeFMUstate, fmi2Component c, fmi2FMUstate *s)
FMI2_OK(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
FMI2_OK(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
FMI2_OK(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
FMI2_OK(fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference u[], size_t n,
        const fmi2ValueReference k[], size_t m, const fmi2Real d[], fmi2Real v[])
FMI2_OK(fmi2SetRealInputDerivatives, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
        const fmi2Real v[])
FMI2_OK(fmi2GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer o[],
        fmi2Real v[])
FMI2_OK(fmi2DoStep, fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean b)
FMI2_OK(fmi2CancelStep, fmi2Component c)
FMI2_OK(fmi2GetStatus, fmi2Component c, const fmi2StatusKind k, fmi2Status *v)
FMI2_OK(fmi2GetRealStatus, fmi2Component c, const fmi2StatusKind k, fmi2Real *v)
FMI2_OK(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind k, fmi2Integer *v)
FMI2_OK(fmi2GetBooleanStatus, fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v)
FMI2_OK(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind k, fmi2String *v)
