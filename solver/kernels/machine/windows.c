/* What the C library of Windows, ucrtbase.dll, has by other names than C's or not at all, so that no more is linked. */

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

enum { AS_IN_C = 2 }; /* the length is that of the whole text */

int DllMainCRTStartup(void *library, unsigned reason, void *reserved);

/* The entry of the library: there is nothing to begin or to end. */
int DllMainCRTStartup(void *library, unsigned reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}

int vsnprintf(char *to, size_t size, const char *format, va_list arguments) {
    return __stdio_common_vsprintf(AS_IN_C, to, size, format, NULL, arguments);
}

int snprintf(char *to, size_t size, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(to, size, format, arguments);
    va_end(arguments);
    return length;
}

int __isnan(double value) {
    return value != value;
}

int __fpclassify(double value) {
    return __builtin_fpclassify(FP_NAN, FP_INFINITE, FP_NORMAL, FP_SUBNORMAL, FP_ZERO, value);
}
