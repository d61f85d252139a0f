/* What programs read: the server's header is taken off, and what it says becomes control messages. */
#include "shim.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/net_tstamp.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
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

static void tell(struct slot *slot, const struct received *header, struct msghdr *message, size_t room)
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
        memcpy(message->msg_name, &name, message->msg_namelen < sizeof name ? message->msg_namelen : sizeof name);
        message->msg_namelen = sizeof name;
    }
}

ssize_t receive_message(int fd, struct slot *slot, struct msghdr *message, int flags)
{
    struct received header;
    struct iovec few[SHORT_VECTOR + 1], *parts = few;
    struct msghdr inner = {.msg_iov = few, .msg_iovlen = message->msg_iovlen + 1};
    ssize_t got;

    if (message->msg_iovlen > SHORT_VECTOR && (parts = calloc(message->msg_iovlen + 1, sizeof *parts)) == NULL) {
        errno = ENOMEM;
        return -1;
    }
    parts[0] = (struct iovec){&header, sizeof header};
    if (message->msg_iovlen)
        memcpy(parts + 1, message->msg_iov, message->msg_iovlen * sizeof *parts);
    inner.msg_iov = parts;
    got = REAL(recvmsg)(fd, &inner, flags & ~MSG_ERRQUEUE);
    if (parts != few) {
        int before = errno;
        free(parts);
        errno = before;
    }
    if (got < 0)
        return -1;
    if (got < (ssize_t)sizeof header || header.error != 0) { /* 0: the server is gone, as if the adapter was pulled */
        errno = got < (ssize_t)sizeof header ? ENETDOWN : header.error;
        return -1;
    }
    message->msg_flags = inner.msg_flags;
    __atomic_store_n(&slot->last_stamp_ns, header.stamp_ns, __ATOMIC_RELAXED);
    tell(slot, &header, message, message->msg_control != NULL ? message->msg_controllen : 0);
    return got - (ssize_t)sizeof header;
}

EXPORT ssize_t recvmsg(int fd, struct msghdr *message, int flags)
{
    struct slot *slot = slot_of(fd);

    return slot == NULL ? REAL(recvmsg)(fd, message, flags) : receive_message(fd, slot, message, flags);
}

EXPORT int recvmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags, struct timespec *timeout)
{
    struct slot *slot = slot_of(fd);
    unsigned done;

    if (slot == NULL)
        return REAL(recvmmsg)(fd, messages, count, flags, timeout);
    for (done = 0; done < count; done++) {
        int more = done > 0 && flags & MSG_WAITFORONE ? MSG_DONTWAIT : 0;
        ssize_t got = receive_message(fd, slot, &messages[done].msg_hdr, (flags & ~MSG_WAITFORONE) | more);
        if (got < 0)
            break;
        messages[done].msg_len = (unsigned)got;
    }
    return done > 0 ? (int)done : -1;
}

static ssize_t receive_buffer(int fd, struct slot *slot, void *buffer, size_t size, int flags)
{
    struct iovec part = {buffer, size};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};

    return receive_message(fd, slot, &message, flags);
}

EXPORT ssize_t recv(int fd, void *buffer, size_t size, int flags)
{
    struct slot *slot = slot_of(fd);

    return slot == NULL ? REAL(recv)(fd, buffer, size, flags) : receive_buffer(fd, slot, buffer, size, flags);
}

EXPORT ssize_t read(int fd, void *buffer, size_t size)
{
    struct slot *slot = slot_of(fd);

    return slot == NULL ? REAL(read)(fd, buffer, size) : receive_buffer(fd, slot, buffer, size, 0);
}

EXPORT ssize_t readv(int fd, const struct iovec *parts, int count)
{
    struct slot *slot = slot_of(fd);
    struct msghdr message = {.msg_iov = (struct iovec *)parts, .msg_iovlen = (size_t)count};

    return slot == NULL ? REAL(readv)(fd, parts, count) : receive_message(fd, slot, &message, 0);
}

EXPORT ssize_t recvfrom(int fd, void *buffer, size_t size, int flags, struct sockaddr *address, socklen_t *length)
{
    struct slot *slot = slot_of(fd);
    struct iovec part = {buffer, size};
    struct msghdr message = {.msg_name = address, .msg_iov = &part, .msg_iovlen = 1};
    ssize_t got;

    if (slot == NULL)
        return REAL(recvfrom)(fd, buffer, size, flags, address, length);
    message.msg_namelen = address != NULL && length != NULL ? *length : 0;
    got = receive_message(fd, slot, &message, flags);
    if (got >= 0 && address != NULL && length != NULL)
        *length = message.msg_namelen;
    return got;
}

/* what _FORTIFY_SOURCE makes of them */

ssize_t __read_chk(int fd, void *buffer, size_t size, size_t room);
ssize_t __recv_chk(int fd, void *buffer, size_t size, size_t room, int flags);
ssize_t __recvfrom_chk(int fd, void *buffer, size_t size, size_t room, int flags, struct sockaddr *address,
                       socklen_t *length);

EXPORT ssize_t __read_chk(int fd, void *buffer, size_t size, size_t room)
{
    if (size > room)
        abort();
    return read(fd, buffer, size);
}

EXPORT ssize_t __recv_chk(int fd, void *buffer, size_t size, size_t room, int flags)
{
    if (size > room)
        abort();
    return recv(fd, buffer, size, flags);
}

EXPORT ssize_t __recvfrom_chk(int fd, void *buffer, size_t size, size_t room, int flags, struct sockaddr *address,
                              socklen_t *length)
{
    if (size > room)
        abort();
    return recvfrom(fd, buffer, size, flags, address, length);
}
