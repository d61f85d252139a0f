/* A fork has nothing of what its parent opened: rings are empty and over, events are its own, the helper is not its. */
#include "core.h"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct cw_ring *rings;

void cw_keep_ring(struct cw_ring *ring)
{
    pthread_mutex_lock(&lock);
    ring->process = cw_process();
    ring->before = &rings;
    ring->next = rings;
    if (rings != NULL)
        rings->before = &ring->next;
    rings = ring;
    pthread_mutex_unlock(&lock);
}

void cw_forget_ring(struct cw_ring *ring)
{
    pthread_mutex_lock(&lock);
    if (ring->before != NULL) {
        *ring->before = ring->next;
        if (ring->next != NULL)
            ring->next->before = ring->before;
    }
    ring->before = NULL;
    pthread_mutex_unlock(&lock);
}

/* Pointers that were handed out into a ring's memory stay good: to zeros of the child's own. */
static void leave_to_parent(struct cw_ring *ring)
{
    void *at = mmap(ring->mapping, ring->mapping_size, PROT_READ | PROT_WRITE,
                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);

    if (at == MAP_FAILED)
        _exit(127); /* else this child would write into its parent's queues */
    close(ring->own);
    if (ring->peer >= 0)
        close(ring->peer);
    ring->own = ring->peer = -1;
    ring->before = NULL;
}

static void before_fork(void)
{
    cw_lock_handles();
    pthread_mutex_lock(&lock);
}

static void in_parent(void)
{
    pthread_mutex_unlock(&lock);
    cw_unlock_handles();
}

static void in_child(void)
{
    pthread_mutex_init(&lock, NULL);
    cw_next_process();
    for (struct cw_ring *ring = rings; ring != NULL; ring = ring->next)
        leave_to_parent(ring);
    rings = NULL;
    cw_helper_in_child();
    cw_handles_in_child();
}

static void register_handlers(void)
{
    pthread_atfork(before_fork, in_parent, in_child);
}

void cw_prepare_forks(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    pthread_once(&once, register_handlers);
}
