/* The helper of a program on Windows: calls are answered over TCP on this machine. ../helper/far.py is the other end. */
#include "win32.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define CALLS 'C' /* what a connection is for, after the token */

struct tail { /* of a reply: what follows it */
    uint32_t size;  /* of the data */
    uint32_t count; /* of names, after that */
    uint32_t said;  /* on the first connection, before the reply */
};

static struct far_helper helper;
static LONG runs;

int cw_helper_runs(void)
{
    return InterlockedCompareExchange(&runs, 0, 0) != 0;
}

int cw_helper_start(void)
{
    struct far_helper made;

    if (far_start(&made) < 0)
        return -1;
    helper = made;
    if (far_listen(made.lifeline) < 0) {
        closesocket(made.lifeline);
        return -1;
    }
    InterlockedExchange(&runs, 1);
    return 0;
}

/* The thread that listens closes the connection. */
void cw_helper_forget(void)
{
    shutdown(helper.lifeline, SD_BOTH);
    InterlockedExchange(&runs, 0);
}

cw_socket cw_socket_new(void)
{
    SOCKET made = far_dial(helper.port);
    unsigned char hello[TOKEN_SIZE + 1];

    if (made == INVALID_SOCKET)
        return CW_NO_SOCKET;
    memcpy(hello, helper.token, TOKEN_SIZE);
    hello[TOKEN_SIZE] = CALLS;
    if (far_send(made, hello, sizeof hello) < 0) {
        closesocket(made);
        errno = ENOTCONN;
        return CW_NO_SOCKET;
    }
    return (cw_socket)made;
}

void cw_socket_close(cw_socket socket)
{
    closesocket((SOCKET)socket);
}

/* A file that a helper of another system has open, as Wine shows it: "/proc/12/fd/3" */
static HANDLE opened(const char *path)
{
    wchar_t name[NAME_SIZE + 16] = L"\\\\?\\unix";
    size_t at = wcslen(name);

    for (; *path != '\0'; path++)
        name[at++] = *path == '/' ? L'\\' : (wchar_t)*path;
    name[at] = L'\0';
    return CreateFileW(name, GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
                       OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, NULL);
}

/* "signal 5", "handle 88": that the helper has made this process's, "file /proc/12/fd/3"; -1 for what cannot be had */
static int descriptor_of(const char *name)
{
    HANDLE file;

    if (strncmp(name, "signal ", 7) == 0)
        return SIGNAL | atoi(name + 7);
    if (strncmp(name, "handle ", 7) == 0)
        return atoi(name + 7);
    file = strncmp(name, "file ", 5) == 0 ? opened(name + 5) : INVALID_HANDLE_VALUE;
    return file == INVALID_HANDLE_VALUE ? -1 : (int)(intptr_t)file; /* Windows' handles have 32 bits */
}

void cw_close_descriptor(int descriptor)
{
    if (descriptor < 0)
        return;
    if (descriptor & SIGNAL)
        far_say(FORGET, descriptor & ~SIGNAL);
    else
        CloseHandle((HANDLE)(intptr_t)descriptor);
}

static int skip(SOCKET socket, size_t size)
{
    char rest[512];

    while (size > 0) {
        size_t part = size < sizeof rest ? size : sizeof rest;
        if (far_receive(socket, rest, part) < 0)
            return -1;
        size -= part;
    }
    return 0;
}

static int receive_data(SOCKET socket, struct cw_call *call, size_t size)
{
    size_t room = call->out != NULL ? call->out_size : 0, fits = size < room ? size : room;

    call->out_length = size;
    return far_receive(socket, call->out, fits) < 0 ? -1 : skip(socket, size - fits);
}

static int receive_names(SOCKET socket, struct cw_call *call, uint32_t count)
{
    char name[NAME_SIZE];

    if (count > CW_MOST_DESCRIPTORS)
        return -1;
    while (count-- > 0) {
        if (far_receive(socket, name, sizeof name) < 0 || name[NAME_SIZE - 1] != '\0')
            return -1;
        call->descriptors[call->descriptor_count++] = descriptor_of(name);
    }
    return 0;
}

/* What a call has ended is over when it returns: so it waits for what was said meanwhile. */
static int answered(SOCKET socket, struct cw_call *call, uint32_t of)
{
    struct cw_reply reply;
    struct tail tail;

    if (far_receive(socket, &reply, sizeof reply) < 0 || far_receive(socket, &tail, sizeof tail) < 0 ||
        tail.size > CW_MOST_DATA)
        return -1;
    call->result = reply.result;
    call->value = reply.value;
    if (receive_data(socket, call, tail.size) < 0 || receive_names(socket, call, tail.count) < 0)
        return -1;
    far_wait_heard(tail.said, of);
    return 0;
}

int cw_exchange(cw_socket socket, struct cw_call *call)
{
    char message[sizeof(struct cw_request) + CW_MOST_DATA]; /* one, so that it is one packet */
    uint32_t of = cw_process();
    struct cw_request request = {.object = call->object, .size = (uint32_t)call->in_size};

    strncpy(request.method, call->method, sizeof request.method - 1);
    memcpy(message, &request, sizeof request);
    if (call->in_size > 0)
        memcpy(message + sizeof request, call->in, call->in_size);
    if (far_send((SOCKET)socket, message, sizeof request + call->in_size) == 0 && answered((SOCKET)socket, call, of) == 0)
        return 0;
    cw_close_descriptors(call);
    errno = ENOTCONN;
    return -1;
}

/* Windows has no forks. */
void cw_prepare_forks(void)
{
}
