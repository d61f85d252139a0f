/* The hub's one time, where CANWIRE_TIMED is 1: a thread that waits looks again at each of its turns, which the helper
 * knows (../helper/turns.py). Each thread is known there by a socket of its own. */
#include "core.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define UNKNOWN (-1)

static __thread struct {
    cw_socket socket;
    uint32_t process; /* a socket of another one is over */
    int made;
} own;
static __thread uint32_t changed; /* something that others may wait for, since this thread's last turn */
static __thread int64_t last = UNKNOWN; /* the time when this thread was told it last */

static pthread_key_t ending;
static pthread_once_t once = PTHREAD_ONCE_INIT;

int cw_timed(void)
{
    static int kept = UNKNOWN;
    int known = __atomic_load_n(&kept, __ATOMIC_RELAXED);

    if (known == UNKNOWN) {
        const char *said = getenv("CANWIRE_TIMED");
        known = said != NULL && strcmp(said, "1") == 0;
        __atomic_store_n(&kept, known, __ATOMIC_RELAXED);
    }
    return known;
}

void cw_thread_socket_forget(void)
{
    if (own.made)
        cw_socket_close(own.socket);
    own.made = 0;
}

static void thread_ends(void *nothing)
{
    (void)nothing;
    cw_thread_socket_forget();
}

static void make_key(void)
{
    pthread_key_create(&ending, thread_ends);
}

cw_socket cw_thread_socket(void)
{
    if (own.made && own.process != cw_process())
        cw_thread_socket_forget();
    if (!own.made) {
        own.process = cw_process();
        own.socket = cw_socket_new();
        own.made = own.socket != CW_NO_SOCKET;
        pthread_once(&once, make_key);
        pthread_setspecific(ending, &own);
    }
    return own.made ? own.socket : CW_NO_SOCKET;
}

/* The answer of the helper is the time; UNKNOWN where this thread takes no part. */
static int64_t ask(const char *method, uint32_t number, int64_t about, uint32_t *value)
{
    struct {
        int64_t about;
        uint32_t changed, none;
    } in = {about, changed, 0};
    int64_t now;
    struct cw_call call = {
        .method = method, .object = number, .in = &in, .in_size = sizeof in, .out = &now, .out_size = sizeof now};

    if (!cw_timed() || cw_call(&call) < 0 || call.result != 0 || call.out_length != sizeof now)
        return UNKNOWN;
    changed = 0;
    if (value != NULL)
        *value = call.value;
    return last = now;
}

int64_t cw_hub_now(void)
{
    return ask("time.now", 0, 0, NULL);
}

int64_t cw_await_turn(int64_t until)
{
    return ask("time.wait", 0, until, NULL);
}

int cw_sleep(int64_t milliseconds)
{
    return cw_timed() && ask("time.sleep", 0, cw_deadline(milliseconds), NULL) != UNKNOWN;
}

void cw_changed(void)
{
    changed = 1;
}

int cw_others_run(void)
{
    return cw_await_turn(INT64_MAX) != UNKNOWN;
}

uint32_t cw_expect_thread(void)
{
    uint32_t number = 0;

    ask("time.expect", 0, 0, &number);
    return number;
}

void cw_thread_begins(uint32_t number, int succeeded)
{
    if (number != 0)
        ask(succeeded ? "time.begin" : "time.forget", number, number, NULL);
}

/* Is anything there before the time is over? UNKNOWN: this thread takes no part any longer, and `until` is the clock's. */
int cw_poll_by_turns(struct pollfd *about, nfds_t count, int64_t *until)
{
    for (;;) {
        int64_t before = last;
        int found = poll(about, count, 0);

        if (found > 0 || (found < 0 && errno != EINTR))
            return found;
        if (found == 0 && last != UNKNOWN && *until <= last)
            return 0;
        if (found == 0 && cw_await_turn(*until) == UNKNOWN) {
            if (before != UNKNOWN && *until != INT64_MAX)
                *until = cw_clock_now() + *until - before;
            last = UNKNOWN;
            return UNKNOWN;
        }
    }
}
