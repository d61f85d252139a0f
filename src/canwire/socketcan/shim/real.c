/* The functions that stand behind ours: the C library's, or those of whatever else is preloaded. */
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
