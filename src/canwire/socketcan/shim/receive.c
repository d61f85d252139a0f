/* What programs read: the server's header is taken off, and what it says becomes control messages. */
#include "ring.h"
#include "shim.h"
#include "timed.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/j1939.h>
#include <linux/net_tstamp.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

struct arrival { /* the oldest message: its first bytes, all of a frame's */
    char data[RECEIVED_PREFIX];
    ssize_t length;
    struct received header;
    struct about about;
};

void put_control(struct msghdr *message, size_t *used, int level, int type, const void *data, size_t length)
{
    size_t room = message->msg_controllen - *used, whole = CMSG_LEN(length);

    if (room < whole)
        message->msg_flags |= MSG_CTRUNC;
    if (room < sizeof(struct cmsghdr))
        return;
    struct cmsghdr *header = (struct cmsghdr *)((char *)message->msg_control + *used);
    header->cmsg_level = level;
    header->cmsg_type = type;
    header->cmsg_len = room < whole ? room : whole; /* as much of it as there is room for, as the kernel does */
    memcpy(CMSG_DATA(header), data, header->cmsg_len - sizeof *header);
    *used += room < CMSG_SPACE(length) ? room : CMSG_SPACE(length);
}

static void put_stamps(const struct slot *slot, const struct received *header, struct msghdr *message, size_t *used)
{
    struct timespec stamp = {(time_t)(header->stamp_ns / 1000000000), (long)(header->stamp_ns % 1000000000)};
    struct timespec stamps[3] = {{0, 0}};
    struct timeval coarse = {stamp.tv_sec, stamp.tv_nsec / 1000};
    uint32_t flags = slot->stamping_flags;

    if (slot->stamp == SO_TIMESTAMPNS || slot->stamp == 64)
        put_control(message, used, SOL_SOCKET, (int)slot->stamp, &stamp, sizeof stamp);
    else if (slot->stamp != 0)
        put_control(message, used, SOL_SOCKET, (int)slot->stamp, &coarse, sizeof coarse);
    if (flags & SOF_TIMESTAMPING_SOFTWARE)
        stamps[0] = stamp;
    if (flags & SOF_TIMESTAMPING_RAW_HARDWARE)
        stamps[2] = stamp;
    if (flags & (SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RAW_HARDWARE))
        put_control(message, used, SOL_SOCKET, (int)slot->stamping, stamps, sizeof stamps);
}

static void put_about(const struct about *about, struct msghdr *message, size_t *used)
{
    if (about->destination != J1939_NO_ADDR)
        put_control(message, used, SOL_CAN_J1939, SCM_J1939_DEST_ADDR, &about->destination, 1);
    if (about->destination_name != J1939_NO_NAME)
        put_control(message, used, SOL_CAN_J1939, SCM_J1939_DEST_NAME, &about->destination_name,
                    sizeof about->destination_name);
    put_control(message, used, SOL_CAN_J1939, SCM_J1939_PRIO, &about->priority, 1);
}

static int tell(struct slot *slot, const struct arrival *arrival, struct msghdr *message, size_t room)
{
    const struct received *header = &arrival->header;
    size_t used = 0;

    message->msg_controllen = room;
    message->msg_flags &= ~MSG_CTRUNC;
    if (slot->protocol == CAN_J1939)
        put_about(&arrival->about, message, &used);
    put_stamps(slot, header, message, &used);
    if (slot->protocol == PACKET && slot->sends)
        put_auxiliary(header, message, &used);
    if (slot->counts_drops && header->drops != 0)
        put_control(message, &used, SOL_SOCKET, SO_RXQ_OVFL, &header->drops, sizeof header->drops);
    message->msg_controllen = used;
    if (header->flags & RECEIVED_LOCAL)
        message->msg_flags |= MSG_DONTROUTE;
    if (header->flags & RECEIVED_OWN)
        message->msg_flags |= MSG_CONFIRM;
    if (slot->protocol == PACKET)
        return tell_packet(slot, header, message);
    if (message->msg_name != NULL) {
        struct sockaddr_can name = {.can_family = AF_CAN, .can_ifindex = header->interface};
        socklen_t length = address_length(slot);
        if (slot->protocol == CAN_J1939) {
            name.can_addr.j1939.name = arrival->about.source_name;
            name.can_addr.j1939.pgn = arrival->about.pgn;
            name.can_addr.j1939.addr = arrival->about.source;
        }
        int error = copy_out(message->msg_name, &name, message->msg_namelen < length ? message->msg_namelen : length);
        message->msg_namelen = length;
        return error;
    }
    return 0;
}

