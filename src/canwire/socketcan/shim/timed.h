/* Programs that keep one time with others: the hub's, which passes only while all of them wait.
 *
 * The server beside `canwire run` takes part in the hub's time for all programs that it serves. A thread of theirs takes
 * part from its first CAN socket or its first wait on; each wait is a request to the server, whose answer is its turn.
 * Then it looks whether what it waits for is there, without waiting. ../timed/turns.py is the other end.
 */
#ifndef CANWIRE_TIMED_H
#define CANWIRE_TIMED_H

#include "shim.h"

#include <pthread.h>
#include <signal.h>
#include <time.h>

#define NEVER INT64_MAX
#define SECOND 1000000000ll

static inline int timed(void)
{
    return shim_table != NULL && shim_table->timed;
}

struct wait { /* one call that waits */
    int64_t until_ns;
    const sigset_t *mask; /* of signals meanwhile; NULL: as it is */
    int restarts;         /* after a handler with SA_RESTART, as the kernel's own call does */
    int sleeps;           /* until then, whatever happens */
    pid_t child;          /* until this one ends, -1: any; 0: for something else */
    int again;            /* it has looked before: nothing that others may wait for has happened since */
};

int64_t hub_now_ns(void);
int64_t wait_end_ns(const struct timespec *span); /* so long from now; NULL: NEVER */
int await_turn(struct wait *wait);                /* 0: look; -1 and errno (EINTR) */
int expired(const struct wait *wait);
int sleep_until(int64_t until_ns); /* 0, or -1 with EINTR */
struct timespec span_of(int64_t ns);

void take_part(void); /* this thread, from now on until it ends */

/* forks.c: what a thread does that takes part, but has waited for nothing yet */
void begin_threads(void);     /* this one begins others: it takes part before they do */
void waits_itself(void);      /* it takes part until it ends */
void reads_elsewhere(int fd); /* it takes part no longer if this blocks */
void leave_if_begun(void);    /* it takes part no longer: another program begins in its place */

/* seats.c */
void seat_taken(void);            /* this thread takes part, ... */
void seat_left(void);             /* ... and no longer */
void forget_seats(void);          /* a fork has none */
int keeps_time(void);             /* this thread takes part */
int other_keeps_time(int number); /* so does this one of the process, which is another one */
int own_number(void);

/* mutexes.c */
int lock_in_time(pthread_mutex_t *mutex, int64_t until_ns);
int64_t until_ns_of(clockid_t clock, const struct timespec *time); /* an absolute time of this clock, by the hub's */
int impossible_time(const struct timespec *time);

/* locks.c */
void thread_ends(void); /* this one, as far as those are concerned who join it */

struct span { /* until a timer goes off, 0: never; and then again each time */
    int64_t first_ns, then_ns;
};

/* timerfd.c */
int set_kept_timer(int32_t number, clockid_t clock, int absolute, const struct itimerspec *new, struct itimerspec *old);
int look_at_timer(int32_t number, struct itimerspec *now);
int is_timer(int fd);
ssize_t read_timer(int fd, void *buffer, size_t size);

/* posix_timers.c */
void forget_timers(void); /* a fork has none */

#endif
