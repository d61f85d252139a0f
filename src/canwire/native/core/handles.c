/* Handles: numbers for what a process has open, so that a wrong one is found out, whatever a program passes. */
#include "core.h"

#include <pthread.h>
#include <stdlib.h>

#define MOST_HANDLES (1u << 20)
#define AGES 1023u /* how often a place is used anew before an old handle would be taken for a new one */

struct place {
    struct cw_object *object;
    uint32_t age;
    uint32_t next_free; /* plus one */
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct place *places;
static uint32_t count, room, first_free; /* plus one */

/* 4 * (age, place + 1): handles are multiples of four, as Windows', and none is 0 or -1 */
static cw_handle handle_of(uint32_t at)
{
    return (cw_handle)(uintptr_t)(((uint64_t)(places[at].age & AGES) << 20 | (at + 1)) << 2);
}

static struct place *place_of(cw_handle handle)
{
    uint64_t number = (uint64_t)(uintptr_t)handle;
    uint64_t at = (number >> 2 & (MOST_HANDLES - 1)) - 1;

    return at < count && places[at].object != NULL && handle_of((uint32_t)at) == handle ? &places[at] : NULL;
}

static uint32_t free_place(void) /* under the lock; MOST_HANDLES: no memory */
{
    uint32_t at = first_free - 1;

    if (first_free != 0) {
        first_free = places[at].next_free;
        return at;
    }
    if (count == room) {
        uint32_t more = room == 0 ? 64 : room * 2;
        struct place *grown = more < MOST_HANDLES ? realloc(places, more * sizeof *grown) : NULL;
        if (grown == NULL)
            return MOST_HANDLES;
        places = grown;
        room = more;
    }
    places[count] = (struct place){0};
    return count++;
}

cw_handle cw_handle_new(struct cw_object *object)
{
    cw_handle made = NULL;
    uint32_t at;

    cw_prepare_forks();
    pthread_mutex_lock(&lock);
    at = free_place();
    if (at != MOST_HANDLES) {
        places[at].object = object;
        made = handle_of(at);
    }
    pthread_mutex_unlock(&lock);
    return made;
}

struct cw_object *cw_handle_get(cw_handle handle, const struct cw_kind *kind)
{
    struct cw_object *object = NULL;
    struct place *place;

    pthread_mutex_lock(&lock);
    place = place_of(handle);
    if (place != NULL && (kind == NULL || place->object->kind == kind)) {
        object = place->object;
        __atomic_add_fetch(&object->references, 1, __ATOMIC_RELAXED);
    }
    pthread_mutex_unlock(&lock);
    return object;
}

void cw_object_release(struct cw_object *object)
{
    if (__atomic_sub_fetch(&object->references, 1, __ATOMIC_ACQ_REL) == 0)
        object->kind->destroy(object);
}

int cw_handle_close(cw_handle handle)
{
    struct cw_object *object = NULL;
    struct place *place;

    pthread_mutex_lock(&lock);
    place = place_of(handle);
    if (place != NULL) {
        object = place->object;
        place->object = NULL;
        place->age++;
        place->next_free = first_free;
        first_free = (uint32_t)(place - places) + 1;
    }
    pthread_mutex_unlock(&lock);
    if (object == NULL)
        return -1;
    cw_object_release(object);
    return 0;
}

#ifndef _WIN32
void cw_lock_handles(void)
{
    pthread_mutex_lock(&lock);
}

void cw_unlock_handles(void)
{
    pthread_mutex_unlock(&lock);
}

void cw_handles_in_child(void)
{
    pthread_mutex_init(&lock, NULL);
    cw_events_in_child();
}
#endif
