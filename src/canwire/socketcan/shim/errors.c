/* What poll tells of a CAN socket that the socket below does not: POLLERR, and what a mapped ring has.
 *
 * The server keeps the error queues, and the socket below has none. What poll has to tell, POLLERR, is a number in the slot.
 * An empty message wakes who waits, as one does for an error of the socket's. An epoll instance is asked in /proc which descriptors it has, so that nothing has to be kept here: one
 * that does not want EPOLLIN is registered with it nevertheless, and with WOKEN_ONLY.
 */
#include "ring.h"
#include "shim.h"

#include <errno.h>
#include <linux/can.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <time.h>

#define WOKEN_ONLY 0x400u /* EPOLLMSG, which no socket has */
#define MOST_POLLED 1024
#define STEP_MS 20 /* where data waits that the program does not want to hear of */
#define SECOND 1000000000ll

/* As the kernel's sock_recv_errqueue has it: the statistics are the data, and a control message, too. */
ssize_t receive_error(struct slot *slot, struct msghdr *message)
{
    struct request request = {.operation = TAKE_ERROR, .slot = slot_number(slot)};
    char reply[512];
    size_t size = sizeof reply, done = 0;
    uint32_t length;

    if (ask(&request, NULL, 0, reply, &size, NULL, 0) < 0)
        return -1;
    memcpy(&length, reply, sizeof length);
    for (size_t at = 0; at < message->msg_iovlen && done < length; at++) {
        size_t part = message->msg_iov[at].iov_len < length - done ? message->msg_iov[at].iov_len : length - done;
        if (copy_out(message->msg_iov[at].iov_base, reply + sizeof length + done, part) != 0)
            return errno = EFAULT, -1;
        done += part;
    }
    size_t control = size - sizeof length - length, room = message->msg_control != NULL ? message->msg_controllen : 0;
    message->msg_namelen = 0;
    message->msg_flags = MSG_ERRQUEUE | (done < length ? MSG_TRUNC : 0) | (room < control ? MSG_CTRUNC : 0);
    message->msg_controllen = room < control ? room : control;
    if (copy_out(message->msg_control, reply + sizeof length + length, message->msg_controllen) != 0)
        return errno = EFAULT, -1;
    return (ssize_t)done;
}

static struct slot *watched_slot(int fd)
{
    struct slot *slot = shim_table != NULL && shim_table->watched != 0 ? slot_of(fd) : NULL;

    return slot != NULL && (slot->watched || __atomic_load_n(&slot->error, __ATOMIC_RELAXED) != 0) ? slot : NULL;
}

int with_watched(struct pollfd *fds, unsigned long count)
{
    if (shim_table == NULL || shim_table->watched == 0)
        return 0;
    for (unsigned long at = 0; at < count; at++)
        if (watched_slot(fds[at].fd) != NULL)
            return 1;
    return 0;
}

static int readable(int fd, struct slot *slot)
{
    struct pollfd now = {fd, POLLIN, 0};
    char byte;

    if (slot->protocol == PACKET && slot->watched)
        return ring_has_some(fd, slot);
    drop_tokens(fd, slot);
    if (REAL(poll)(&now, 1, 0) <= 0 || !(now.revents & POLLIN))
        return 0;
    return __atomic_load_n(&slot->error, __ATOMIC_RELAXED) == 0 ||
           REAL(recv)(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) != 0; /* the error itself is nothing to read */
}

/* What the program is told of such a descriptor, of which the kernel says this. */
static short told(int fd, struct slot *slot, short events, short found)
{
    int before = errno;

    found = (short)((found & ~(POLLIN | POLLRDNORM)) | (readable(fd, slot) ? POLLIN | POLLRDNORM : 0));
    if (__atomic_load_n(&slot->queued_errors, __ATOMIC_ACQUIRE) != 0 ||
        __atomic_load_n(&slot->error, __ATOMIC_RELAXED) != 0)
        found |= POLLERR;
    errno = before;
    return (short)(found & (events | POLLERR | POLLHUP | POLLNVAL));
}

int polled_once(struct pollfd *fds, unsigned long count, const sigset_t *mask)
{
    static const struct timespec none;
    int found = REAL(ppoll)(fds, count, &none, mask);

    if (found < 0 || !with_watched(fds, count))
        return found;
    found = 0;
    for (unsigned long at = 0; at < count; at++) {
        struct slot *slot = watched_slot(fds[at].fd);
        if (slot != NULL)
            fds[at].revents = told(fds[at].fd, slot, fds[at].events, fds[at].revents);
        found += fds[at].revents != 0;
    }
    return found;
}

static int64_t clock_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * SECOND + now.tv_nsec;
}

