/* What time it is, and sleeping. */
#include "windows_core.h"

#include <errno.h>
#include <sched.h>
#include <time.h>

/* The hub's time where the program keeps one with others. */
static ULONGLONG now_ns(void)
{
    int64_t kept = cw_timed() ? cw_hub_now() : -1;
    struct timespec now;

    if (kept >= 0)
        return (ULONGLONG)kept;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (ULONGLONG)now.tv_sec * 1000000000u + (ULONGLONG)now.tv_nsec;
}

void Sleep(DWORD milliseconds)
{
    struct timespec span = {milliseconds / 1000, milliseconds % 1000 * 1000000l};

    if (cw_sleep(milliseconds == INFINITE ? CW_FOR_EVER : (int64_t)milliseconds))
        return;
    if (milliseconds == 0)
        sched_yield();
    else
        while ((milliseconds == INFINITE ? clock_nanosleep(CLOCK_MONOTONIC, 0, &(struct timespec){1 << 20, 0}, NULL)
                                         : clock_nanosleep(CLOCK_MONOTONIC, 0, &span, &span)) == EINTR ||
               milliseconds == INFINITE)
            ;
}

DWORD SleepEx(DWORD milliseconds, BOOL alertable)
{
    (void)alertable;
    Sleep(milliseconds);
    return 0;
}

ULONGLONG GetTickCount64(void)
{
    return now_ns() / 1000000u;
}

DWORD GetTickCount(void)
{
    return (DWORD)GetTickCount64();
}

DWORD timeGetTime(void)
{
    return GetTickCount();
}

BOOL QueryPerformanceCounter(PLARGE_INTEGER count)
{
    if (count == NULL)
        return cw_fail(ERROR_INVALID_PARAMETER);
    count->QuadPart = (LONGLONG)now_ns();
    return TRUE;
}

BOOL QueryPerformanceFrequency(PLARGE_INTEGER hertz)
{
    if (hertz == NULL)
        return cw_fail(ERROR_INVALID_PARAMETER);
    hertz->QuadPart = 1000000000;
    return TRUE;
}

static void split(LPSYSTEMTIME into, struct tm *(*by)(const time_t *, struct tm *))
{
    int64_t kept = cw_timed() ? cw_hub_now() : -1; /* since 1970 then */
    struct timespec now = {(time_t)(kept / 1000000000), (long)(kept % 1000000000)};
    struct tm parts;

    if (kept < 0)
        clock_gettime(CLOCK_REALTIME, &now);
    by(&now.tv_sec, &parts);
    *into = (SYSTEMTIME){(WORD)(parts.tm_year + 1900), (WORD)(parts.tm_mon + 1), (WORD)parts.tm_wday,
                         (WORD)parts.tm_mday,          (WORD)parts.tm_hour,      (WORD)parts.tm_min,
                         (WORD)parts.tm_sec,           (WORD)(now.tv_nsec / 1000000)};
}

void GetLocalTime(LPSYSTEMTIME time)
{
    split(time, localtime_r);
}

void GetSystemTime(LPSYSTEMTIME time)
{
    split(time, gmtime_r);
}
