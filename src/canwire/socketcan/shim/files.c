/* Paths below /sys/class/net: the server has such a folder, where its interfaces are beside the kernel's. */
#include "shim.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FOLDER "/sys/class/net"
#define BEGIN (sizeof FOLDER - 1)

/* The path that is meant, in `room` where that is another one. */
static const char *meant(const char *path, char room[PATH_MAX])
{
    const char *directory = getenv("CANWIRE_SOCKETCAN");
    struct request request = {.operation = PLACE_FILES};
    char begin[BEGIN];
    int before = errno;

    if (shim_table == NULL || directory == NULL || path == NULL || copy_in(begin, path, BEGIN) != 0 ||
        memcmp(begin, FOLDER, BEGIN) != 0 || (path[BEGIN] != '\0' && path[BEGIN] != '/'))
        return path;
    const char *name = path + BEGIN + strspn(path + BEGIN, "/");
    size_t length = strcspn(name, "/");
    char first[NAME_MAX + 1] = "";
    if (length > NAME_MAX || snprintf(room, PATH_MAX, "%s/net/%s", directory, name) >= PATH_MAX)
        return path;
    memcpy(first, name, length);
    if ((length == 0 || interface_by_name(first) != NULL) &&
        ask(&request, first, length, NULL, NULL, NULL, 0) >= 0)
        path = room;
    errno = before;
    return path;
}

static mode_t mode_of(int flags, va_list rest)
{
    return flags & (O_CREAT | O_TMPFILE) ? (mode_t)va_arg(rest, int) : 0;
}

#define OPENS(name)                                                                                                    \
    EXPORT int name(const char *path, int flags, ...)                                                                  \
    {                                                                                                                  \
        char room[PATH_MAX];                                                                                           \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = mode_of(flags, rest);                                                                            \
        va_end(rest);                                                                                                  \
        return REAL(name)(meant(path, room), flags, mode);                                                             \
    }
#define OPENS_AT(name)                                                                                                 \
    EXPORT int name(int folder, const char *path, int flags, ...)                                                      \
    {                                                                                                                  \
        char room[PATH_MAX];                                                                                           \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode_t mode = mode_of(flags, rest);                                                                            \
        va_end(rest);                                                                                                  \
        return REAL(name)(folder, meant(path, room), flags, mode);                                                     \
    }
#define OF_PATH(result, name, parameters, ...)                                                                         \
    EXPORT result name parameters                                                                                      \
    {                                                                                                                  \
        char room[PATH_MAX];                                                                                           \
        return REAL(name)(__VA_ARGS__);                                                                                \
    }

OPENS(open)
OPENS(open64)
OPENS_AT(openat)
OPENS_AT(openat64)
OF_PATH(FILE *, fopen, (const char *restrict path, const char *restrict mode), meant(path, room), mode)
OF_PATH(FILE *, fopen64, (const char *restrict path, const char *restrict mode), meant(path, room), mode)
OF_PATH(DIR *, opendir, (const char *path), meant(path, room))
OF_PATH(int, access, (const char *path, int mode), meant(path, room), mode)
OF_PATH(int, stat, (const char *restrict path, struct stat *restrict into), meant(path, room), into)
OF_PATH(int, stat64, (const char *restrict path, struct stat64 *restrict into), meant(path, room), into)
OF_PATH(int, lstat, (const char *restrict path, struct stat *restrict into), meant(path, room), into)
OF_PATH(int, lstat64, (const char *restrict path, struct stat64 *restrict into), meant(path, room), into)
OF_PATH(int, fstatat, (int folder, const char *restrict path, struct stat *restrict into, int flags), folder,
        meant(path, room), into, flags)
OF_PATH(int, fstatat64, (int folder, const char *restrict path, struct stat64 *restrict into, int flags), folder,
        meant(path, room), into, flags)
OF_PATH(int, statx, (int folder, const char *restrict path, int flags, unsigned mask, struct statx *restrict into), folder,
        meant(path, room), flags, mask, into)
