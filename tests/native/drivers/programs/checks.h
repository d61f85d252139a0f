/* What a program here checks: it ends with the line that does not hold. */
#ifndef CHECKS_H
#define CHECKS_H
#include <stdio.h>
#include <stdlib.h>
#define CHECK(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "%s:%d: %s (error %u)\n", __FILE__, __LINE__, #condition, (unsigned)GetLastError()); \
            exit(1); \
        } \
    } while (0)
/* a call that fails, with this error */
#define FAILS(error, call) \
    do { \
        SetLastError(0); \
        CHECK(!(call)); \
        CHECK(GetLastError() == (error)); \
    } while (0)
#endif
