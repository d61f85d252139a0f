/* What programs write: checked as the kernel does, with its errors, and passed on behind a small header. */
#include "ring.h"
#include "shim.h"
#include "timed.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef SCM_TXTIME
#define SCM_TXTIME 61
#endif
#define STAMPING_NEW 65 /* SO_TIMESTAMPING_NEW */
#define PATIENCE_MS 100 /* after which a line that is stuck, or down, is noticed */

size_t size_of_message(const struct msghdr *message)
{
    size_t sum = 0;

    for (size_t at = 0; at < message->msg_iovlen; at++)
        sum += message->msg_iov[at].iov_len;
    return sum;
}

/* 0, or EFAULT */
int gather(const struct msghdr *message, char *into)
{
    for (size_t at = 0; at < message->msg_iovlen; at++) {
        if (copy_in(into, message->msg_iov[at].iov_base, message->msg_iov[at].iov_len) != 0)
            return EFAULT;
        into += message->msg_iov[at].iov_len;
    }
    return 0;
}

/* The interface that a message is for, 0 and errno if there is none; `interface` where its own address says so. */
int destination(const struct slot *slot, const struct msghdr *message)
{
    if (message->msg_name == NULL)
        return slot->interface;
    const struct sockaddr_can *name = message->msg_name;
    if (message->msg_namelen < offsetof(struct sockaddr_can, can_addr) || name->can_family != AF_CAN) {
        errno = EINVAL;
        return -1;
    }
    if (name->can_ifindex < 0)
        errno = ENXIO;
    return name->can_ifindex;
}

/* 0, or EINVAL: control messages that the kernel takes from a sender, and none else. */
static int control_error(const struct msghdr *message)
{
    size_t left = message->msg_controllen;

    for (const char *at = message->msg_control; at != NULL && left >= sizeof(struct cmsghdr);) {
        struct cmsghdr header;
        if (copy_in(&header, at, sizeof header) != 0)
            return EFAULT;
        if (header.cmsg_len < sizeof header || header.cmsg_len > left)
            return EINVAL;
        if (header.cmsg_level == SOL_SOCKET && header.cmsg_type != SO_MARK && header.cmsg_type != SCM_TXTIME &&
            header.cmsg_type != SO_TIMESTAMPING && header.cmsg_type != STAMPING_NEW &&
            header.cmsg_type != SCM_RIGHTS && header.cmsg_type != SCM_CREDENTIALS)
            return EINVAL;
        size_t step = CMSG_ALIGN(header.cmsg_len);
        left -= step < left ? step : left;
        at += step;
    }
    return 0;
}

int waits_to_send(int fd, int flags)
{
    return !(flags & MSG_DONTWAIT) && !(REAL(fcntl)(fd, F_GETFL) & O_NONBLOCK);
}

static int interface_error(const struct interface *interface, int full)
{
    uint32_t flags = __atomic_load_n(&interface->flags, __ATOMIC_RELAXED);
    if (flags & INTERFACE_GONE)
        return ENODEV;
    if (!(flags & INTERFACE_UP))
        return ENETDOWN;
    return full && flags & INTERFACE_STUCK ? ENOBUFS : 0;
}

/* Where the queue is full: the descriptor's own timeout counts, and a line that gets nothing out is ENOBUFS. */
static int wait_for_room(int fd, struct block *block, const struct interface *interface, long *left)
{
    struct timeval limit = {0, 0};
    socklen_t size = sizeof limit;
    struct pollfd server = {fd, 0, 0};
    int error;

    if (*left < 0) {
        REAL(getsockopt)(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, &size);
        *left = limit.tv_sec * 1000 + limit.tv_usec / 1000;
        if (*left == 0)
            *left = LONG_MAX;
    }
    int span = *left < PATIENCE_MS ? (int)*left : PATIENCE_MS;
    if (timed()) {
        struct wait wait = {.until_ns = hub_now_ns() + span * 1000000ll, .restarts = 1};
        if (await_turn(&wait) < 0)
            return errno;
        if (!expired(&wait))
            span = 0;
    } else
        wait_for_turn(block, span);
    error = interface_error(interface, 1);
    if (error == 0 && poll(&server, 1, 0) > 0 && server.revents & (POLLHUP | POLLERR))
        error = ENETDOWN;
    if (error == 0 && *left != LONG_MAX && (*left -= span) <= 0)
        error = EAGAIN;
    return error;
}

static int put_row(int fd, struct block *block, const struct sent *header, const char *frame, int flags,
                   const struct interface *interface)
{
    long left = -1;
    int error;

    for (;;) {
        if (lock_ring(&block->sent) != 0)
            return ENOBUFS;
        char *row = next_free(block);
        if (row != NULL) {
            memcpy(row, header, sizeof *header);
            memcpy(row + sizeof *header, frame, header->length);
            error = commit(block, fd);
            unlock_ring(&block->sent);
            return error;
        }
        unlock_ring(&block->sent);
        if (!waits_to_send(fd, flags))
            return ENOBUFS;
        error = wait_for_room(fd, block, interface, &left);
        if (error != 0)
            return error;
    }
}

