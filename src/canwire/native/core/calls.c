/* Calls to the helper: each thread that calls has a socket to a thread of the helper for itself, for that long. */
#include "core.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>

#define MOST_IDLE 16

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static cw_socket idle[MOST_IDLE]; /* that no thread uses */
static int idle_count;
static uint32_t process;

uint32_t cw_process(void)
{
    return __atomic_load_n(&process, __ATOMIC_RELAXED);
}

void cw_next_process(void)
{
    __atomic_add_fetch(&process, 1, __ATOMIC_RELEASE);
}

static cw_socket take_socket(void)
{
    cw_socket socket = CW_NO_SOCKET;
    int ready;

    pthread_mutex_lock(&lock);
    ready = cw_helper_runs() || cw_helper_start() == 0;
    if (ready && !cw_timed() && idle_count > 0)
        socket = idle[--idle_count];
    pthread_mutex_unlock(&lock);
    if (!ready || socket != CW_NO_SOCKET)
        return socket;
    return cw_timed() ? cw_thread_socket() : cw_socket_new();
}

static void give_back(cw_socket socket)
{
    if (cw_timed())
        return;
    pthread_mutex_lock(&lock);
    if (idle_count < MOST_IDLE) {
        idle[idle_count++] = socket;
        socket = CW_NO_SOCKET;
    }
    pthread_mutex_unlock(&lock);
    if (socket != CW_NO_SOCKET)
        cw_socket_close(socket);
}

/* The helper has ended: what it held is over, and the next call starts another one. */
void cw_helper_gone(uint32_t of)
{
    pthread_mutex_lock(&lock);
    if (of == cw_process() && cw_helper_runs()) {
        while (idle_count > 0)
            cw_socket_close(idle[--idle_count]);
        cw_helper_forget();
        cw_next_process();
    }
    pthread_mutex_unlock(&lock);
}

int cw_call(struct cw_call *call)
{
    uint32_t of = cw_process();
    cw_socket socket;
    int asked;

    call->descriptor_count = 0;
    call->result = 0;
    call->value = 0;
    call->out_length = 0;
    if (call->in_size > CW_MOST_DATA || strlen(call->method) >= CW_METHOD_SIZE) {
        errno = EMSGSIZE;
        return -1;
    }
    socket = take_socket();
    asked = socket == CW_NO_SOCKET ? -1 : cw_exchange(socket, call);
    if (asked == 0 && of == cw_process()) {
        give_back(socket);
    } else {
        if (cw_timed())
            cw_thread_socket_forget();
        else if (socket != CW_NO_SOCKET)
            cw_socket_close(socket);
        cw_helper_gone(of);
    }
    return asked;
}

void cw_close_descriptors(struct cw_call *call)
{
    while (call->descriptor_count > 0)
        cw_close_descriptor(call->descriptors[--call->descriptor_count]);
}

/* The parent's sockets are the parent's. */
void cw_calls_in_child(void)
{
    pthread_mutex_init(&lock, NULL);
    cw_thread_socket_forget();
    while (idle_count > 0)
        cw_socket_close(idle[--idle_count]);
}
