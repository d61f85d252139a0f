/* alarm and setitimer by the hub's time. */
#include "timed.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/time.h>
#include <unistd.h>

/* What was set before, in `before`; -1 and errno. */
static int set_timer(const struct span *span, struct span *before)
{
    struct request request = {.operation = SET_TIMER};
    size_t size = sizeof *before;

    return ask(&request, span, sizeof *span, before, &size, NULL, 0) < 0 ? -1 : 0;
}

static int64_t ns_of(struct timeval time)
{
    return time.tv_sec * SECOND + time.tv_usec * 1000;
}

static struct timeval of_ns(int64_t ns)
{
    return (struct timeval){ns / SECOND, ns % SECOND / 1000};
}

EXPORT int setitimer(__itimer_which_t which, const struct itimerval *restrict new, struct itimerval *restrict old)
{
    struct span span = {0, 0}, before = {0, 0};

    if (!timed() || which != ITIMER_REAL)
        return REAL(setitimer)(which, new, old);
    if (new != NULL)
        span = (struct span){ns_of(new->it_value), ns_of(new->it_interval)};
    if (set_timer(&span, &before) < 0)
        return -1;
    if (old != NULL)
        *old = (struct itimerval){of_ns(before.then_ns), of_ns(before.first_ns)};
    return 0;
}

EXPORT unsigned alarm(unsigned seconds)
{
    struct span span = {seconds * SECOND, 0}, before = {0, 0};

    if (!timed())
        return REAL(alarm)(seconds);
    set_timer(&span, &before);
    return (unsigned)((before.first_ns + SECOND - 1) / SECOND);
}

EXPORT useconds_t ualarm(useconds_t first, useconds_t then)
{
    struct span span = {first * 1000ll, then * 1000ll}, before = {0, 0};

    if (!timed())
        return REAL(ualarm)(first, then);
    set_timer(&span, &before);
    return (useconds_t)(before.first_ns / 1000);
}

/* Until a handler has run. */
static int suspended(const sigset_t *mask)
{
    struct wait wait = {.until_ns = NEVER, .mask = mask};

    while (await_turn(&wait) == 0)
        ;
    return -1;
}

EXPORT int pause(void)
{
    return timed() ? suspended(NULL) : REAL(pause)();
}

EXPORT int sigsuspend(const sigset_t *mask)
{
    return timed() ? suspended(mask) : REAL(sigsuspend)(mask);
}
