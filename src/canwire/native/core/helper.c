/* Calls to the helper: each thread that calls has a socket to a thread of the helper for itself, for that long. */
#include "core.h"
#include "start.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#define MOST_IDLE 16
#define STATES 65536u /* words on the page */

struct request {
    char method[CW_METHOD_SIZE];
    uint32_t object;
    uint32_t reserved;
};

struct reply {
    int32_t result;
    uint32_t value;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int lifeline = -1;          /* our end of the pair that the helper was started with */
static int idle[MOST_IDLE];        /* sockets that no thread uses */
static int idle_count;
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

static int new_socket(void)
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

static ssize_t receive(int socket, struct reply *reply, struct cw_call *call)
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

static int exchange(int socket, struct cw_call *call)
{
    struct request request = {.object = call->object};
    struct reply reply;
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
static int greet(int socket)
{
    struct cw_call hello = {.method = "helper.hello"};

    if (exchange(socket, &hello) < 0)
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

static int start(void) /* under the lock */
{
    int ends[2], socket;

    cw_prepare_forks();
    if (pair(ends) < 0)
        return -1;
    if (cw_start_helper(ends[1]) < 0) {
        close(ends[0]);
        close(ends[1]);
        return -1;
    }
    close(ends[1]);
    __atomic_store_n(&lifeline, ends[0], __ATOMIC_RELEASE);
    socket = new_socket();
    if (socket >= 0 && greet(socket) == 0) {
        idle[idle_count++] = socket;
        return 0;
    }
    if (socket >= 0)
        close(socket);
    close(ends[0]);
    __atomic_store_n(&lifeline, -1, __ATOMIC_RELEASE);
    errno = ENOTCONN;
    return -1;
}

static int take_socket(void)
{
    int socket = -1, ready;

    pthread_mutex_lock(&lock);
    ready = lifeline >= 0 || start() == 0;
    if (ready && idle_count > 0)
        socket = idle[--idle_count];
    pthread_mutex_unlock(&lock);
    return ready && socket < 0 ? new_socket() : socket;
}

static void give_back(int socket)
{
    pthread_mutex_lock(&lock);
    if (idle_count < MOST_IDLE) {
        idle[idle_count++] = socket;
        socket = -1;
    }
    pthread_mutex_unlock(&lock);
    if (socket >= 0)
        close(socket);
}

/* The helper has ended: what it held is over, and the next call starts another one. Those who wait still poll the old
 * lifeline, so it stays open. */
static void lost(uint32_t process)
{
    pthread_mutex_lock(&lock);
    if (process == cw_process() && lifeline >= 0) {
        while (idle_count > 0)
            close(idle[--idle_count]);
        __atomic_store_n(&lifeline, -1, __ATOMIC_RELEASE);
        cw_next_process();
    }
    pthread_mutex_unlock(&lock);
}

void cw_helper_gone(void)
{
    lost(cw_process());
}

int cw_call(struct cw_call *call)
{
    uint32_t process = cw_process();
    int socket, asked;

    call->descriptor_count = 0;
    call->result = 0;
    call->value = 0;
    call->out_length = 0;
    if (call->in_size > CW_MOST_DATA || strlen(call->method) >= CW_METHOD_SIZE) {
        errno = EMSGSIZE;
        return -1;
    }
    socket = take_socket();
    asked = socket < 0 ? -1 : exchange(socket, call);
    if (asked == 0 && process == cw_process()) {
        give_back(socket);
    } else {
        if (socket >= 0)
            close(socket);
        lost(process);
    }
    return asked;
}

void cw_close_descriptors(struct cw_call *call)
{
    while (call->descriptor_count > 0)
        close(call->descriptors[--call->descriptor_count]);
}

/* The parent's helper is the parent's; the next call here starts another one. */
void cw_helper_in_child(void)
{
    pthread_mutex_init(&lock, NULL);
    while (idle_count > 0)
        close(idle[--idle_count]);
    if (lifeline >= 0)
        close(lifeline);
    lifeline = -1;
}
