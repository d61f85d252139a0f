/* Deadlines, and polling until one. */
#include "core.h"

#include <errno.h>
#include <time.h>

#define MILLISECOND 1000000ll
#define SECOND 1000000000ll
#define LONGEST_MS (INT64_MAX / MILLISECOND / 4)

static int64_t now(void)
{
    struct timespec time;

    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * SECOND + time.tv_nsec;
}

int64_t cw_deadline(int64_t milliseconds)
{
    return milliseconds < 0 || milliseconds > LONGEST_MS ? INT64_MAX : now() + milliseconds * MILLISECOND;
}

int cw_poll(struct pollfd *about, nfds_t count, int64_t until)
{
    for (;;) {
        int64_t left = until == INT64_MAX ? 0 : until - now();
        struct timespec span = {left > 0 ? left / SECOND : 0, left > 0 ? left % SECOND : 0};
        int found = ppoll(about, count, until == INT64_MAX ? NULL : &span, NULL);

        if (found >= 0 || errno != EINTR) /* a program's handler has run: Windows' calls know no signals */
            return found;
    }
}
