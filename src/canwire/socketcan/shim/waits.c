/* poll, select, epoll: where programs keep one time, they look at each turn, and the timeout is the hub's. */
#include "timed.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>

static struct timespec of_milliseconds(int milliseconds)
{
    return (struct timespec){milliseconds / 1000, milliseconds % 1000 * 1000000l};
}

static int polled(struct pollfd *fds, nfds_t count, struct wait *wait)
{
    for (;;) {
        int found = polled_once(fds, count, wait->mask);
        if (found != 0 || (wait->again && expired(wait)))
            return found;
        if (await_turn(wait) < 0)
            return -1;
    }
}

EXPORT int poll(struct pollfd *fds, nfds_t count, int timeout)
{
    struct timespec span = of_milliseconds(timeout);
    if (with_watched(fds, count) && (timeout == 0 || !timed()))
        return poll_watched(fds, count, timeout < 0 ? NULL : &span, NULL);
    if (timeout == 0 || !timed())
    {
        int found = REAL(poll)(fds, count, timeout);
        return found > 0 && with_watched(fds, count) ? poll_watched(fds, count, timeout < 0 ? NULL : &span, NULL) : found;
    }
    struct wait wait = {.until_ns = wait_end_ns(timeout < 0 ? NULL : &span)};
    return polled(fds, count, &wait);
}

EXPORT int ppoll(struct pollfd *fds, nfds_t count, const struct timespec *span, const sigset_t *mask)
{
    int at_once = !timed() || (span != NULL && span->tv_sec == 0 && span->tv_nsec == 0);
    if (at_once && with_watched(fds, count))
        return poll_watched(fds, count, span, mask);
    if (at_once)
    {
        int found = REAL(ppoll)(fds, count, span, mask);
        return found > 0 && with_watched(fds, count) ? poll_watched(fds, count, span, mask) : found;
    }
    struct wait wait = {.until_ns = wait_end_ns(span), .mask = mask};
    return polled(fds, count, &wait);
}

struct sets { /* as many bits as the program's sets have; copies, since a look changes them */
    size_t size;
    fd_set *theirs[3];
    char *copy[3];
};

static int keep_sets(struct sets *sets, int count, fd_set *reads, fd_set *writes, fd_set *others)
{
    sets->size = ((size_t)count + 63) / 64 * 8;
    sets->theirs[0] = reads, sets->theirs[1] = writes, sets->theirs[2] = others;
    char *room = malloc(3 * sets->size + 1);
    for (int at = 0; room != NULL && at < 3; at++) {
        sets->copy[at] = room + (size_t)at * sets->size;
        if (sets->theirs[at] != NULL)
            memcpy(sets->copy[at], sets->theirs[at], sets->size);
    }
    if (room == NULL)
        errno = ENOMEM;
    return room != NULL ? 0 : -1;
}

/* Those that have some are readable, whatever the kernel says. */
static int add_rings(int count, const fd_set *wanted, fd_set *reads, int found)
{
    for (int fd = 0; fd < count; fd++) {
        fd_set one;
        FD_ZERO(&one);
        FD_SET(fd, &one);
        if (FD_ISSET(fd, wanted) && !FD_ISSET(fd, reads) && rings_ready(fd + 1, &one)) {
            FD_SET(fd, reads);
            found++;
        }
    }
    return found;
}

/* pselect, but what waits in a socket that has a mapped ring is old: only the ring says whether there is something. */
static int select_with_rings(int count, fd_set *reads, fd_set *writes, fd_set *others, const struct timespec *span,
                             const sigset_t *mask)
{
    static const struct timespec none;
    fd_set wanted;

    if (reads == NULL || count < 0 || count > FD_SETSIZE || shim_table == NULL || shim_table->watched == 0)
        return REAL(pselect)(count, reads, writes, others, span, mask);
    memcpy(&wanted, reads, ((size_t)count + 63) / 64 * 8);
    int ready = rings_ready(count, &wanted);
    int found = REAL(pselect)(count, reads, writes, others, ready ? &none : span, mask);
    return found < 0 || !ready ? found : add_rings(count, &wanted, reads, found);
}

static int selected(int count, struct sets *sets, struct wait *wait)
{
    static const struct timespec none;

    for (;;) {
        int found = select_with_rings(count, sets->theirs[0], sets->theirs[1], sets->theirs[2], &none, wait->mask);
        if (found != 0 || (wait->again && expired(wait)))
            return found;
        if (await_turn(wait) < 0)
            return -1;
        for (int at = 0; at < 3; at++)
            if (sets->theirs[at] != NULL)
                memcpy(sets->theirs[at], sets->copy[at], sets->size);
    }
}

