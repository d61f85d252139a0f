/* GetLastError, and the names of handles. */
#include "windows_core.h"

static __thread DWORD last_error;

DWORD GetLastError(void)
{
    return last_error;
}

void SetLastError(DWORD code)
{
    last_error = code;
}

int cw_fail(DWORD code)
{
    last_error = code;
    return 0;
}

BOOL CloseHandle(HANDLE object)
{
    return cw_handle_close(object) == 0 ? TRUE : cw_fail(ERROR_INVALID_HANDLE);
}

HANDLE cw_handle_or_fail(struct cw_object *object)
{
    cw_handle made = object != NULL ? cw_handle_new(object) : NULL;

    if (made == NULL) {
        if (object != NULL)
            cw_object_release(object);
        cw_fail(ERROR_NOT_ENOUGH_MEMORY);
    }
    return made;
}