static ssize_t finish(struct slot *slot, const struct arrival *arrival, struct msghdr *message, ssize_t length)
{
    __atomic_store_n(&slot->last_stamp_ns, arrival->header.stamp_ns, __ATOMIC_RELAXED);
    int error = tell(slot, arrival, message, message->msg_control != NULL ? message->msg_controllen : 0);
    if (error != 0)
        errno = error;
    return error != 0 ? -1 : length;
}

/* The wait of a call that receives; `again`: nothing was there at its turn. -1 and errno where it does not wait on. */
static int wait_for_message(int fd, const struct slot *slot, int flags, struct wait *wait)
{
    uint32_t limit_us = slot->receive_timeout_us;
    struct timespec span = {limit_us / 1000000, limit_us % 1000000 * 1000l};

    errno = EAGAIN;
    if (flags & MSG_DONTWAIT || REAL(fcntl)(fd, F_GETFL) & O_NONBLOCK)
        return -1;
    if (!wait->again) {
        wait->until_ns = wait_end_ns(limit_us != 0 ? &span : NULL);
        wait->restarts = limit_us == 0;
    } else if (expired(wait))
        return -1;
    return await_turn(wait);
}

/* How much of it there was room for; -1: a place is none of the program's. */
static ssize_t scatter(struct msghdr *message, const char *data, size_t length)
{
    size_t done = 0;

    for (size_t at = 0; at < message->msg_iovlen && done < length; at++) {
        size_t part = message->msg_iov[at].iov_len < length - done ? message->msg_iov[at].iov_len : length - done;
        if (copy_out(message->msg_iov[at].iov_base, data + done, part) != 0)
            return -1;
        done += part;
    }
    return (ssize_t)done;
}

/* 0: there may be something now; -1 and errno else. The kernel waits, by its rules of timeouts and signals. */
static int wait_for_row(int fd, const struct slot *slot, int flags, struct wait *wait)
{
    char byte;

    if (timed())
        return wait_for_message(fd, slot, flags, wait);
    return REAL(recv)(fd, &byte, 1, MSG_PEEK | (flags & MSG_DONTWAIT)) < 0 ? -1 : 0;
}

/* What the server says of it; what came without a word came now. */
static void look_up(struct block *block, const struct slot *slot, int peeks, struct arrival *arrival)
{
    struct timespec now;

    if (take_row(block, arrival->data, (size_t)arrival->length, peeks, &arrival->header, &arrival->about))
        return;
    clock_gettime(CLOCK_REALTIME, &now);
    arrival->header = (struct received){.stamp_ns = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec,
                                        .interface = slot->interface,
                                        .error = arrival->length == 0 ? ENETDOWN : 0, /* the server is gone */
                                        .length = (uint32_t)arrival->length};
}

/* The bytes of the message go where the program wants them; a whole frame is at hand, others have to be fetched. */
static ssize_t hand_over(int fd, struct msghdr *message, const struct arrival *arrival, int flags)
{
    struct msghdr inner = {.msg_iov = message->msg_iov, .msg_iovlen = message->msg_iovlen};
    ssize_t done;

    if (arrival->length <= (ssize_t)sizeof arrival->data)
        done = scatter(message, arrival->data, (size_t)arrival->length);
    else
        done = REAL(recvmsg)(fd, &inner, (flags & MSG_PEEK) | MSG_DONTWAIT);
    if (done < 0)
        errno = EFAULT;
    message->msg_flags = done >= 0 && done < arrival->length ? MSG_TRUNC : 0;
    return done;
}

/* -1 and EAGAIN: nothing is there. */
static ssize_t take_message(int fd, struct slot *slot, struct block *block, struct msghdr *message, int flags,
                            struct arrival *arrival)
{
    int whole = slot->protocol == CAN_RAW || slot->protocol == PACKET, peek = MSG_PEEK | MSG_TRUNC | MSG_DONTWAIT;
    char byte;
    ssize_t done = -1;

