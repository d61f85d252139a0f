/* timerfd by the hub's time: an eventfd, whose other copy the server counts up whenever the timer goes off. */
#include "timed.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/timerfd.h>
#include <unistd.h>

#define MOST 1024

static int32_t timers[MOST]; /* by descriptor: the server's number for it, from 1 up */

/* The server's number; 0: no timer of ours. A descriptor that was closed may be something else by now. */
static int32_t number_of(int fd)
{
    static const char expected[] = "anon_inode:[eventfd]";
    char path[32], target[sizeof expected];

    if (!timed() || fd < 0 || fd >= MOST || timers[fd] == 0)
        return 0;
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(path, target, sizeof target);
    return length == sizeof expected - 1 && memcmp(target, expected, (size_t)length) == 0 ? timers[fd] : 0;
}

int is_timer(int fd)
{
    return number_of(fd) != 0;
}

ssize_t read_timer(int fd, void *buffer, size_t size)
{
    struct wait wait = {.until_ns = NEVER, .restarts = 1};
    struct pollfd one = {fd, POLLIN, 0};

    while (!(fcntl(fd, F_GETFL) & O_NONBLOCK) && REAL(poll)(&one, 1, 0) == 0)
        if (await_turn(&wait) < 0)
            return -1;
    return REAL(read)(fd, buffer, size);
}

static int64_t epoch_of(clockid_t clock)
{
    return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_ALARM ? (int64_t)shim_table->epoch_ns : 0;
}

static clockid_t clocks[MOST];

EXPORT int timerfd_create(clockid_t clock, int flags)
{
    struct request request = {.operation = OPEN_TIMER, .a = (flags & TFD_NONBLOCK) != 0};
    int fd = -1;

    if (!timed())
        return REAL(timerfd_create)(clock, flags);
    if (flags & ~(TFD_NONBLOCK | TFD_CLOEXEC)) {
        errno = EINVAL;
        return -1;
    }
    long number = ask(&request, NULL, 0, NULL, NULL, &fd, (flags & TFD_CLOEXEC) != 0);
    if (number < 0)
        return -1;
    if (fd < 0 || fd >= MOST) {
        if (fd >= 0)
            close(fd);
        errno = EMFILE;
        return -1;
    }
    timers[fd] = (int32_t)number;
    clocks[fd] = clock;
    return fd;
}

static int64_t ns_of(struct timespec time)
{
    return time.tv_sec * SECOND + time.tv_nsec;
}

static int impossible(struct timespec time)
{
    return time.tv_sec < 0 || time.tv_sec > NEVER / SECOND / 2 || time.tv_nsec < 0 || time.tv_nsec >= SECOND;
}

/* `changes`: to this span. What was set before is in `was`. */
static int asked(int32_t number, int changes, const struct span *span, struct itimerspec *was)
{
    struct request request = {.operation = SET_TIMER_FD, .slot = number, .a = changes};
    struct span before = {0, 0};
    size_t size = sizeof before;

    if (ask(&request, span, sizeof *span, &before, &size, NULL, 0) < 0)
        return -1;
    if (was != NULL)
        *was = (struct itimerspec){span_of(before.then_ns), span_of(before.first_ns)};
    return 0;
}

int set_kept_timer(int32_t number, clockid_t clock, int absolute, const struct itimerspec *new, struct itimerspec *old)
{
    struct span span = {ns_of(new->it_value), ns_of(new->it_interval)};

    if (impossible(new->it_value) || impossible(new->it_interval)) {
        errno = EINVAL;
        return -1;
    }
    if (span.first_ns > 0 && absolute) {
        span.first_ns -= epoch_of(clock) + hub_now_ns();
        if (span.first_ns <= 0)
            span.first_ns = 1; /* it is over: now */
    }
    return asked(number, 1, &span, old);
}

int look_at_timer(int32_t number, struct itimerspec *now)
{
    static const struct span none;

    return asked(number, 0, &none, now);
}

EXPORT int timerfd_settime(int fd, int flags, const struct itimerspec *new, struct itimerspec *old)
{
    int32_t number = number_of(fd);

    if (number == 0)
        return REAL(timerfd_settime)(fd, flags, new, old);
    if (flags & ~(TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET)) {
        errno = EINVAL;
        return -1;
    }
    return set_kept_timer(number, clocks[fd], flags & TFD_TIMER_ABSTIME, new, old);
}

EXPORT int timerfd_gettime(int fd, struct itimerspec *now)
{
    int32_t number = number_of(fd);

    return number == 0 ? REAL(timerfd_gettime)(fd, now) : look_at_timer(number, now);
}