/* What is wrong with it, 0: nothing. */
static int frame_error(const struct slot *slot, const struct interface *interface, const char *frame, size_t size)
{
    size_t most = size == CAN_MTU ? CAN_MAX_DLEN : CANFD_MAX_DLEN;

    if (size != CAN_MTU && !(size == CANFD_MTU && slot->fd_frames))
        return EINVAL;
    if ((size_t)interface->mtu < size || ((const struct canfd_frame *)frame)->len > most)
        return EINVAL;
    return interface_error(interface, 0);
}

/* Of AF_PACKET: a driver drops what is no frame, and says nothing. */
static int packet_error(const struct interface *interface, size_t size)
{
    return size > (size_t)interface->mtu ? EMSGSIZE : interface_error(interface, 0);
}

static ssize_t send_raw(int fd, struct slot *slot, const struct msghdr *message, int flags)
{
    char frame[sizeof(struct canfd_frame)] = {0};
    struct block *block = block_of(slot);
    size_t size = size_of_message(message);
    int index = slot->protocol == PACKET ? packet_destination(slot, message) : destination(slot, message);
    struct interface *interface;

    if (index < 0)
        return -1;
    interface = interface_by_index(index);
    if (interface == NULL || block == NULL) {
        char name[IF_NAMESIZE]; /* another one's is no CAN */
        errno = index > 0 && REAL(if_indextoname)((unsigned)index, name) != NULL ? EPERM : ENXIO;
        return -1;
    }
    int error = control_error(message);
    if (error == 0)
        error = take_error(fd, slot);
    if (error == 0 && size <= sizeof frame)
        error = gather(message, frame);
    if (error == 0)
        error = slot->protocol == PACKET ? packet_error(interface, size) : frame_error(slot, interface, frame, size);
    if (error == 0) {
        struct sent header = {index, (uint32_t)size};
        error = put_row(fd, block, &header, frame, flags, interface);
    }
    if (error != 0) {
        errno = error;
        return -1;
    }
    return (ssize_t)size;
}

ssize_t send_message(int fd, struct slot *slot, const struct msghdr *message, int flags)
{
    return slot->protocol == CAN_RAW || slot->protocol == PACKET ? send_raw(fd, slot, message, flags)
                                                                 : send_asked(fd, slot, message, flags);
}

EXPORT ssize_t sendmsg(int fd, const struct msghdr *message, int flags)
{
    struct slot *slot = slot_of(fd);
    struct vector vector;

    if (slot == NULL)
        return is_link_socket(fd) ? send_to_server(fd, message, flags) : REAL(sendmsg)(fd, message, flags);
    return fetch_message(&vector, message) < 0 ? -1 : send_message(fd, slot, &vector.message, flags);
}

EXPORT int sendmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags)
{
    struct slot *slot = slot_of(fd);
    unsigned done;

    if (slot == NULL)
        return REAL(sendmmsg)(fd, messages, count, flags);
    for (done = 0; done < count; done++) {
        ssize_t gone = send_message(fd, slot, &messages[done].msg_hdr, flags);
        if (gone < 0)
            break;
        messages[done].msg_len = (unsigned)gone;
    }
    return done > 0 ? (int)done : -1;
}

static ssize_t send_buffer(int fd, struct slot *slot, const void *data, size_t size, int flags,
                           const struct sockaddr *address, socklen_t length)
{
    struct iovec part = {(void *)data, size};
    struct msghdr message = {
        .msg_name = (void *)address, .msg_namelen = length, .msg_iov = &part, .msg_iovlen = 1};

    return slot == NULL ? send_to_server(fd, &message, flags) : send_message(fd, slot, &message, flags);
}

EXPORT ssize_t send(int fd, const void *data, size_t size, int flags)
{
    struct slot *slot = slot_of(fd);

    if (slot == NULL && !is_link_socket(fd))
        return REAL(send)(fd, data, size, flags);
    return send_buffer(fd, slot, data, size, flags, NULL, 0);
}

EXPORT ssize_t write(int fd, const void *data, size_t size)
{
    struct slot *slot = slot_of(fd);

    if (slot == NULL && !is_link_socket(fd))
        return REAL(write)(fd, data, size);
    return send_buffer(fd, slot, data, size, 0, NULL, 0);
}

EXPORT ssize_t writev(int fd, const struct iovec *parts, int count)
{
    struct slot *slot = slot_of(fd);
    struct msghdr message = {.msg_iov = (struct iovec *)parts, .msg_iovlen = (size_t)count};
    struct vector vector;

    if (slot == NULL)
        return REAL(writev)(fd, parts, count);
    return fetch_message(&vector, &message) < 0 ? -1 : send_message(fd, slot, &vector.message, 0);
}

EXPORT ssize_t sendto(int fd, const void *data, size_t size, int flags, const struct sockaddr *address,
                      socklen_t length)
{
    struct slot *slot = slot_of(fd);

    if (slot == NULL && !is_link_socket(fd))
        return REAL(sendto)(fd, data, size, flags, address, length);
    return send_buffer(fd, slot, data, size, flags, address, length);
}
