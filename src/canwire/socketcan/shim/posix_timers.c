/* timer_create by the hub's time: the server sends the signal, or a thread of the program's waits for the timer and calls
 * the function, as the C library's does. sigwait and its kin look whether the signal has come.
 */
#include "timed.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#define MOST 256
#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

struct timer {
    int32_t number; /* the server's, from 1 up; 0: this one is free */
    clockid_t clock;
    int fd, over; /* SIGEV_THREAD: its thread reads this, and ends when it is over */
    void (*call)(union sigval);
    union sigval value;
    pthread_attr_t *kind;
};

static struct timer timers[MOST];
static pthread_mutex_t making = PTHREAD_MUTEX_INITIALIZER;

void forget_timers(void)
{
    memset(timers, 0, sizeof timers);
}

static struct timer *ours(timer_t timer)
{
    struct timer *found = (struct timer *)timer;

    return timed() && found >= timers && found < timers + MOST && found->number != 0 ? found : NULL;
}

static struct timer *reserved(void)
{
    struct timer *found = NULL;

    pthread_mutex_lock(&making);
    for (int at = 0; at < MOST && found == NULL; at++)
        if (timers[at].number == 0)
            found = &timers[at];
    if (found != NULL)
        *found = (struct timer){.number = -1};
    pthread_mutex_unlock(&making);
    if (found == NULL)
        errno = EAGAIN;
    return found;
}

static void *goes_off(void *given)
{
    struct timer timer = *(struct timer *)given;

    timer.call(timer.value);
    return NULL;
}

static void *watches(void *given)
{
    struct timer *timer = given;
    pthread_t called;
    uint64_t times;

    while (read_timer(timer->fd, &times, sizeof times) == sizeof times && !timer->over)
        if (pthread_create(&called, timer->kind, goes_off, timer) == 0)
            pthread_detach(called);
    close(timer->fd);
    timer->number = 0;
    return NULL;
}

static int watched(struct timer *timer)
{
    pthread_t watcher;
    int error = pthread_create(&watcher, NULL, watches, timer);

    if (error != 0) {
        errno = error;
        return -1;
    }
    pthread_detach(watcher);
    return 0;
}

static int made(struct timer *timer, const struct sigevent *event)
{
    int64_t value = (int64_t)(intptr_t)event->sigev_value.sival_ptr;
    struct request request = {.operation = OPEN_TIMER};

    if (event->sigev_notify == SIGEV_SIGNAL || event->sigev_notify == SIGEV_THREAD_ID)
        request.b = event->sigev_signo;
    if (event->sigev_notify == SIGEV_THREAD_ID)
        request.slot = event->sigev_notify_thread_id;
    long number = ask(&request, &value, sizeof value, NULL, NULL, &timer->fd, 1);
    if (number < 0)
        return -1;
    timer->number = (int32_t)number;
    if (event->sigev_notify == SIGEV_THREAD) {
        timer->call = event->sigev_notify_function;
        timer->kind = event->sigev_notify_attributes;
        timer->value = event->sigev_value;
        return watched(timer);
    }
    close(timer->fd); /* nobody reads it */
    return 0;
}

static int impossible_event(const struct sigevent *event)
{
    if (event->sigev_notify == SIGEV_THREAD_ID && syscall(SYS_tgkill, getpid(), event->sigev_notify_thread_id, 0) < 0)
        return 1;
    return (event->sigev_notify == SIGEV_SIGNAL || event->sigev_notify == SIGEV_THREAD_ID) &&
           (event->sigev_signo < 1 || event->sigev_signo > SIGRTMAX);
}

EXPORT int timer_create(clockid_t clock, struct sigevent *restrict event, timer_t *restrict timer)
{
    struct sigevent usual = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGALRM};

    if (!timed() || clock < 0 || clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID)
        return REAL(timer_create)(clock, event, timer);
    if (event != NULL && impossible_event(event)) {
        errno = EINVAL;
        return -1;
    }
    struct timer *found = reserved();
    if (found == NULL)
        return -1;
    usual.sigev_value.sival_ptr = found;
    found->clock = clock;
    if (made(found, event != NULL ? event : &usual) < 0) {
        found->number = 0;
        return -1;
    }
    *timer = (timer_t)found;
    return 0;
}

EXPORT int timer_settime(timer_t timer, int flags, const struct itimerspec *restrict new,
                         struct itimerspec *restrict old)
{
    struct timer *found = ours(timer);

    if (found == NULL)
        return REAL(timer_settime)(timer, flags, new, old);
    return set_kept_timer(found->number, found->clock, flags & TIMER_ABSTIME, new, old);
}

EXPORT int timer_gettime(timer_t timer, struct itimerspec *now)
{
    struct timer *found = ours(timer);

    return found == NULL ? REAL(timer_gettime)(timer, now) : look_at_timer(found->number, now);
}

EXPORT int timer_getoverrun(timer_t timer) /* a program that handles a signal has time stand meanwhile */
{
    return ours(timer) != NULL ? 0 : REAL(timer_getoverrun)(timer);
}

EXPORT int timer_delete(timer_t timer)
{
    static const struct itimerspec never, now = {.it_value = {.tv_nsec = 1}};
    struct timer *found = ours(timer);

    if (found == NULL)
        return REAL(timer_delete)(timer);
    if (found->call == NULL) {
        set_kept_timer(found->number, found->clock, 0, &never, NULL);
        found->number = 0;
        return 0;
    }
    found->over = 1;
    return set_kept_timer(found->number, found->clock, 0, &now, NULL); /* its thread frees it */
}

/* signals that are waited for */

static int waited_for(const sigset_t *set, siginfo_t *info, int64_t until_ns)
{
    static const struct timespec none;
    struct wait wait = {.until_ns = until_ns};

    for (;;) {
        int number = REAL(sigtimedwait)(set, info, &none);
        if (number > 0 || errno != EAGAIN || (wait.again && expired(&wait)))
            return number;
        if (await_turn(&wait) < 0)
            return -1;
    }
}

EXPORT int sigtimedwait(const sigset_t *restrict set, siginfo_t *restrict info, const struct timespec *restrict span)
{
    return timed() ? waited_for(set, info, wait_end_ns(span)) : REAL(sigtimedwait)(set, info, span);
}

EXPORT int sigwaitinfo(const sigset_t *restrict set, siginfo_t *restrict info)
{
    return timed() ? waited_for(set, info, NEVER) : REAL(sigwaitinfo)(set, info);
}

EXPORT int sigwait(const sigset_t *restrict set, int *restrict number)
{
    if (!timed())
        return REAL(sigwait)(set, number);
    do
        *number = waited_for(set, NULL, NEVER);
    while (*number < 0 && errno == EINTR); /* sigwait never ends so */
    return *number < 0 ? errno : 0;
}
