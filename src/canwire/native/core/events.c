/* Events: a descriptor of their own, which `set` fills, and those of rings and notices that signal them.
 *
 * No thread passes signals on: who waits for an event waits for all of these descriptors, and takes what it finds.
 */
#include "core.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

struct source {
    struct cw_ring *ring; /* NULL: a descriptor alone */
    int descriptor;
    struct source *next;
};

struct cw_event {
    struct cw_object object;
    int manual_reset;
    int own; /* an eventfd */
    int any; /* an epoll of that and of the sources', so that who waits already hears of what is assigned later */
    pthread_mutex_t lock; /* of the sources */
    struct source *sources;
    struct cw_event *next, **before; /* of all events */
};

static pthread_mutex_t all_lock = PTHREAD_MUTEX_INITIALIZER;
static struct cw_event *all;

static void destroy(struct cw_object *object);
static int take(struct cw_object *object);
static int descriptor(struct cw_object *object);
const struct cw_kind cw_event_kind = {"event", destroy, take, descriptor};

static int heed(struct cw_event *event, int which)
{
    struct epoll_event about = {.events = EPOLLIN, .data.fd = which};

    return epoll_ctl(event->any, EPOLL_CTL_ADD, which, &about);
}

static int open_descriptors(struct cw_event *event, int signalled)
{
    event->own = eventfd(signalled ? 1 : 0, EFD_NONBLOCK | EFD_CLOEXEC);
    event->any = epoll_create1(EPOLL_CLOEXEC);
    if (event->own >= 0 && event->any >= 0 && heed(event, event->own) == 0)
        return 0;
    if (event->own >= 0)
        close(event->own);
    if (event->any >= 0)
        close(event->any);
    return -1;
}

struct cw_event *cw_event_new(int manual_reset, int signalled)
{
    struct cw_event *event = calloc(1, sizeof *event);

    if (event == NULL)
        return NULL;
    event->object = (struct cw_object){&cw_event_kind, 1};
    event->manual_reset = manual_reset;
    if (open_descriptors(event, signalled) < 0) {
        free(event);
        return NULL;
    }
    pthread_mutex_init(&event->lock, NULL);
    pthread_mutex_lock(&all_lock);
    event->before = &all;
    event->next = all;
    if (all != NULL)
        all->before = &event->next;
    all = event;
    pthread_mutex_unlock(&all_lock);
    return event;
}

static void destroy(struct cw_object *object)
{
    struct cw_event *event = (struct cw_event *)object;

    pthread_mutex_lock(&all_lock);
    *event->before = event->next;
    if (event->next != NULL)
        event->next->before = event->before;
    pthread_mutex_unlock(&all_lock);
    while (event->sources != NULL) {
        struct source *gone = event->sources;
        event->sources = gone->next;
        free(gone);
    }
    close(event->any);
    close(event->own);
    pthread_mutex_destroy(&event->lock);
    free(event);
}

void cw_event_set(struct cw_event *event)
{
    eventfd_write(event->own, 1);
    cw_changed();
}

/* Every signal there is, taken out of the sources; was there one? A ring then signals at the next occasion; one that is
 * over goes on signalling, until the program has found out. */
static int collect(struct cw_event *event)
{
    int found = 0;

    pthread_mutex_lock(&event->lock);
    for (struct source *source = event->sources; source != NULL; source = source->next) {
        int over = source->ring != NULL && cw_ring_over(source->ring);
        if (cw_drain(source->descriptor) || over) {
            found = 1;
            if (source->ring != NULL && !over)
                cw_ring_rearm(source->ring);
        }
    }
    pthread_mutex_unlock(&event->lock);
    return found;
}

void cw_event_reset(struct cw_event *event)
{
    eventfd_t count;

    collect(event);
    eventfd_read(event->own, &count);
}

static int take(struct cw_object *object)
{
    struct cw_event *event = (struct cw_event *)object;
    int signalled = collect(event);
    eventfd_t count;

    if (event->manual_reset) {
        struct pollfd about = {event->own, POLLIN, 0};
        if (signalled)
            cw_event_set(event);
        return poll(&about, 1, 0) > 0;
    }
    return (eventfd_read(event->own, &count) == 0) | signalled;
}

static int descriptor(struct cw_object *object)
{
    return ((struct cw_event *)object)->any;
}

static int add(struct cw_event *event, struct cw_ring *ring, int which)
{
    struct source *made = calloc(1, sizeof *made);
    int heard;

    if (made == NULL)
        return -1;
    *made = (struct source){ring, which, NULL};
    pthread_mutex_lock(&event->lock);
    made->next = event->sources;
    event->sources = made;
    heard = heed(event, which);
    pthread_mutex_unlock(&event->lock);
    return heard;
}

static void drop(struct cw_event *event, int which)
{
    pthread_mutex_lock(&event->lock);
    for (struct source **at = &event->sources; *at != NULL; at = &(*at)->next)
        if ((*at)->descriptor == which) {
            struct source *gone = *at;
            *at = gone->next;
            epoll_ctl(event->any, EPOLL_CTL_DEL, which, NULL);
            free(gone);
            break;
        }
    pthread_mutex_unlock(&event->lock);
}

struct cw_event *cw_event_of(cw_handle handle)
{
    return (struct cw_event *)cw_handle_get(handle, &cw_event_kind);
}

void cw_event_release(struct cw_event *event)
{
    cw_object_release(&event->object);
}

int cw_event_assign(struct cw_event *event, struct cw_ring *ring)
{
    struct cw_event *before = ring->event;

    if (before != NULL) {
        ring->event = NULL;
        if (ring->own >= 0)
            drop(before, ring->own);
        cw_object_release(&before->object);
    }
    if (event == NULL)
        return 0;
    cw_drain(ring->own); /* what was signalled before it was assigned is not meant for it */
    if (add(event, ring, ring->own) < 0)
        return -1;
    __atomic_add_fetch(&event->object.references, 1, __ATOMIC_RELAXED);
    ring->event = event;
    cw_ring_rearm(ring);
    return 0;
}

int cw_event_watch(struct cw_event *event, int which)
{
    if (add(event, NULL, which) < 0) {
        close(which);
        return -1;
    }
    __atomic_add_fetch(&event->object.references, 1, __ATOMIC_RELAXED);
    return 0;
}

void cw_event_forget(struct cw_event *event, int which)
{
    drop(event, which);
    close(which);
    cw_event_release(event);
}

/* Signals of a fork's are its own; nothing of the parent's signals them. */
void cw_events_in_child(void)
{
    pthread_mutex_init(&all_lock, NULL);
    for (struct cw_event *event = all; event != NULL; event = event->next) {
        int own = event->own, any = event->any;

        pthread_mutex_init(&event->lock, NULL);
        event->sources = NULL; /* not given back: another thread may have been changing them */
        if (open_descriptors(event, 0) < 0)
            _exit(127); /* else this child would take its parent's signals */
        dup3(event->own, own, O_CLOEXEC);
        dup3(event->any, any, O_CLOEXEC);
        close(event->own);
        close(event->any);
        event->own = own;
        event->any = any;
    }
}
