/* C's files on devices: CanWrite sends by fprintf. */
#include "candrv.h"

#include <errno.h>

static ssize_t read_some(void *handle, char *buffer, size_t size)
{
    DWORD count = 0;

    if (!ReadFile(handle, buffer, (DWORD)size, &count, NULL)) {
        errno = EIO;
        return -1;
    }
    return count;
}

static ssize_t write_some(void *handle, const char *buffer, size_t size)
{
    DWORD count = 0;

    if (!WriteFile(handle, buffer, (DWORD)size, &count, NULL)) {
        errno = EIO;
        return 0;
    }
    return count;
}

static int close_it(void *handle)
{
    return CloseHandle(handle) ? 0 : EOF;
}

static DWORD access_of(LPCSTR mode)
{
    if (strchr(mode, '+') != NULL)
        return GENERIC_READ | GENERIC_WRITE;
    return mode[0] == 'r' ? GENERIC_READ : GENERIC_WRITE;
}

FILE *canwire_fopenA(LPCSTR name, LPCSTR mode)
{
    static const cookie_io_functions_t how = {read_some, write_some, NULL, close_it};
    size_t length = name != NULL ? strlen(name) : 0;
    HANDLE handle;
    FILE *file;

    if (length == 0 || mode == NULL) {
        SetLastError(ERROR_INVALID_PARAMETER);
        return NULL;
    }
    if (name[length - 1] != ':') {
        file = fopen(name, mode);
        if (file == NULL)
            SetLastError(errno == ENOENT ? ERROR_FILE_NOT_FOUND : ERROR_ACCESS_DENIED);
        return file;
    }
    handle = CreateFileA(name, access_of(mode), FILE_SHARE_READ | FILE_SHARE_WRITE, NULL, OPEN_EXISTING, 0, NULL);
    if (handle == INVALID_HANDLE_VALUE)
        return NULL;
    file = fopencookie(handle, mode, how);
    if (file == NULL) {
        CloseHandle(handle);
        SetLastError(ERROR_INVALID_PARAMETER);
    }
    return file;
}

FILE *canwire_fopenW(LPCWSTR name, LPCWSTR mode)
{
    char narrow[4096], narrow_mode[16];

    if (name == NULL || mode == NULL || names_narrow(narrow, sizeof narrow, name) < 0 ||
        names_narrow(narrow_mode, sizeof narrow_mode, mode) < 0) {
        SetLastError(ERROR_INVALID_PARAMETER);
        return NULL;
    }
    return canwire_fopenA(narrow, narrow_mode);
}