static int select_by_turns(int count, fd_set *reads, fd_set *writes, fd_set *others, struct wait *wait)
{
    struct sets sets;

    if (count < 0) {
        errno = EINVAL;
        return -1;
    }
    if (keep_sets(&sets, count, reads, writes, others) < 0)
        return -1;
    int found = selected(count, &sets, wait);
    int before = errno;
    free(sets.copy[0]);
    errno = before;
    return found;
}

EXPORT int select(int count, fd_set *restrict reads, fd_set *restrict writes, fd_set *restrict others,
                  struct timeval *restrict timeout)
{
    int at_once = !timed() || (timeout != NULL && timeout->tv_sec == 0 && timeout->tv_usec == 0);
    if (at_once && (shim_table == NULL || shim_table->watched == 0))
        return REAL(select)(count, reads, writes, others, timeout);
    struct timespec span = {0, 0};
    if (timeout != NULL)
        span = (struct timespec){timeout->tv_sec + timeout->tv_usec / 1000000, timeout->tv_usec % 1000000 * 1000};
    if (at_once)
        return select_with_rings(count, reads, writes, others, timeout != NULL ? &span : NULL, NULL);
    struct wait wait = {.until_ns = wait_end_ns(timeout != NULL ? &span : NULL)};
    int found = select_by_turns(count, reads, writes, others, &wait);
    if (timeout != NULL) { /* Linux tells what was left */
        span = span_of(wait.until_ns - hub_now_ns());
        *timeout = (struct timeval){span.tv_sec, span.tv_nsec / 1000};
    }
    return found;
}

EXPORT int pselect(int count, fd_set *restrict reads, fd_set *restrict writes, fd_set *restrict others,
                   const struct timespec *restrict span, const sigset_t *restrict mask)
{
    if (!timed() || (span != NULL && span->tv_sec == 0 && span->tv_nsec == 0))
        return select_with_rings(count, reads, writes, others, span, mask);
    struct wait wait = {.until_ns = wait_end_ns(span), .mask = mask};
    return select_by_turns(count, reads, writes, others, &wait);
}

static int epolled(int fd, struct epoll_event *events, int most, struct wait *wait)
{
    for (;;) {
        int found = epolled_once(fd, events, most, wait->mask);
        if (found != 0 || (wait->again && expired(wait)))
            return found;
        if (await_turn(wait) < 0)
            return -1;
    }
}

/* The kernel's wait, in which an error may have come. */
static int waited_on(int fd, struct epoll_event *events, int most, int timeout, const sigset_t *mask)
{
    int found = REAL(epoll_pwait)(fd, events, most, timeout, mask);

    if (found <= 0 || shim_table == NULL || shim_table->watched == 0)
        return found;
    found = with_watched_of(fd, events, found, most);
    return found > 0 ? found : epoll_watched(fd, events, most, timeout, mask);
}

EXPORT int epoll_pwait(int fd, struct epoll_event *events, int most, int timeout, const sigset_t *mask)
{
    int at_once = timeout == 0 || !timed();
    if (at_once && shim_table != NULL && shim_table->watched != 0)
        return epoll_watched(fd, events, most, timeout, mask);
    if (at_once)
        return waited_on(fd, events, most, timeout, mask);
    struct timespec span = of_milliseconds(timeout);
    struct wait wait = {.until_ns = wait_end_ns(timeout < 0 ? NULL : &span), .mask = mask};
    return epolled(fd, events, most, &wait);
}

int epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *span, const sigset_t *mask);

EXPORT int epoll_pwait2(int fd, struct epoll_event *events, int most, const struct timespec *span,
                        const sigset_t *mask)
{
    if (!timed() || (span != NULL && span->tv_sec == 0 && span->tv_nsec == 0))
        return REAL(epoll_pwait2)(fd, events, most, span, mask);
    struct wait wait = {.until_ns = wait_end_ns(span), .mask = mask};
    return epolled(fd, events, most, &wait);
}

EXPORT int epoll_wait(int fd, struct epoll_event *events, int most, int timeout)
{
    return epoll_pwait(fd, events, most, timeout, NULL);
}

/* what _FORTIFY_SOURCE makes of them */

int __poll_chk(struct pollfd *fds, nfds_t count, int timeout, size_t room);
int __ppoll_chk(struct pollfd *fds, nfds_t count, const struct timespec *span, const sigset_t *mask, size_t room);

EXPORT int __poll_chk(struct pollfd *fds, nfds_t count, int timeout, size_t room)
{
    if (room / sizeof *fds < count)
        abort();
    return poll(fds, count, timeout);
}

EXPORT int __ppoll_chk(struct pollfd *fds, nfds_t count, const struct timespec *span, const sigset_t *mask, size_t room)
{
    if (room / sizeof *fds < count)
        abort();
    return ppoll(fds, count, span, mask);
}
