#include "object.h"

#include <pthread.h>

// A program that uses what it has released gets VCI_E_INVHANDLE as long as this remembers it.
static const unsigned REMEMBERED = 1024;
static void *retired[REMEMBERED];
static unsigned next;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

void *new_object(size_t size)
{
    return calloc(1, size);
}

void retire_object(void *object)
{
    void *oldest;

    pthread_mutex_lock(&lock);
    oldest = retired[next];
    retired[next] = object;
    next = (next + 1) % REMEMBERED;
    pthread_mutex_unlock(&lock);
    free(oldest);
}
