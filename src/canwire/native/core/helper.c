/* The helper of a program on Linux: started with a pair of sockets, over which descriptors travel. */
#include "core.h"
#include "start.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#define STATES 65536u /* words on the page */

static int lifeline = -1; /* our end of the pair that the helper was started with */
static uint32_t *states;

int cw_lifeline(void)
{
    return __atomic_load_n(&lifeline, __ATOMIC_ACQUIRE);
}

uint32_t cw_state_of(uint32_t at)
{
    uint32_t *page = __atomic_load_n(&states, __ATOMIC_ACQUIRE);

    return page == NULL || at >= STATES ? 1 : __atomic_load_n(&page[at], __ATOMIC_ACQUIRE);
}

union control {
    struct cmsghdr header;
    char room[CMSG_SPACE(sizeof(int) * CW_MOST_DESCRIPTORS)];
};

/* Have the helper answer at the other end of a new pair. */
static int send_descriptor(int channel, int descriptor)
{
    union control control = {.header = {.cmsg_len = CMSG_LEN(sizeof(int)), .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS}};
    char nothing = 0;
    struct iovec one = {&nothing, 1};
    struct msghdr message = {.msg_iov = &one, .msg_iovlen = 1, .msg_control = &control,
                             .msg_controllen = CMSG_SPACE(sizeof(int))};

    memcpy(CMSG_DATA(&control.header), &descriptor, sizeof descriptor);
    while (sendmsg(channel, &message, MSG_NOSIGNAL) < 0)
        if (errno != EINTR)
            return -1;
    return 0;
}

static int pair(int ends[2])
{
    return socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends);
}

cw_socket cw_socket_new(void)
{
    int ends[2], channel = cw_lifeline();

    if (channel < 0 || pair(ends) < 0)
        return -1;
    if (send_descriptor(channel, ends[1]) < 0) {
        close(ends[0]);
        ends[0] = -1;
    }
    close(ends[1]);
    return ends[0];
}

static ssize_t receive(cw_socket socket, struct cw_reply *reply, struct cw_call *call)
{
    union control control;
    char rest[1];
    struct iovec parts[2] = {{reply, sizeof *reply}, {call->out != NULL ? call->out : rest, call->out != NULL ? call->out_size : 0}};
    struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2, .msg_control = &control, .msg_controllen = sizeof control};
    ssize_t got;

    do
        got = recvmsg(socket, &message, MSG_CMSG_CLOEXEC | MSG_TRUNC); /* with its whole length */
    while (got < 0 && errno == EINTR);
    call->descriptor_count = 0;
    for (struct cmsghdr *found = got > 0 ? CMSG_FIRSTHDR(&message) : NULL; found != NULL; found = CMSG_NXTHDR(&message, found))
        if (found->cmsg_level == SOL_SOCKET && found->cmsg_type == SCM_RIGHTS) {
            call->descriptor_count = (int)((found->cmsg_len - CMSG_LEN(0)) / sizeof(int));
            memcpy(call->descriptors, CMSG_DATA(found), found->cmsg_len - CMSG_LEN(0));
        }
    return got;
}

int cw_exchange(cw_socket socket, struct cw_call *call)
{
    struct cw_request request = {.object = call->object, .size = (uint32_t)call->in_size};
    struct cw_reply reply;
    struct iovec parts[2] = {{&request, sizeof request}, {(void *)call->in, call->in_size}};
    struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
    ssize_t got;

    strncpy(request.method, call->method, sizeof request.method - 1);
    while (sendmsg(socket, &message, MSG_NOSIGNAL) < 0)
        if (errno != EINTR)
            return -1;
    got = receive(socket, &reply, call);
    if (got < (ssize_t)sizeof reply) {
        cw_close_descriptors(call);
        errno = ENOTCONN;
        return -1;
    }
    call->result = reply.result;
    call->value = reply.value;
    call->out_length = (size_t)got - sizeof reply;
    return 0;
}

/* The first thing that a helper is asked: the page of states. */
static int greet(cw_socket socket)
{
    struct cw_call hello = {.method = "helper.hello"};

    if (cw_exchange(socket, &hello) < 0)
        return -1;
    if (hello.result == 0 && hello.descriptor_count == 1) {
        void *page = mmap(NULL, STATES * sizeof *states, PROT_READ, MAP_SHARED, hello.descriptors[0], 0);
        cw_close_descriptors(&hello);
        if (page == MAP_FAILED)
            return -1;
        __atomic_store_n(&states, page, __ATOMIC_RELEASE); /* one of a helper before stays: rings may look at it */
        return 0;
    }
    cw_close_descriptors(&hello);
    errno = EPROTO;
    return -1;
}

int cw_helper_start(void)
{
    int ends[2], started;
    cw_socket socket;

    cw_prepare_forks();
    if (pair(ends) < 0)
        return -1;
    started = cw_start_helper(ends[1]);
    close(ends[1]);
    if (started < 0) {
        close(ends[0]);
        return -1;
    }
    __atomic_store_n(&lifeline, ends[0], __ATOMIC_RELEASE);
    socket = cw_socket_new();
    started = socket != CW_NO_SOCKET ? greet(socket) : -1;
    if (socket != CW_NO_SOCKET)
        close(socket);
    if (started == 0)
        return 0;
    close(ends[0]);
    cw_helper_forget();
    errno = ENOTCONN;
    return -1;
}

int cw_helper_runs(void)
{
    return cw_lifeline() >= 0;
}

/* Those who wait still poll the old lifeline, so it stays open. */
void cw_helper_forget(void)
{
    __atomic_store_n(&lifeline, -1, __ATOMIC_RELEASE);
}

void cw_socket_close(cw_socket socket)
{
    close(socket);
}

void cw_close_descriptor(int descriptor)
{
    close(descriptor);
}

/* The parent's helper is the parent's; the next call here starts another one. */
void cw_helper_in_child(void)
{
    cw_calls_in_child();
    if (lifeline >= 0)
        close(lifeline);
    lifeline = -1;
}
