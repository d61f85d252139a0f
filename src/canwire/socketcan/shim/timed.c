/* Turns: a thread waits until the server lets it look. */
#include "timed.h"

#include <errno.h>
#include <pthread.h>
#include <unistd.h>

static pthread_key_t leaving;

/* A thread has ended: time waits for it no longer. */
static void leave(void *nothing)
{
    struct request request = {.operation = LEAVE_TIME};

    (void)nothing;
    thread_ends();
    seat_left();
    if (timed())
        ask(&request, NULL, 0, NULL, NULL, NULL, 0);
}

__attribute__((constructor)) static void make_key(void)
{
    pthread_key_create(&leaving, leave);
}

int64_t hub_now_ns(void)
{
    return (int64_t)__atomic_load_n(&shim_table->now_ns, __ATOMIC_ACQUIRE);
}

int64_t wait_end_ns(const struct timespec *span)
{
    int64_t now_ns = hub_now_ns();

    if (span == NULL || span->tv_sec > (NEVER - now_ns) / SECOND - 1)
        return NEVER;
    return now_ns + span->tv_sec * SECOND + span->tv_nsec;
}

struct timespec span_of(int64_t ns)
{
    if (ns < 0)
        ns = 0;
    return (struct timespec){.tv_sec = (time_t)(ns / SECOND), .tv_nsec = (long)(ns % SECOND)};
}

int expired(const struct wait *wait)
{
    return hub_now_ns() >= wait->until_ns;
}

/* This signal has come with this turn: its handler has run, and the call ends as the kernel's would. */
static int interrupts(const struct wait *wait, int number)
{
    struct sigaction action;
    sigset_t blocked;

    sigaction(number, NULL, &action);
    if (wait->mask != NULL)
        blocked = *wait->mask;
    else
        pthread_sigmask(SIG_SETMASK, NULL, &blocked);
    if (action.sa_handler == SIG_IGN || sigismember(&blocked, number))
        return 0;
    return !(wait->restarts && action.sa_flags & SA_RESTART);
}

void take_part(void)
{
    struct request request = {.operation = TAKE_PART};

    pthread_setspecific(leaving, &leaving);
    ask(&request, NULL, 0, NULL, NULL, NULL, 0);
}

int await_turn(struct wait *wait)
{
    struct request request = {.operation = AWAIT_TURN, .slot = wait->child, .b = wait->restarts};
    sigset_t before;
    long done;

    request.a = (wait->again ? AGAIN : 0) | (wait->sleeps ? SLEEPS : 0);
    pthread_setspecific(leaving, &leaving);
    waits_itself();
    if (wait->mask != NULL)
        pthread_sigmask(SIG_SETMASK, wait->mask, &before);
    done = ask(&request, &wait->until_ns, sizeof wait->until_ns, NULL, NULL, NULL, 0);
    int error = errno;
    if (wait->mask != NULL)
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    errno = error;
    wait->again = 1;
    if (done > 0 && interrupts(wait, (int)done)) {
        errno = EINTR;
        done = -1;
    }
    return done < 0 ? -1 : 0;
}

int sleep_until(int64_t until_ns)
{
    struct wait wait = {.until_ns = until_ns, .sleeps = 1};

    do
        if (await_turn(&wait) < 0)
            return -1;
    while (!expired(&wait));
    return 0;
}
