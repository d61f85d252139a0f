/* Mutexes, and locks for reading and writing, where programs keep one time: who waits for one that another thread holds
 * lets that thread run. Nobody is let run for a thread that takes no part: it holds the lock by the computer's clock.
 */
#include "timed.h"

#include <errno.h>
#include <pthread.h>

int64_t until_ns_of(clockid_t clock, const struct timespec *time)
{
    int64_t epoch_ns = clock == CLOCK_REALTIME ? (int64_t)shim_table->epoch_ns : 0;

    return time->tv_sec > NEVER / SECOND - 1 ? NEVER : time->tv_sec * SECOND + time->tv_nsec - epoch_ns;
}

int impossible_time(const struct timespec *time)
{
    return time->tv_nsec < 0 || time->tv_nsec >= SECOND;
}

/* One look after the other, each in a turn of this thread's; 0, ETIMEDOUT, what the look has found but EBUSY, or ENETDOWN
 * where whoever keeps the time is gone. */
static int look_in_time(int (*look)(void *), void *lock, int64_t until_ns)
{
    struct wait wait = {.until_ns = until_ns, .restarts = 1};
    int error;

    while ((error = look(lock)) == EBUSY) {
        if (wait.again && expired(&wait))
            return ETIMEDOUT;
        if (await_turn(&wait) < 0 && errno != EINTR)
            return errno;
    }
    return error;
}

static int look_at_mutex(void *mutex)
{
    return pthread_mutex_trylock(mutex);
}

int lock_in_time(pthread_mutex_t *mutex, int64_t until_ns)
{
    return look_in_time(look_at_mutex, mutex, until_ns);
}

/* EBUSY while a thread has it that takes part, and that is not this one; else what the C library's own call finds. */
static int look_or_lock(void *given)
{
    pthread_mutex_t *mutex = given;
    int error = pthread_mutex_trylock(mutex);

    if (error != EBUSY)
        return error;
    int owner = __atomic_load_n(&mutex->__data.__owner, __ATOMIC_RELAXED);
    return owner != 0 && other_keeps_time(owner) ? EBUSY : REAL(pthread_mutex_lock)(mutex);
}

__attribute__((constructor)) static void find_function(void) /* before an allocator's mutex is contended */
{
    (void)REAL(pthread_mutex_lock);
}

EXPORT int pthread_mutex_lock(pthread_mutex_t *mutex)
{
    int error;

    if (!timed() || !keeps_time())
        return REAL(pthread_mutex_lock)(mutex);
    error = look_in_time(look_or_lock, mutex, NEVER);
    return error == ENETDOWN ? REAL(pthread_mutex_lock)(mutex) : error; /* who keeps the time is gone */
}

EXPORT int pthread_mutex_timedlock(pthread_mutex_t *restrict mutex, const struct timespec *restrict time)
{
    if (!timed() || impossible_time(time))
        return REAL(pthread_mutex_timedlock)(mutex, time);
    return lock_in_time(mutex, until_ns_of(CLOCK_REALTIME, time));
}

int pthread_mutex_clocklock(pthread_mutex_t *mutex, clockid_t clock, const struct timespec *time);

EXPORT int pthread_mutex_clocklock(pthread_mutex_t *mutex, clockid_t clock, const struct timespec *time)
{
    if (!timed() || impossible_time(time))
        return REAL(pthread_mutex_clocklock)(mutex, clock, time);
    return lock_in_time(mutex, until_ns_of(clock, time));
}

EXPORT int pthread_barrier_wait(pthread_barrier_t *barrier) /* nobody can look whether it would wait */
{
    static int noted;

    if (timed() && keeps_time() && !__atomic_exchange_n(&noted, 1, __ATOMIC_RELAXED))
        note(NOTE_CLOCK, "pthread_barrier_wait");
    return REAL(pthread_barrier_wait)(barrier);
}

/* locks for reading and writing: who reads is not known, so whoever waits is taken to wait for one that takes part */

static int look_to_read(void *lock)
{
    return pthread_rwlock_tryrdlock(lock);
}

static int look_to_write(void *lock)
{
    return pthread_rwlock_trywrlock(lock);
}

static int is_own(const pthread_rwlock_t *lock)
{
    return __atomic_load_n(&lock->__data.__cur_writer, __ATOMIC_RELAXED) == own_number();
}

EXPORT int pthread_rwlock_rdlock(pthread_rwlock_t *lock)
{
    int error = timed() && keeps_time() && !is_own(lock) ? look_in_time(look_to_read, lock, NEVER) : ENETDOWN;

    return error == ENETDOWN ? REAL(pthread_rwlock_rdlock)(lock) : error;
}

EXPORT int pthread_rwlock_wrlock(pthread_rwlock_t *lock)
{
    int error = timed() && keeps_time() && !is_own(lock) ? look_in_time(look_to_write, lock, NEVER) : ENETDOWN;

    return error == ENETDOWN ? REAL(pthread_rwlock_wrlock)(lock) : error;
}

EXPORT int pthread_rwlock_timedrdlock(pthread_rwlock_t *restrict lock, const struct timespec *restrict time)
{
    if (!timed() || impossible_time(time) || is_own(lock))
        return REAL(pthread_rwlock_timedrdlock)(lock, time);
    return look_in_time(look_to_read, lock, until_ns_of(CLOCK_REALTIME, time));
}

EXPORT int pthread_rwlock_timedwrlock(pthread_rwlock_t *restrict lock, const struct timespec *restrict time)
{
    if (!timed() || impossible_time(time) || is_own(lock))
        return REAL(pthread_rwlock_timedwrlock)(lock, time);
    return look_in_time(look_to_write, lock, until_ns_of(CLOCK_REALTIME, time));
}
