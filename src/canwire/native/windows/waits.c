/* Events, and waiting for handles of every kind. */
#include "windows_core.h"

HANDLE CreateEventA(LPSECURITY_ATTRIBUTES rights, BOOL manual_reset, BOOL signalled, LPCSTR name)
{
    (void)rights, (void)name;
    return cw_handle_or_fail((struct cw_object *)cw_event_new(manual_reset, signalled));
}

HANDLE CreateEventW(LPSECURITY_ATTRIBUTES rights, BOOL manual_reset, BOOL signalled, LPCWSTR name)
{
    (void)name;
    return CreateEventA(rights, manual_reset, signalled, NULL);
}

static BOOL on_event(HANDLE event, void (*change)(struct cw_event *))
{
    struct cw_object *found = cw_handle_get(event, &cw_event_kind);

    if (found == NULL)
        return cw_fail(ERROR_INVALID_HANDLE);
    change((struct cw_event *)found);
    cw_object_release(found);
    return TRUE;
}

BOOL SetEvent(HANDLE event)
{
    return on_event(event, cw_event_set);
}

BOOL ResetEvent(HANDLE event)
{
    return on_event(event, cw_event_reset);
}

/* Whoever waits has seen the signal once the scheduler lets it: as unreliable as Windows' own. */
static void pulse(struct cw_event *event)
{
    cw_event_set(event);
    Sleep(0);
    cw_event_reset(event);
}

BOOL PulseEvent(HANDLE event)
{
    return on_event(event, pulse);
}

DWORD WaitForMultipleObjects(DWORD count, const HANDLE *objects, BOOL all, DWORD milliseconds)
{
    int found = cw_wait(objects, count, all, milliseconds == INFINITE ? CW_FOR_EVER : (int64_t)milliseconds);

    if (found != CW_WAIT_FAILED)
        return (DWORD)found;
    cw_fail(objects == NULL || count == 0 || count > MAXIMUM_WAIT_OBJECTS ? ERROR_INVALID_PARAMETER
                                                                         : ERROR_INVALID_HANDLE);
    return WAIT_FAILED;
}

DWORD WaitForMultipleObjectsEx(DWORD count, const HANDLE *objects, BOOL all, DWORD milliseconds, BOOL alertable)
{
    (void)alertable;
    return WaitForMultipleObjects(count, objects, all, milliseconds);
}

DWORD WaitForSingleObject(HANDLE object, DWORD milliseconds)
{
    return WaitForMultipleObjects(1, &object, FALSE, milliseconds);
}

DWORD WaitForSingleObjectEx(HANDLE object, DWORD milliseconds, BOOL alertable)
{
    (void)alertable;
    return WaitForSingleObject(object, milliseconds);
}
