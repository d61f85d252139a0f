/* The calls by which programs read. */
#include "timed.h"

#include <stdlib.h>
#include <unistd.h>

#define ELSEWHERE(name, fd, ...) (reads_elsewhere(fd), REAL(name)(fd, __VA_ARGS__))

EXPORT ssize_t recvmsg(int fd, struct msghdr *message, int flags)
{
    struct slot *slot = slot_of(fd);
    struct vector vector;

    if (slot == NULL) {
        ssize_t got = ELSEWHERE(recvmsg, fd, message, flags);
        if (got >= 0)
            hide_server(message);
        return got;
    }
    if (fetch_message(&vector, message) < 0)
        return -1;
    ssize_t got = receive_message(fd, slot, &vector.message, flags);
    message->msg_namelen = vector.message.msg_namelen;
    message->msg_controllen = vector.message.msg_controllen;
    message->msg_flags = vector.message.msg_flags;
    return got;
}

EXPORT int recvmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags, struct timespec *timeout)
{
    struct slot *slot = slot_of(fd);
    unsigned done;

    if (slot == NULL)
        return ELSEWHERE(recvmmsg, fd, messages, count, flags, timeout);
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

    return slot == NULL ? ELSEWHERE(recv, fd, buffer, size, flags) : receive_buffer(fd, slot, buffer, size, flags);
}

EXPORT ssize_t read(int fd, void *buffer, size_t size)
{
    struct slot *slot = slot_of(fd);

    if (slot == NULL)
        return is_timer(fd) ? read_timer(fd, buffer, size) : ELSEWHERE(read, fd, buffer, size);
    return size != 0 ? receive_buffer(fd, slot, buffer, size, 0) : 0; /* which takes nothing */
}

static size_t room_of(const struct msghdr *message)
{
    size_t room = 0;

    for (size_t at = 0; at < message->msg_iovlen; at++)
        room += message->msg_iov[at].iov_len;
    return room;
}

EXPORT ssize_t readv(int fd, const struct iovec *parts, int count)
{
    struct slot *slot = slot_of(fd);
    struct msghdr message = {.msg_iov = (struct iovec *)parts, .msg_iovlen = (size_t)count};
    struct vector vector;

    if (slot == NULL)
        return ELSEWHERE(readv, fd, parts, count);
    if (fetch_message(&vector, &message) < 0)
        return -1;
    return room_of(&vector.message) != 0 ? receive_message(fd, slot, &vector.message, 0) : 0;
}

EXPORT ssize_t recvfrom(int fd, void *buffer, size_t size, int flags, struct sockaddr *address, socklen_t *length)
{
    struct slot *slot = slot_of(fd);
    struct iovec part = {buffer, size};
    struct msghdr message = {.msg_name = address, .msg_iov = &part, .msg_iovlen = 1};
    ssize_t got;

    if (slot == NULL) {
        got = ELSEWHERE(recvfrom, fd, buffer, size, flags, address, length);
        if (got >= 0 && address != NULL && length != NULL) {
            message.msg_namelen = *length;
            hide_server(&message);
        }
        return got;
    }
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
