/* Programs that a program starts: the server looks whether the shim works there, or has to answer its calls itself. */
#include "timed.h"

#include <errno.h>
#include <limits.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

extern char **environ;

/* 1: it preloads nothing, and its calls are to be answered; 2: its loader fails where it is to preload the shim. */
static long tell_server(const char *path)
{
    char whole[PATH_MAX];
    int before = errno;
    long answer = 0;

    if (shim_table != NULL && path != NULL && realpath(path, whole) != NULL)
        answer = note(NOTE_EXEC, whole);
    errno = before;
    return answer;
}

#define MOST_WORDS 4096

/* The same variables, but for the first library of LD_PRELOAD, which is the shim. */
static char *const *without_shim(char *const variables[], char **room, char preloaded[PATH_MAX])
{
    static const char name[] = "LD_PRELOAD=";
    int at = 0, to = 0;

    for (; variables[at] != NULL && to < MOST_WORDS - 1; at++) {
        room[to++] = variables[at];
        if (strncmp(variables[at], name, sizeof name - 1) != 0)
            continue;
        const char *rest = strchr(variables[at], ':');
        if (rest == NULL || strlen(rest) + sizeof name > PATH_MAX)
            to--;
        else
            room[to - 1] = strcat(strcpy(preloaded, name), rest + 1);
    }
    room[to] = NULL;
    return room;
}

static int start(const char *path, const char *name, char *const words[], char *const variables[])
{
    char *room[MOST_WORDS], preloaded[PATH_MAX];

    leave_if_begun();
    long what = tell_server(path);
    int error = what > 0 ? canwire_supervise() : 0;
    if (error != 0)
        note(NOTE_NOT_SUPERVISED, strerrorname_np(error));
    if (what == 2)
        variables = without_shim(variables, room, preloaded);
    return name == path ? REAL(execve)(path, words, variables) : REAL(execvpe)(name, words, variables);
}

/* What the C library would start by this name; NULL: nothing. */
static const char *looked_up(const char *name, char *room)
{
    const char *places = getenv("PATH");

    if (name == NULL || strchr(name, '/') != NULL)
        return name;
    for (const char *at = places != NULL ? places : "/bin:/usr/bin"; *at != '\0';) {
        size_t length = strcspn(at, ":"), rest = strlen(name);
        if (length > 0 && length + rest + 2 < PATH_MAX) {
            memcpy(room, at, length);
            room[length] = '/';
            memcpy(room + length + 1, name, rest + 1);
            if (access(room, X_OK) == 0)
                return room;
        }
        at += length + (at[length] == ':');
    }
    return NULL;
}

EXPORT int execve(const char *path, char *const words[], char *const variables[])
{
    return start(path, path, words, variables);
}

EXPORT int execv(const char *path, char *const words[])
{
    return start(path, path, words, environ);
}

EXPORT int execvp(const char *name, char *const words[])
{
    char room[PATH_MAX];

    return start(looked_up(name, room), name, words, environ);
}

EXPORT int execvpe(const char *name, char *const words[], char *const variables[])
{
    char room[PATH_MAX];

    return start(looked_up(name, room), name, words, variables);
}

/* Words up to NULL; 0: too many. */
static int gathered(char **words, const char *first, va_list rest)
{
    int count = 0;

    for (words[0] = (char *)first; words[count] != NULL; words[count] = va_arg(rest, char *))
        if (++count == MOST_WORDS)
            return errno = E2BIG, 0;
    return 1;
}

EXPORT int execl(const char *path, const char *first, ...)
{
    char *words[MOST_WORDS];
    va_list rest;

    va_start(rest, first);
    int whole = gathered(words, first, rest);
    va_end(rest);
    return whole ? execv(path, words) : -1;
}

EXPORT int execlp(const char *name, const char *first, ...)
{
    char *words[MOST_WORDS];
    va_list rest;

    va_start(rest, first);
    int whole = gathered(words, first, rest);
    va_end(rest);
    return whole ? execvp(name, words) : -1;
}

EXPORT int execle(const char *path, const char *first, ...)
{
    char *words[MOST_WORDS];
    va_list rest;

    va_start(rest, first);
    int whole = gathered(words, first, rest);
    char **variables = whole ? va_arg(rest, char **) : NULL;
    va_end(rest);
    return whole ? execve(path, words, variables) : -1;
}

/* What is started so has no moment of its own before it runs: where its calls would have to be answered, it is named. */
static void name_spawned(const char *path)
{
    if (tell_server(path) > 0)
        note(NOTE_NOT_SUPERVISED, "posix_spawn");
}

EXPORT int posix_spawn(pid_t *process, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const words[], char *const variables[])
{
    name_spawned(path);
    return REAL(posix_spawn)(process, path, actions, attributes, words, variables);
}

EXPORT int posix_spawnp(pid_t *process, const char *name, const posix_spawn_file_actions_t *actions,
                        const posix_spawnattr_t *attributes, char *const words[], char *const variables[])
{
    char room[PATH_MAX];

    name_spawned(looked_up(name, room));
    return REAL(posix_spawnp)(process, name, actions, attributes, words, variables);
}
