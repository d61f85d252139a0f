/* Programs that a program starts: the server looks whether the shim works there, and says so where it does not. */
#include "shim.h"

#include <errno.h>
#include <limits.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void tell_server(const char *path)
{
    char whole[PATH_MAX];
    int before = errno;

    if (shim_table != NULL && path != NULL && realpath(path, whole) != NULL)
        note(NOTE_EXEC, whole);
    errno = before;
}

EXPORT int execve(const char *path, char *const words[], char *const variables[])
{
    tell_server(path);
    return REAL(execve)(path, words, variables);
}

EXPORT int execv(const char *path, char *const words[])
{
    tell_server(path);
    return REAL(execv)(path, words);
}

EXPORT int posix_spawn(pid_t *process, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const words[], char *const variables[])
{
    tell_server(path);
    return REAL(posix_spawn)(process, path, actions, attributes, words, variables);
}
