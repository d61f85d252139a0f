/* Who begins threads takes part before they do, and a fork before its parent goes on. Either may never wait by the hub's
 * time, or not for long: it leaves again when it would block elsewhere before it ever has.
 */
#include "timed.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

static __thread int has_only_begun, has_waited;

void waits_itself(void)
{
    has_only_begun = 0;
    has_waited = 1;
    seat_taken();
}

void begin_threads(void)
{
    if (has_waited || has_only_begun)
        return;
    take_part();
    has_only_begun = 1;
    seat_taken();
}

void leave_if_begun(void)
{
    struct request request = {.operation = LEAVE_TIME};

    if (!has_only_begun)
        return;
    ask(&request, NULL, 0, NULL, NULL, NULL, 0);
    seat_left();
    has_only_begun = 0;
}

void reads_elsewhere(int fd)
{
    struct pollfd there = {fd, POLLIN, 0};

    if (has_only_begun && REAL(poll)(&there, 1, 0) == 0)
        leave_if_begun();
}

/* As its parent does, or not at all. */
static void take_part_as(long parent)
{
    struct request request = {.operation = TAKE_PART, .a = (int32_t)parent};

    has_waited = 0;
    has_only_begun = ask(&request, NULL, 0, NULL, NULL, NULL, 0) == 0;
    if (has_only_begun)
        seat_taken();
}

EXPORT pid_t fork(void)
{
    long parent = syscall(SYS_gettid);
    int seated[2];
    char none;

    if (!timed() || pipe2(seated, O_CLOEXEC) < 0)
        return REAL(fork)();
    pid_t child = REAL(fork)();
    if (child == 0) {
        forget_timers();
        forget_seats();
        take_part_as(parent);
        while (REAL(write)(seated[1], "", 1) < 0 && errno == EINTR)
            ;
    }
    REAL(close)(seated[1]);
    while (child > 0 && REAL(read)(seated[0], &none, 1) < 0 && errno == EINTR)
        ; /* nothing comes, and the read ends, if the child was killed before */
    REAL(close)(seated[0]);
    return child;
}
