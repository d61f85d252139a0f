/* What the files of the core share, and nobody else sees. */
#ifndef CANWIRE_NATIVE_CORE_H
#define CANWIRE_NATIVE_CORE_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "canwire.h"

#include <poll.h>

#pragma GCC visibility push(hidden)

/* helper.c */
int cw_lifeline(void);             /* readable once the helper is gone; -1: there is none */
void cw_helper_gone(void);         /* who waits has seen that */
uint32_t cw_state_of(uint32_t at); /* a word on the page of states: not 0 once what it is about is over */

/* ring.c */
void cw_ring_arm(struct cw_ring *ring);
void cw_ring_rearm(struct cw_ring *ring);
int cw_drain(int descriptor); /* was anything in it? */

/* fork.c */
void cw_keep_ring(struct cw_ring *ring);
void cw_forget_ring(struct cw_ring *ring);
void cw_next_process(void); /* whatever is open is over */
void cw_prepare_forks(void);
void cw_helper_in_child(void);  /* helper.c */
void cw_handles_in_child(void); /* handles.c */
void cw_events_in_child(void);  /* events.c */
void cw_lock_handles(void);
void cw_unlock_handles(void);

/* clock.c */
int64_t cw_deadline(int64_t milliseconds);                  /* nanoseconds of the monotonic clock; INT64_MAX: never */
int cw_poll(struct pollfd *about, nfds_t count, int64_t until); /* as ppoll; 0 when the time is over; goes on after signals */

#pragma GCC visibility pop
#endif
