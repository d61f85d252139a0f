/* Paths below /sys/class/net and /proc/net/can, and /proc/net/dev: the server has such folders, its interfaces among them. */
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

#define BEGIN 14 /* characters of FOLDER, and at least those of what is below /proc/net */
#define FOLDER "/sys/class/net"

/* Of a path of /proc/net that is served, what comes after that; NULL: it is the kernel's. */
static const char *below_proc(const char *path)
{
    static const char *const begins[] = {"/proc/net/", "/proc/self/net/"};

    for (int at = 0; at < 2; at++) {
        size_t length = strlen(begins[at]);
        const char *name = path + length;
        if (strncmp(path, begins[at], length) == 0 &&
            (strcmp(name, "dev") == 0 || (strncmp(name, "can", 3) == 0 && (name[3] == '\0' || name[3] == '/'))))
            return name;
    }
    return NULL;
}

static const char *meant_in_proc(const char *path, const char *directory, char room[PATH_MAX])
{
    struct request request = {.operation = PLACE_FILES, .a = PROC_FOLDER};
    const char *name = below_proc(path);
    int before = errno;

    if (name != NULL && snprintf(room, PATH_MAX, "%s/proc/%s", directory, name) < PATH_MAX &&
        ask(&request, NULL, 0, NULL, NULL, NULL, 0) >= 0)
        path = room;
    errno = before;
    return path;
}

/* The path that is meant, in `room` where that is another one. */
static const char *meant(const char *path, char room[PATH_MAX])
{
    const char *directory = getenv("CANWIRE_SOCKETCAN");
    struct request request = {.operation = PLACE_FILES};
    char begin[BEGIN];
    int before = errno;

    if (shim_table == NULL || directory == NULL || path == NULL || copy_in(begin, path, 1) != 0)
        return path;
    if (strncmp(path, "/proc/", 6) == 0)
        return meant_in_proc(path, directory, room);
    if (strncmp(path, FOLDER, BEGIN) != 0 || (path[BEGIN] != '\0' && path[BEGIN] != '/'))
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
