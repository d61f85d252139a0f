/* Requests to the server: each on a connection of its own, so that nothing has to survive fork, exec or closefrom. */
#include "shim.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

int dial(void)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *directory = getenv("CANWIRE_SOCKETCAN");
    int fd;

    if (directory == NULL ||
        snprintf(address.sun_path, sizeof address.sun_path, "%s/control", directory) >= (int)sizeof address.sun_path)
        return -1;
    fd = REAL(socket)(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (fd >= 0 && REAL(connect)(fd, (struct sockaddr *)&address, sizeof address) < 0) {
        REAL(close)(fd);
        return -1;
    }
    return fd;
}

/* A wait for a turn may be interrupted; the kernel goes on by itself after a handler with SA_RESTART, unless it polls. */
static ssize_t receive_reply(int fd, const struct request *request, struct msghdr *message, int flags)
{
    struct pollfd answer = {fd, POLLIN, 0};
    ssize_t got;

    if (request->operation == AWAIT_TURN)
        return !request->b && REAL(poll)(&answer, 1, -1) < 0 ? -1 : REAL(recvmsg)(fd, message, flags);

    do
        got = REAL(recvmsg)(fd, message, flags);
    while (got < 0 && errno == EINTR); /* the server answers at once, and what it did is done */
    return got;
}

long ask(const struct request *request, const void *data, size_t length, void *reply, size_t *size, int *descriptor,
         int close_on_exec)
{
    union {
        struct cmsghdr header;
        char room[CMSG_SPACE(sizeof(int))];
    } control;
    int64_t result = -ENETDOWN;
    struct request whole = *request;
    struct iovec out[2] = {{&whole, sizeof whole}, {(void *)data, length}};
    struct iovec in[2] = {{&result, sizeof result}, {reply, reply != NULL ? *size : 0}};
    struct msghdr outgoing = {.msg_iov = out, .msg_iovlen = 2};
    struct msghdr incoming = {.msg_iov = in, .msg_iovlen = 2, .msg_control = &control, .msg_controllen = sizeof control};
    ssize_t got = -1;
    int fd = dial(), fault = 0;

    whole.thread = (int32_t)syscall(SYS_gettid);
    if (fd >= 0) {
        if (REAL(sendmsg)(fd, &outgoing, MSG_NOSIGNAL) >= 0)
            got = receive_reply(fd, request, &incoming, close_on_exec ? MSG_CMSG_CLOEXEC : 0);
        if (got < 0 && (errno == EFAULT || (errno == EINTR && request->operation == AWAIT_TURN)))
            fault = errno; /* the program's pointer, its signal */
        REAL(close)(fd);
    }
    if (got < (ssize_t)sizeof result) { /* else whoever started us is gone: as if the adapter was pulled */
        errno = fault ? fault : ENETDOWN;
        return -1;
    }
    if (size != NULL)
        *size = (size_t)got - sizeof result;
    struct cmsghdr *found = CMSG_FIRSTHDR(&incoming);
    if (descriptor != NULL)
        *descriptor = -1;
    if (found != NULL && found->cmsg_type == SCM_RIGHTS && descriptor != NULL)
        memcpy(descriptor, CMSG_DATA(found), sizeof(int));
    if (result < 0) {
        errno = (int)-result;
        return -1;
    }
    return (long)result;
}

long note(enum note what, const char *text)
{
    struct request request = {.operation = NOTE, .a = (int32_t)what};
    int before = errno;
    long answer = ask(&request, text, strlen(text), NULL, NULL, NULL, 0);

    errno = before;
    return answer;
}
