/* Files of Linux' by handles: CanRead writes its log so. */
#include "candrv.h"

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

struct plain {
    struct cw_object object;
    int descriptor;
};

static void destroy(struct cw_object *object)
{
    close(((struct plain *)object)->descriptor);
    free(object);
}

const struct cw_kind plain_kind = {"file", destroy, NULL, NULL};

static DWORD code_of(int error)
{
    switch (error) {
    case ENOENT:
    case ENOTDIR:
        return ERROR_FILE_NOT_FOUND;
    case EACCES:
    case EPERM:
    case EROFS:
    case EISDIR:
    case EBADF: /* not opened for that */
        return ERROR_ACCESS_DENIED;
    case EEXIST:
        return ERROR_FILE_EXISTS;
    case EFAULT:
    case EINVAL:
        return ERROR_INVALID_PARAMETER;
    default:
        return ERROR_GEN_FAILURE;
    }
}

static int flags_of(DWORD access, DWORD creation)
{
    static const int how[] = {0, O_CREAT | O_EXCL, O_CREAT | O_TRUNC, 0, O_CREAT, O_TRUNC};
    int both = (access & GENERIC_READ) && (access & GENERIC_WRITE);

    if (creation < CREATE_NEW || creation > TRUNCATE_EXISTING)
        return -1;
    return O_CLOEXEC | how[creation] | (both ? O_RDWR : access & GENERIC_WRITE ? O_WRONLY : O_RDONLY);
}

static HANDLE failed(DWORD code)
{
    SetLastError(code);
    return INVALID_HANDLE_VALUE;
}

HANDLE plain_open(LPCSTR name, DWORD access, DWORD creation)
{
    int flags = flags_of(access, creation);
    int descriptor = flags < 0 ? -1 : open(name, flags, 0666);
    struct plain *file;
    cw_handle handle;

    if (descriptor < 0)
        return failed(flags < 0 ? ERROR_INVALID_PARAMETER : code_of(errno));
    file = malloc(sizeof *file);
    if (file == NULL) {
        close(descriptor);
        return failed(ERROR_NOT_ENOUGH_MEMORY);
    }
    *file = (struct plain){{&plain_kind, 1}, descriptor};
    handle = cw_handle_new(&file->object);
    if (handle == NULL) {
        cw_object_release(&file->object);
        return failed(ERROR_NOT_ENOUGH_MEMORY);
    }
    return handle;
}

static BOOL moved(ssize_t count, LPDWORD out)
{
    if (count < 0)
        return candrv_fail(code_of(errno));
    if (out != NULL)
        *out = (DWORD)count;
    return TRUE;
}

BOOL plain_read(struct cw_object *file, LPVOID buffer, DWORD count, LPDWORD done)
{
    return moved(TEMP_FAILURE_RETRY(read(((struct plain *)file)->descriptor, buffer, count)), done);
}

BOOL plain_write(struct cw_object *file, LPCVOID buffer, DWORD count, LPDWORD done)
{
    return moved(TEMP_FAILURE_RETRY(write(((struct plain *)file)->descriptor, buffer, count)), done);
}
