/* Waiting for the end of a child: while it takes part in the hub's time, or one of its own children does, the parent waits
 * there; until it does the parent is taken to compute. The server knows which of the two it is.
 */
#include "timed.h"

#include <errno.h>
#include <sys/resource.h>
#include <sys/wait.h>

static int by_turns(int options)
{
    return timed() && keeps_time() && !(options & WNOHANG);
}

/* A turn in which to look; -1 and EINTR. 0 as well where whoever keeps the time is gone: then `own` is set. */
static int await_child(struct wait *wait, int *own)
{
    if (await_turn(wait) == 0)
        return 0;
    if (errno == EINTR)
        return -1;
    *own = 1;
    return 0;
}

EXPORT pid_t wait4(pid_t child, int *status, int options, struct rusage *used)
{
    struct wait wait = {.until_ns = NEVER, .restarts = 1, .child = child > 0 ? child : -1};
    int own = !by_turns(options);

    while (!own) {
        pid_t found = REAL(wait4)(child, status, options | WNOHANG, used);
        if (found != 0)
            return found;
        if (await_child(&wait, &own) < 0)
            return -1;
    }
    return REAL(wait4)(child, status, options, used);
}

EXPORT pid_t waitpid(pid_t child, int *status, int options)
{
    return by_turns(options) ? wait4(child, status, options, NULL) : REAL(waitpid)(child, status, options);
}

EXPORT pid_t wait(int *status)
{
    return waitpid(-1, status, 0);
}

EXPORT pid_t wait3(int *status, int options, struct rusage *used)
{
    return wait4(-1, status, options, used);
}

EXPORT int waitid(idtype_t kind, id_t number, siginfo_t *found, int options)
{
    struct wait wait = {.until_ns = NEVER, .restarts = 1, .child = kind == P_PID ? (pid_t)number : -1};
    siginfo_t room;
    int own = !by_turns(options);

    while (!own) {
        siginfo_t *into = found != NULL ? found : &room;
        into->si_pid = 0;
        int error = REAL(waitid)(kind, number, into, options | WNOHANG);
        if (error != 0 || into->si_pid != 0)
            return error;
        if (await_child(&wait, &own) < 0)
            return -1;
    }
    return REAL(waitid)(kind, number, found, options);
}
