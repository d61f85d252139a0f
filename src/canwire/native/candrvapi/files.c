/* CreateFile, ReadFile and WriteFile: on devices and on files. */
#include "candrv.h"

static int is_device(LPCSTR name)
{
    size_t length = strlen(name);

    return length > 0 && name[length - 1] == ':';
}

HANDLE CreateFileA(LPCSTR name, DWORD access, DWORD share, LPSECURITY_ATTRIBUTES security, DWORD creation, DWORD flags,
                   HANDLE template)
{
    (void)security, (void)flags, (void)template;
    if (name == NULL) {
        SetLastError(ERROR_INVALID_PARAMETER);
        return INVALID_HANDLE_VALUE;
    }
    return is_device(name) ? device_open(name, access, share, creation) : plain_open(name, access, creation);
}

HANDLE CreateFileW(LPCWSTR name, DWORD access, DWORD share, LPSECURITY_ATTRIBUTES security, DWORD creation, DWORD flags,
                   HANDLE template)
{
    char narrow[4096];

    if (name == NULL || names_narrow(narrow, sizeof narrow, name) < 0) {
        SetLastError(ERROR_INVALID_PARAMETER);
        return INVALID_HANDLE_VALUE;
    }
    return CreateFileA(narrow, access, share, security, creation, flags, template);
}

BOOL ReadFile(HANDLE handle, LPVOID buffer, DWORD count, LPDWORD read, LPOVERLAPPED overlapped)
{
    struct cw_object *file = cw_handle_get(handle, &plain_kind);
    uint32_t number;
    BOOL done;

    (void)overlapped;
    if (read != NULL)
        *read = 0;
    if (file == NULL) {
        number = device_number(handle);
        return number != 0 ? device_read(number, buffer, count, read) : FALSE;
    }
    done = plain_read(file, buffer, count, read);
    cw_object_release(file);
    return done;
}

BOOL WriteFile(HANDLE handle, LPCVOID buffer, DWORD count, LPDWORD written, LPOVERLAPPED overlapped)
{
    struct cw_object *file = cw_handle_get(handle, &plain_kind);
    uint32_t number;
    BOOL done;

    (void)overlapped;
    if (written != NULL)
        *written = 0;
    if (file == NULL) {
        number = device_number(handle);
        return number != 0 ? device_write(number, buffer, count, written) : FALSE;
    }
    done = plain_write(file, buffer, count, written);
    cw_object_release(file);
    return done;
}
