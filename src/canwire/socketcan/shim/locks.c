/* Semaphores, conditions and joins, where programs keep one time: who waits for another thread lets it run, and the
 * timeout is the hub's. They look whenever another thread of the program begins a wait or ends.
 */
#include "timed.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <string.h>

#define CONDITIONS 1024 /* counters of signals; two conditions may have one together, which wakes some for nothing */
#define ENDED 256

static uint64_t signals[CONDITIONS];
static pthread_t ended[ENDED]; /* threads that take part no longer, though they may not be quite gone ... */
static uint32_t ends;          /* ... and how many there were */

void thread_ends(void)
{
    uint32_t at = __atomic_fetch_add(&ends, 1, __ATOMIC_ACQ_REL);

    __atomic_store_n(&ended[at % ENDED], pthread_self(), __ATOMIC_RELEASE);
}

static int has_ended(pthread_t thread)
{
    for (int at = 0; at < ENDED; at++)
        if (__atomic_load_n(&ended[at], __ATOMIC_ACQUIRE) == thread)
            return 1;
    return 0;
}

static void begins_again(pthread_t thread) /* its name may be given to another one */
{
    for (int at = 0; at < ENDED; at++)
        if (__atomic_load_n(&ended[at], __ATOMIC_ACQUIRE) == thread)
            __atomic_store_n(&ended[at], 0, __ATOMIC_RELEASE);
}

/* semaphores */

static int sem_in_time(sem_t *semaphore, int64_t until_ns)
{
    struct wait wait = {.until_ns = until_ns, .restarts = 1};

    while (sem_trywait(semaphore) < 0) {
        if (errno != EAGAIN)
            return -1;
        if (wait.again && expired(&wait)) {
            errno = ETIMEDOUT;
            return -1;
        }
        if (await_turn(&wait) < 0)
            return -1;
    }
    return 0;
}

static int sem_until(sem_t *semaphore, clockid_t clock, const struct timespec *time)
{
    if (sem_trywait(semaphore) == 0)
        return 0;
    if (impossible_time(time)) {
        errno = EINVAL;
        return -1;
    }
    return sem_in_time(semaphore, until_ns_of(clock, time));
}

EXPORT int sem_wait(sem_t *semaphore)
{
    return timed() ? sem_in_time(semaphore, NEVER) : REAL(sem_wait)(semaphore);
}

EXPORT int sem_timedwait(sem_t *restrict semaphore, const struct timespec *restrict time)
{
    return timed() ? sem_until(semaphore, CLOCK_REALTIME, time) : REAL(sem_timedwait)(semaphore, time);
}

int sem_clockwait(sem_t *restrict semaphore, clockid_t clock, const struct timespec *restrict time);

EXPORT int sem_clockwait(sem_t *restrict semaphore, clockid_t clock, const struct timespec *restrict time)
{
    return timed() ? sem_until(semaphore, clock, time) : REAL(sem_clockwait)(semaphore, clock, time);
}

/* conditions */

static uint64_t *signals_of(const pthread_cond_t *condition)
{
    return &signals[(uintptr_t)condition / sizeof(void *) * 2654435761u % CONDITIONS];
}

static int condition_in_time(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t until_ns)
{
    struct wait wait = {.until_ns = until_ns, .restarts = 1};
    uint64_t *counter = signals_of(condition), before = __atomic_load_n(counter, __ATOMIC_ACQUIRE);
    int error = pthread_mutex_unlock(mutex), late = 0;

    if (error != 0)
        return error;
    do {
        if (await_turn(&wait) < 0 && errno != EINTR)
            break; /* whoever keeps the time is gone: it may look by itself */
        late = expired(&wait);
    } while (__atomic_load_n(counter, __ATOMIC_ACQUIRE) == before && !late);
    late = late && __atomic_load_n(counter, __ATOMIC_ACQUIRE) == before;
    error = lock_in_time(mutex, NEVER);
    return error != 0 ? error : late ? ETIMEDOUT : 0;
}

EXPORT int pthread_cond_wait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex)
{
    return timed() ? condition_in_time(condition, mutex, NEVER) : NEWER(pthread_cond_wait)(condition, mutex);
}

/* The clock that the condition was made with: glibc has it in the second bit of its flags. */
static clockid_t clock_of(const pthread_cond_t *condition)
{
    return condition->__data.__wrefs & 2 ? CLOCK_MONOTONIC : CLOCK_REALTIME;
}

EXPORT int pthread_cond_timedwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex,
                                  const struct timespec *restrict time)
{
    if (!timed() || impossible_time(time))
        return NEWER(pthread_cond_timedwait)(condition, mutex, time);
    return condition_in_time(condition, mutex, until_ns_of(clock_of(condition), time));
}

int pthread_cond_clockwait(pthread_cond_t *condition, pthread_mutex_t *mutex, clockid_t clock,
                           const struct timespec *time);

EXPORT int pthread_cond_clockwait(pthread_cond_t *condition, pthread_mutex_t *mutex, clockid_t clock,
                                  const struct timespec *time)
{
    if (!timed() || impossible_time(time))
        return REAL(pthread_cond_clockwait)(condition, mutex, clock, time);
    return condition_in_time(condition, mutex, until_ns_of(clock, time));
}

EXPORT int pthread_cond_signal(pthread_cond_t *condition)
{
    if (timed())
        __atomic_fetch_add(signals_of(condition), 1, __ATOMIC_ACQ_REL);
    return NEWER(pthread_cond_signal)(condition);
}

EXPORT int pthread_cond_broadcast(pthread_cond_t *condition)
{
    if (timed())
        __atomic_fetch_add(signals_of(condition), 1, __ATOMIC_ACQ_REL);
    return NEWER(pthread_cond_broadcast)(condition);
}

/* threads: each takes part from its beginning to its end */

struct beginning {
    void *(*routine)(void *);
    void *argument;
    sem_t seated;
};

static void *begin(void *given)
{
    struct beginning *from = given, own = *from;
    struct wait wait = {.until_ns = hub_now_ns(), .restarts = 1, .again = 1};

    begins_again(pthread_self());
    take_part();
    sem_post(&from->seated); /* who began it has left it waiting for its first turn */
    await_turn(&wait);
    return own.routine(own.argument);
}

EXPORT int pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict kind, void *(*routine)(void *),
                          void *restrict argument)
{
    struct beginning from = {routine, argument, {{0}}};
    int error;

    if (!timed())
        return REAL(pthread_create)(thread, kind, routine, argument);
    begin_threads();
    sem_init(&from.seated, 0, 0);
    error = REAL(pthread_create)(thread, kind, begin, &from);
    while (error == 0 && REAL(sem_wait)(&from.seated) < 0)
        ;
    sem_destroy(&from.seated);
    return error;
}

EXPORT int pthread_join(pthread_t thread, void **result)
{
    struct wait wait = {.until_ns = NEVER, .restarts = 1};

    while (timed() && !has_ended(thread))
        if (await_turn(&wait) < 0 && errno != EINTR)
            break;
    return REAL(pthread_join)(thread, result);
}
