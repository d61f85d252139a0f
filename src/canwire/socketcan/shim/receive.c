/* What programs read: the server's header is taken off, and what it says becomes control messages. */
#include "ring.h"
#include "shim.h"
#include "timed.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/net_tstamp.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define SHORT_VECTOR 8

static void put_control(struct msghdr *message, size_t *used, int type, const void *data, size_t length)
{
    if (*used + CMSG_SPACE(length) > message->msg_controllen) {
        message->msg_flags |= MSG_CTRUNC;
        return;
    }
    struct cmsghdr *header = (struct cmsghdr *)((char *)message->msg_control + *used);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = type;
    header->cmsg_len = CMSG_LEN(length);
    memcpy(CMSG_DATA(header), data, length);
    *used += CMSG_SPACE(length);
}

static void put_stamps(const struct slot *slot, const struct received *header, struct msghdr *message, size_t *used)
{
    struct timespec stamp = {(time_t)(header->stamp_ns / 1000000000), (long)(header->stamp_ns % 1000000000)};
    struct timespec stamps[3] = {{0, 0}};
    struct timeval coarse = {stamp.tv_sec, stamp.tv_nsec / 1000};
    uint32_t flags = slot->stamping_flags;

    if (slot->stamp == SO_TIMESTAMPNS || slot->stamp == 64)
        put_control(message, used, (int)slot->stamp, &stamp, sizeof stamp);
    else if (slot->stamp != 0)
        put_control(message, used, (int)slot->stamp, &coarse, sizeof coarse);
    if (flags & SOF_TIMESTAMPING_SOFTWARE)
        stamps[0] = stamp;
    if (flags & SOF_TIMESTAMPING_RAW_HARDWARE)
        stamps[2] = stamp;
    if (flags & (SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RAW_HARDWARE))
        put_control(message, used, (int)slot->stamping, stamps, sizeof stamps);
}

static int tell(struct slot *slot, const struct received *header, struct msghdr *message, size_t room)
{
    size_t used = 0;

    message->msg_controllen = room;
    message->msg_flags &= ~MSG_CTRUNC;
    put_stamps(slot, header, message, &used);
    if (slot->counts_drops && header->drops != 0)
        put_control(message, &used, SO_RXQ_OVFL, &header->drops, sizeof header->drops);
    message->msg_controllen = used;
    if (header->flags & RECEIVED_LOCAL)
        message->msg_flags |= MSG_DONTROUTE;
    if (header->flags & RECEIVED_OWN)
        message->msg_flags |= MSG_CONFIRM;
    if (message->msg_name != NULL) {
        struct sockaddr_can name = {.can_family = AF_CAN, .can_ifindex = header->interface};
        socklen_t length = address_length(slot);
        int error = copy_out(message->msg_name, &name, message->msg_namelen < length ? message->msg_namelen : length);
        message->msg_namelen = length;
        return error;
    }
    return 0;
}

static ssize_t finish(struct slot *slot, const struct received *header, struct msghdr *message, ssize_t length)
{
    if (header->error != 0) {
        errno = header->error;
        return -1;
    }
    __atomic_store_n(&slot->last_stamp_ns, header->stamp_ns, __ATOMIC_RELAXED);
    int error = tell(slot, header, message, message->msg_control != NULL ? message->msg_controllen : 0);
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

/* Broadcast manager and ISO-TP: each message is one of the socket pair's. */
static ssize_t receive_from_pair(int fd, struct slot *slot, struct msghdr *message, int flags)
{
    struct received header;
    struct iovec few[SHORT_VECTOR + 1], *parts = few;
    struct msghdr inner = {.msg_iovlen = message->msg_iovlen + 1};
    struct wait wait = {0};
    ssize_t got;

    if (message->msg_iovlen > SHORT_VECTOR && (parts = calloc(message->msg_iovlen + 1, sizeof *parts)) == NULL) {
        errno = ENOMEM;
        return -1;
    }
    parts[0] = (struct iovec){&header, sizeof header};
    if (message->msg_iovlen)
        memcpy(parts + 1, message->msg_iov, message->msg_iovlen * sizeof *parts);
    inner.msg_iov = parts;
    do
        got = REAL(recvmsg)(fd, &inner, (flags & ~MSG_ERRQUEUE) | (timed() ? MSG_DONTWAIT : 0));
    while (got < 0 && errno == EAGAIN && timed() && wait_for_message(fd, slot, flags, &wait) == 0);
    int before = errno;
    if (parts != few)
        free(parts);
    errno = got >= 0 && got < (ssize_t)sizeof header ? ENETDOWN : before; /* 0: the server is gone */
    if (got < (ssize_t)sizeof header)
        return -1;
    message->msg_flags = inner.msg_flags;
    return finish(slot, &header, message, got - (ssize_t)sizeof header);
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
    ssize_t got = REAL(recv)(fd, &byte, 1, MSG_PEEK | (timed() ? MSG_DONTWAIT : flags & MSG_DONTWAIT));

    if (got < 0 && errno == EAGAIN && timed())
        return wait_for_message(fd, slot, flags, wait);
    if (got == 0) /* the server is gone */
        errno = ENETDOWN;
    return got > 0 ? 0 : -1;
}

static ssize_t receive_row(int fd, struct slot *slot, struct block *block, struct msghdr *message, int flags)
{
    struct received header;
    struct wait wait = {0};
    const char *row;

    for (;;) {
        int error = lock_ring(&block->received);
        if (error != 0) {
            errno = EAGAIN;
            return -1;
        }
        row = oldest(block);
        if (row != NULL)
            break;
        unlock_received(block, fd);
        if (wait_for_row(fd, slot, flags, &wait) < 0)
            return -1;
    }
    memcpy(&header, row, sizeof header);
    size_t length = header.length > RECEIVED_SIZE - sizeof header ? 0 : header.length;
    ssize_t done = scatter(message, row + sizeof header, length);
    if (!(flags & MSG_PEEK))
        release_oldest(block, fd);
    unlock_received(block, fd);
    if (done < 0) {
        errno = EFAULT;
        return -1;
    }
    message->msg_flags = (size_t)done < length ? MSG_TRUNC : 0;
    return finish(slot, &header, message, done);
}

ssize_t receive_message(int fd, struct slot *slot, struct msghdr *message, int flags)
{
    struct block *block = slot->protocol == CAN_RAW ? block_of(slot) : NULL;

    if (flags & MSG_ERRQUEUE && slot->protocol != CAN_BCM) { /* nothing ever comes there */
        errno = slot->protocol == CAN_ISOTP ? EINVAL : EAGAIN;
        return -1;
    }
    return block != NULL ? receive_row(fd, slot, block, message, flags)
                         : receive_from_pair(fd, slot, message, flags);
}
