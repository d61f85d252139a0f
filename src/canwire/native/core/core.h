/* What the files of the core share, and nobody else sees. */
#ifndef CANWIRE_NATIVE_CORE_H
#define CANWIRE_NATIVE_CORE_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "canwire.h"
#ifndef _WIN32
#include <poll.h>
#endif

#pragma GCC visibility push(hidden)

/* What travels between a call and its answer (../helper/serving.py). */
struct cw_request {
    char method[CW_METHOD_SIZE];
    uint32_t object;
    uint32_t size; /* of the data, which follow */
};

struct cw_reply {
    int32_t result;
    uint32_t value;
};

/* helper.c, or ../win32/helper.c where Windows' own functions are: the helper, and sockets to its threads */
typedef int cw_socket; /* Windows' SOCKETs have small numbers, too */
#define CW_NO_SOCKET (-1)

int cw_helper_runs(void);
int cw_helper_start(void); /* 0, or -1 with errno */
void cw_helper_forget(void);
cw_socket cw_socket_new(void);
void cw_socket_close(cw_socket socket);
int cw_exchange(cw_socket socket, struct cw_call *call);
void cw_close_descriptor(int descriptor);

/* calls.c */
void cw_helper_gone(uint32_t process); /* somebody has seen that; nothing where that was another process */
void cw_next_process(void); /* whatever is open is over */
void cw_calls_in_child(void);

/* ring.c */
void cw_ring_arm(struct cw_ring *ring);
void cw_ring_rearm(struct cw_ring *ring);
int cw_ring_met(struct cw_ring *ring); /* its threshold */

/* lent.c, or ../win32/lent.c */
int cw_ring_map(struct cw_ring *ring, int descriptor); /* the mapping and its size; 0, or -1 with errno */
void cw_ring_unmap(struct cw_ring *ring);
int cw_ring_ended(const struct cw_ring *ring); /* its lease or its hub is gone */
void cw_ring_signal(struct cw_ring *ring, int descriptor); /* its own end, or its peer */
void cw_keep_ring(struct cw_ring *ring);
void cw_forget_ring(struct cw_ring *ring);

void cw_prepare_forks(void);

#ifndef _WIN32
/* helper.c */
int cw_lifeline(void);             /* readable once the helper is gone; -1: there is none */
uint32_t cw_state_of(uint32_t at); /* a word on the page of states: not 0 once what it is about is over */
void cw_helper_in_child(void);

/* fork.c */
void cw_handles_in_child(void); /* handles.c */
void cw_events_in_child(void);  /* events.c */
void cw_lock_handles(void);
void cw_unlock_handles(void);

/* clock.c */
int64_t cw_clock_now(void);                 /* nanoseconds of the monotonic clock */
int64_t cw_deadline(int64_t milliseconds);  /* of that, or of the hub's time; INT64_MAX: never */
int cw_poll(struct pollfd *about, nfds_t count, int64_t until); /* as ppoll; 0 when the time is over; goes on after signals */

int cw_drain(int descriptor); /* lent.c: was anything in it? */

/* timed.c: nanoseconds of the hub's time, -1 where the calling thread takes no part in it */
cw_socket cw_thread_socket(void); /* the calling thread's own; CW_NO_SOCKET: none could be made */
void cw_thread_socket_forget(void);
int64_t cw_await_turn(int64_t until); /* something was signalled, another thread has run, or the time is over */
int cw_poll_by_turns(struct pollfd *about, nfds_t count, int64_t *until);
#else
#define cw_thread_socket() CW_NO_SOCKET
#define cw_thread_socket_forget() ((void)0)
#endif

#pragma GCC visibility pop
#endif
