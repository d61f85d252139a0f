/* Deadlines, and polling until one. */
#include "core.h"

#include <errno.h>
#include <time.h>

#define MILLISECOND 1000000ll
#define SECOND 1000000000ll
#define LONGEST_MS (INT64_MAX / MILLISECOND / 4)

int64_t cw_clock_now(void)
{
    struct timespec time;

    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * SECOND + time.tv_nsec;
}

int64_t cw_deadline(int64_t milliseconds)
{
    int64_t now;

    if (milliseconds < 0 || milliseconds > LONGEST_MS)
        return INT64_MAX;
    now = cw_timed() ? cw_hub_now() : -1;
    return (now < 0 ? cw_clock_now() : now) + milliseconds * MILLISECOND;
}

int cw_poll(struct pollfd *about, nfds_t count, int64_t until)
{
    int found = cw_timed() ? cw_poll_by_turns(about, count, &until) : -1;

    while (found < 0) {
        int64_t left = until == INT64_MAX ? 0 : until - cw_clock_now();
        struct timespec span = {left > 0 ? left / SECOND : 0, left > 0 ? left % SECOND : 0};

        found = ppoll(about, count, until == INT64_MAX ? NULL : &span, NULL);
        if (found < 0 && errno != EINTR) /* else a program's handler has run: Windows' calls know no signals */
            break;
    }
    return found;
}
