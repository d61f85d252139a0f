/* Which threads of this process take part in the hub's time. */
#include "timed.h"

#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#define MOST 1024 /* what is beyond is taken not to take part, by those who wait for its locks */

static int32_t seated[MOST]; /* thread numbers; 0: free */
static __thread int32_t *place;

int own_number(void)
{
    return place != NULL ? *place : (int)syscall(SYS_gettid);
}

void seat_taken(void)
{
    int32_t own = own_number(), none = 0;

    for (int at = 0; place == NULL && at < MOST; at++, none = 0)
        if (__atomic_compare_exchange_n(&seated[at], &none, own, 0, __ATOMIC_ACQ_REL, __ATOMIC_RELAXED))
            place = &seated[at];
}

void seat_left(void)
{
    if (place != NULL)
        __atomic_store_n(place, 0, __ATOMIC_RELEASE);
    place = NULL;
}

void forget_seats(void)
{
    memset(seated, 0, sizeof seated);
    place = NULL;
}

int keeps_time(void)
{
    return place != NULL;
}

int other_keeps_time(int number)
{
    for (int at = 0; at < MOST; at++)
        if (&seated[at] != place && __atomic_load_n(&seated[at], __ATOMIC_ACQUIRE) == number)
            return 1;
    return 0;
}
