/* The functions that stand behind ours: the C library's, or those of whatever else is preloaded. */
#define _GNU_SOURCE
#include "shim.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

void *real_function(const char *name)
{
    void *function = dlsym(RTLD_NEXT, name);

    if (function == NULL) {
        fprintf(stderr, "canwire: the C library has no %s, for which the shim stands in\n", name);
        abort();
    }
    return function;
}

/* x86's C library has two of each condition's functions: those before 2.3.2 work on another structure. */
void *newer_function(const char *name)
{
    void *function = dlvsym(RTLD_NEXT, name, "GLIBC_2.3.2");

    return function != NULL ? function : real_function(name);
}
