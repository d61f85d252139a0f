/* Starting the helper: a grandchild in a session of its own, so that the program never hears of a child of ours.
 *
 * The process in the middle sends no SIGCHLD and is invisible to wait(), having been cloned without an exit signal.
 */
#include "start.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#define CHANNEL 3 /* the helper's descriptor */
#define PROGRAM "from canwire.native.helper.main import main; main()" /* -m would load runpy, too */
#define MOST_VARIABLES 16384

extern char **environ;

static int runs(const char *path)
{
    return access(path, X_OK) == 0;
}

/* PREFIX/lib/pythonX.Y/site-packages/canwire/native/lib/libcanwire.so belongs to PREFIX/bin/pythonX.Y; in a source tree
 * ROOT/src/canwire/native/lib/... to ROOT/.venv. */
static int python_of(char *library, char *python)
{
    char *version, *end, *at = strstr(library, "/site-packages/canwire/native/");
    char name[32]; /* "/python3.11" */

    if (at != NULL) {
        *at = '\0';
        version = strrchr(library, '/');
        if (version == NULL || strncmp(version, "/python", 7) != 0)
            return 0;
        snprintf(name, sizeof name, "%s", version);
        *version = '\0';
        end = strrchr(library, '/'); /* lib, or lib64 */
        if (end == NULL)
            return 0;
        *end = '\0';
        return snprintf(python, PATH_MAX, "%s/bin%s", library, name) < PATH_MAX && runs(python);
    }
    at = strstr(library, "/src/canwire/native/");
    if (at == NULL)
        return 0;
    *at = '\0';
    return snprintf(python, PATH_MAX, "%s/.venv/bin/python", library) < PATH_MAX && runs(python);
}

/* CANWIRE_PYTHON, or the one that this library was installed for, or the first in PATH */
static void find_python(char *python, char *library)
{
    const char *given = getenv("CANWIRE_PYTHON");
    char of[PATH_MAX];
    Dl_info about;

    if (dladdr((void *)&find_python, &about) == 0 || realpath(about.dli_fname, library) == NULL)
        *library = '\0';
    snprintf(of, sizeof of, "%s", library);
    if (given != NULL && *given != '\0')
        snprintf(python, PATH_MAX, "%s", given);
    else if (!python_of(of, python))
        snprintf(python, PATH_MAX, "python3");
}

/* The helper is no part of what is preloaded into the program: sanitizers, other shims. */
static char **variables(void)
{
    size_t count = 0, kept = 0;
    char **all;

    while (environ != NULL && environ[count] != NULL && count < MOST_VARIABLES)
        count++;
    all = calloc(count + 1, sizeof *all);
    for (size_t k = 0; all != NULL && k < count; k++)
        if (strncmp(environ[k], "LD_PRELOAD=", 11) != 0)
            all[kept++] = environ[k];
    return all;
}

static void become(int channel, const char *python, char *const words[], char *const settings[])
{
    sigset_t none;
    int nowhere;

    setsid();
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    if (channel != CHANNEL)
        dup2(channel, CHANNEL);
    else
        fcntl(CHANNEL, F_SETFD, 0);
    syscall(SYS_close_range, CHANNEL + 1, ~0u, 0);
    nowhere = open("/dev/null", O_RDWR);
    if (nowhere >= 0) {
        dup2(nowhere, 0);
        dup2(nowhere, 1);
        close(nowhere);
    }
    execvpe(python, words, settings);
    _exit(127);
}

int cw_start_helper(int channel)
{
    char python[PATH_MAX], library[PATH_MAX], parent[16], warm[CW_WARM_NAME];
    char *words[] = {python, "-P", "-c", PROGRAM, parent, program_invocation_short_name, warm, NULL};
    char **settings = variables();
    sigset_t all, before;
    long middle;
    int status = 0;

    if (settings == NULL)
        return -1;
    find_python(python, library);
    snprintf(parent, sizeof parent, "%d", (int)getpid());
    cw_warm_name(warm, python, library, settings);
    if (*warm != '\0' && cw_warm_start(warm, channel, words + 4, settings) == 0) {
        free(settings);
        return 0;
    }
    sigfillset(&all); /* no handler of the program's runs in the process in the middle */
    pthread_sigmask(SIG_SETMASK, &all, &before);
    middle = syscall(SYS_clone, 0, NULL, NULL, NULL, NULL);
    if (middle == 0) {
        if (syscall(SYS_clone, SIGCHLD, NULL, NULL, NULL, NULL) == 0)
            become(channel, python, words, settings);
        _exit(0);
    }
    if (middle > 0)
        while (waitpid((pid_t)middle, &status, __WCLONE) < 0 && errno == EINTR)
            ;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    free(settings);
    return middle > 0 ? 0 : -1;
}