/* Until something comes, as far as the kernel knows, or the step is over; -1: a signal. */
static int wait_for_any(const struct pollfd *fds, unsigned long count, int64_t left_ns, const sigset_t *mask)
{
    struct pollfd all[MOST_POLLED];
    int64_t step_ns = left_ns;

    for (unsigned long at = 0; at < count; at++) {
        all[at] = fds[at];
        if (watched_slot(fds[at].fd) == NULL)
            continue;
        struct pollfd readable = {fds[at].fd, POLLIN, 0};
        if (!(fds[at].events & POLLIN) && REAL(poll)(&readable, 1, 0) > 0)
            step_ns = step_ns < STEP_MS * 1000000ll ? step_ns : STEP_MS * 1000000ll;
        else
            all[at].events |= POLLIN;
    }
    struct timespec span = {(time_t)(step_ns / SECOND), (long)(step_ns % SECOND)};
    return REAL(ppoll)(all, count, step_ns == INT64_MAX ? NULL : &span, mask);
}

int poll_watched(struct pollfd *fds, unsigned long count, const struct timespec *span, const sigset_t *mask)
{
    int64_t end_ns = span == NULL ? INT64_MAX : clock_ns() + span->tv_sec * SECOND + span->tv_nsec;

    if (count > MOST_POLLED)
        return REAL(ppoll)(fds, count, span, mask);
    for (;;) {
        int found = polled_once(fds, count, mask);
        int64_t left_ns = end_ns == INT64_MAX ? end_ns : end_ns - clock_ns();
        if (found != 0 || left_ns <= 0)
            return found;
        if (wait_for_any(fds, count, left_ns, mask) < 0)
            return -1;
    }
}

/* epoll */

EXPORT int epoll_ctl(int epoll, int operation, int fd, struct epoll_event *event)
{
    struct slot *slot = operation == EPOLL_CTL_DEL || event == NULL ? NULL : slot_of(fd);
    struct epoll_event changed;

    if (slot == NULL || (slot->protocol != CAN_J1939 && slot->protocol != CAN_ISOTP) || event->events & EPOLLIN)
        return REAL(epoll_ctl)(epoll, operation, fd, event);
    changed = *event;
    changed.events |= EPOLLIN | WOKEN_ONLY;
    return REAL(epoll_ctl)(epoll, operation, fd, &changed);
}

/* Have the events of one descriptor among those found told as poll does; how many there are then. */
static int put_event(struct epoll_event *events, int found, int most, int fd, const struct epoll_event *registered)
{
    struct slot *slot = watched_slot(fd);
    int at = 0;

    if (slot == NULL || !(registered->events & EPOLLERR)) /* EPOLLONESHOT: not now */
        return found;
    while (at < found && events[at].data.u64 != registered->data.u64)
        at++;
    short wanted = (short)(registered->events & (registered->events & WOKEN_ONLY ? ~(uint32_t)POLLIN : ~0u));
    short now = told(fd, slot, wanted, at < found ? (short)events[at].events : 0);
    if (now == 0 && at < found)
        events[at] = events[--found];
    else if (now != 0 && (at < found || found < most)) {
        events[at] = (struct epoll_event){.events = (uint32_t)now, .data = registered->data};
        found += at == found;
    }
    return found;
}

int with_watched_of(int epoll, struct epoll_event *events, int found, int most)
{
    char name[32], line[256];
    struct epoll_event registered;
    unsigned long long data;
    int fd;

    snprintf(name, sizeof name, "/proc/self/fdinfo/%d", epoll);
    FILE *file = fopen(name, "re");
    while (file != NULL && fgets(line, sizeof line, file) != NULL)
        if (sscanf(line, "tfd: %d events: %x data: %llx", &fd, &registered.events, &data) == 3) {
            registered.data.u64 = data;
            found = put_event(events, found, most, fd, &registered);
        }
    if (file != NULL)
        fclose(file);
    return found;
}

int epolled_once(int fd, struct epoll_event *events, int most, const sigset_t *mask)
{
    int found = REAL(epoll_pwait)(fd, events, most, 0, mask);

    return found < 0 || shim_table == NULL || shim_table->watched == 0 ? found : with_watched_of(fd, events, found, most);
}

int epoll_watched(int fd, struct epoll_event *events, int most, int milliseconds, const sigset_t *mask)
{
    int64_t end_ns = milliseconds < 0 ? INT64_MAX : clock_ns() + milliseconds * 1000000ll;

    for (;;) {
        int found = epolled_once(fd, events, most, mask);
        int64_t left_ns = end_ns == INT64_MAX ? end_ns : end_ns - clock_ns();
        if (found != 0 || left_ns <= 0)
            return found;
        int left_ms = left_ns == INT64_MAX ? -1 : (int)(left_ns / 1000000 + 1);
        found = REAL(epoll_pwait)(fd, events, most, left_ms, mask);
        if (found < 0)
            return -1;
        if (found > 0 && epolled_once(fd, events, most, mask) == 0) { /* data that the program does not want to hear of */
            struct timespec step = {0, STEP_MS * 1000000l};
            nanosleep(&step, NULL);
        }
    }
}
