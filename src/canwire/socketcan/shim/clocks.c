/* What time it is, and sleeping: by the hub's time where programs keep it together, else the C library's. */
#include "timed.h"

#include <errno.h>
#include <sys/time.h>
#include <unistd.h>

static int kept(clockid_t clock) /* every clock but those that tell how long something has computed */
{
    return timed() && clock != CLOCK_PROCESS_CPUTIME_ID && clock != CLOCK_THREAD_CPUTIME_ID && clock >= 0;
}

static int64_t epoch_ns(clockid_t clock)
{
    return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI
               ? (int64_t)shim_table->epoch_ns
               : 0;
}

static int impossible(const struct timespec *span)
{
    return span->tv_sec < 0 || span->tv_nsec < 0 || span->tv_nsec >= SECOND;
}

EXPORT int clock_gettime(clockid_t clock, struct timespec *time)
{
    if (!kept(clock))
        return REAL(clock_gettime)(clock, time);
    *time = span_of(hub_now_ns() + epoch_ns(clock));
    return 0;
}

EXPORT int gettimeofday(struct timeval *restrict time, void *restrict zone)
{
    struct timespec now;

    if (!timed())
        return REAL(gettimeofday)(time, zone);
    now = span_of(hub_now_ns() + epoch_ns(CLOCK_REALTIME));
    *time = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
    return 0;
}

EXPORT time_t time(time_t *into)
{
    time_t now;

    if (!timed())
        return REAL(time)(into);
    now = (time_t)((hub_now_ns() + epoch_ns(CLOCK_REALTIME)) / SECOND);
    if (into != NULL)
        *into = now;
    return now;
}

/* 0, or an errno; `left` is for a sleep that a signal ends. */
static int slept(int64_t until_ns, struct timespec *left)
{
    if (sleep_until(until_ns) == 0)
        return 0;
    if (left != NULL)
        *left = span_of(until_ns - hub_now_ns());
    return errno;
}

EXPORT int clock_nanosleep(clockid_t clock, int flags, const struct timespec *span, struct timespec *left)
{
    if (!kept(clock))
        return REAL(clock_nanosleep)(clock, flags, span, left);
    if (impossible(span))
        return EINVAL;
    if (flags & TIMER_ABSTIME)
        return slept(span->tv_sec * SECOND + span->tv_nsec - epoch_ns(clock), NULL);
    return slept(wait_end_ns(span), left);
}

EXPORT int nanosleep(const struct timespec *span, struct timespec *left)
{
    if (!timed())
        return REAL(nanosleep)(span, left);
    int error = impossible(span) ? EINVAL : slept(wait_end_ns(span), left);
    if (error != 0)
        errno = error;
    return error != 0 ? -1 : 0;
}

EXPORT int usleep(useconds_t microseconds)
{
    return timed() ? sleep_until(hub_now_ns() + microseconds * 1000ll) : REAL(usleep)(microseconds);
}

EXPORT unsigned sleep(unsigned seconds)
{
    if (!timed())
        return REAL(sleep)(seconds);
    int64_t until_ns = hub_now_ns() + seconds * SECOND;
    return sleep_until(until_ns) == 0 ? 0 : (unsigned)((until_ns - hub_now_ns() + SECOND / 2) / SECOND);
}
