/* Semaphores and mutexes: a count in an eventfd, of which a wait takes one. */
#include "windows_core.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

struct counted {
    struct cw_object object;
    int count;
    LONG most;
    pthread_mutex_t lock; /* of what follows */
    DWORD owner;          /* a mutex's thread, which may take it again */
    LONG times;
};

static void destroy(struct cw_object *object)
{
    struct counted *counted = (struct counted *)object;

    close(counted->count);
    pthread_mutex_destroy(&counted->lock);
    free(counted);
}

static int take(struct cw_object *object)
{
    eventfd_t one;

    return eventfd_read(((struct counted *)object)->count, &one) == 0;
}

static int descriptor(struct cw_object *object)
{
    return ((struct counted *)object)->count;
}

static int take_mutex(struct cw_object *object)
{
    struct counted *mutex = (struct counted *)object;
    int taken;

    pthread_mutex_lock(&mutex->lock);
    taken = mutex->times > 0 ? mutex->owner == GetCurrentThreadId() : take(object);
    if (taken) {
        mutex->owner = GetCurrentThreadId();
        mutex->times++;
    }
    pthread_mutex_unlock(&mutex->lock);
    return taken;
}

static const struct cw_kind semaphore_kind = {"semaphore", destroy, take, descriptor};
static const struct cw_kind mutex_kind = {"mutex", destroy, take_mutex, descriptor};

static struct counted *made(const struct cw_kind *kind, LONG first, LONG most)
{
    struct counted *counted = calloc(1, sizeof *counted);

    if (counted == NULL)
        return NULL;
    counted->object = (struct cw_object){kind, 1};
    counted->most = most;
    counted->count = eventfd((unsigned)first, EFD_SEMAPHORE | EFD_NONBLOCK | EFD_CLOEXEC);
    if (counted->count < 0) {
        free(counted);
        return NULL;
    }
    pthread_mutex_init(&counted->lock, NULL);
    return counted;
}

HANDLE CreateSemaphoreA(LPSECURITY_ATTRIBUTES rights, LONG first, LONG most, LPCSTR name)
{
    (void)rights, (void)name;
    if (most < 1 || first < 0 || first > most) {
        cw_fail(ERROR_INVALID_PARAMETER);
        return NULL;
    }
    return cw_handle_or_fail((struct cw_object *)made(&semaphore_kind, first, most));
}

BOOL ReleaseSemaphore(HANDLE semaphore, LONG count, LPLONG before)
{
    struct counted *found = (struct counted *)cw_handle_get(semaphore, &semaphore_kind);
    LONG there = 0, allowed;
    eventfd_t one;

    if (found == NULL)
        return cw_fail(ERROR_INVALID_HANDLE);
    pthread_mutex_lock(&found->lock);
    while (eventfd_read(found->count, &one) == 0)
        there++;
    allowed = count >= 1 && count <= found->most - there;
    eventfd_write(found->count, (eventfd_t)(there + (allowed ? count : 0)));
    pthread_mutex_unlock(&found->lock);
    cw_changed();
    if (before != NULL)
        *before = there;
    cw_object_release(&found->object);
    return allowed ? TRUE : cw_fail(ERROR_INVALID_PARAMETER);
}

HANDLE CreateMutexA(LPSECURITY_ATTRIBUTES rights, BOOL owned, LPCSTR name)
{
    struct counted *mutex = made(&mutex_kind, owned ? 0 : 1, 1);

    (void)rights, (void)name;
    if (mutex != NULL && owned) {
        mutex->owner = GetCurrentThreadId();
        mutex->times = 1;
    }
    return cw_handle_or_fail((struct cw_object *)mutex);
}

HANDLE CreateMutexW(LPSECURITY_ATTRIBUTES rights, BOOL owned, LPCWSTR name)
{
    (void)name;
    return CreateMutexA(rights, owned, NULL);
}

BOOL ReleaseMutex(HANDLE mutex)
{
    struct counted *found = (struct counted *)cw_handle_get(mutex, &mutex_kind);
    int owned;

    if (found == NULL)
        return cw_fail(ERROR_INVALID_HANDLE);
    pthread_mutex_lock(&found->lock);
    owned = found->times > 0 && found->owner == GetCurrentThreadId();
    if (owned && --found->times == 0)
        eventfd_write(found->count, 1);
    cw_changed();
    pthread_mutex_unlock(&found->lock);
    cw_object_release(&found->object);
    return owned ? TRUE : cw_fail(ERROR_NOT_OWNER);
}