    if (lock_ring(&block->received) != 0) {
        errno = EAGAIN;
        return -1;
    }
    if (whole && !(flags & MSG_PEEK))
        peek &= ~MSG_PEEK;
    arrival->length = REAL(recv)(fd, arrival->data, sizeof arrival->data, peek);
    if (arrival->length >= 0) {
        look_up(block, slot, flags & MSG_PEEK, arrival);
        done = hand_over(fd, message, arrival, flags);
        if ((slot->protocol == CAN_ISOTP || slot->protocol == PACKET) && flags & MSG_TRUNC && done >= 0)
            done = arrival->length;
        if (!whole && !(flags & MSG_PEEK) && arrival->length <= (ssize_t)sizeof arrival->data) {
            int before = errno;
            REAL(recv)(fd, &byte, 1, MSG_DONTWAIT);
            errno = before;
        }
    }
    unlock_ring(&block->received);
    return done;
}

/* An error is a message without bytes, and is told once: by that, by a write, or by SO_ERROR. */
int take_error(int fd, struct slot *slot)
{
    struct block *block = block_of(slot);
    int error = __atomic_load_n(&slot->error, __ATOMIC_RELAXED) != 0
                    ? (int)__atomic_exchange_n(&slot->error, 0, __ATOMIC_RELAXED)
                    : 0;
    char byte;

    if (error != 0 && block != NULL && lock_ring(&block->received) == 0) {
        if (REAL(recv)(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0)
            REAL(recv)(fd, &byte, 1, MSG_DONTWAIT);
        unlock_ring(&block->received);
    }
    return error;
}

void drop_tokens(int fd, struct slot *slot)
{
    struct block *block = block_of(slot);
    struct received header;
    struct about about;
    char byte;

    if (block == NULL || __atomic_load_n(&slot->error, __ATOMIC_RELAXED) != 0 || lock_ring(&block->received) != 0)
        return;
    int before = errno;
    while (REAL(recv)(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0 && take_row(block, &byte, 0, 1, &header, &about) &&
           header.error != 0) {
        take_row(block, &byte, 0, 0, &header, &about);
        REAL(recv)(fd, &byte, 1, MSG_DONTWAIT);
    }
    errno = before;
    unlock_ring(&block->received);
}

/* What a message without data means: 0 where its error was told already. */
static int error_of(int fd, struct slot *slot, const struct received *header)
{
    struct pollfd server = {fd, 0, 0};
    int error = (int)__atomic_exchange_n(&slot->error, 0, __ATOMIC_RELAXED);

    if (error == 0 && REAL(poll)(&server, 1, 0) > 0 && server.revents & POLLHUP)
        error = header->error; /* the server is gone */
    return error;
}

ssize_t receive_message(int fd, struct slot *slot, struct msghdr *message, int flags)
{
    struct block *block = block_of(slot);
    struct arrival arrival;
    struct wait wait = {0};
    ssize_t done;

    if (slot->protocol == CAN_ISOTP && !slot->bound)
        return errno = EADDRNOTAVAIL, -1;
    if (slot->protocol == CAN_J1939 && flags & ~(MSG_DONTWAIT | MSG_ERRQUEUE))
        return errno = EINVAL, -1;
    if (slot->protocol == CAN_J1939 && flags & MSG_ERRQUEUE)
        return receive_error(slot, message);
    if (flags & MSG_ERRQUEUE && slot->protocol != CAN_BCM) {
        if (slot->protocol != CAN_ISOTP && __atomic_load_n(&slot->queued_errors, __ATOMIC_ACQUIRE) != 0)
            return receive_error(slot, message);
        return errno = slot->protocol == CAN_ISOTP ? EINVAL : EAGAIN, -1;
    }
    if (block == NULL)
        return errno = ENETDOWN, -1;
    for (;;) {
        done = take_message(fd, slot, block, message, flags, &arrival);
        if (done < 0 && (errno != EAGAIN || wait_for_row(fd, slot, flags, &wait) < 0))
            return -1;
        if (done < 0)
            continue;
        if (arrival.header.flags & RECEIVED_HAS_REST && (done = take_rest(slot, arrival.about.rest, arrival.length, message, done)) < 0)
            return -1;
        if (arrival.header.error == 0)
            return finish(slot, &arrival, message, done);
        int error = error_of(fd, slot, &arrival.header);
        if (error != 0)
            return errno = error, -1;
    }
}
