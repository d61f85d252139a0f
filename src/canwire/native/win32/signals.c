/* What the helper says of its own accord: a queue's other side has signalled, or a queue is over.
 *
 * A thread hears it and sets the events that the program has assigned, which are Windows' own.
 */
#include "win32.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

struct cw_event {
    HANDLE handle; /* our own for the program's event: that may be closed meanwhile */
    LONG references;
};

struct watch { /* a signal that an event hears of, and no queue */
    int number;
    struct cw_event *event;
    struct watch *next;
};

struct listener {
    SOCKET socket;
    uint32_t process;
};

struct message {
    uint32_t what;
    uint32_t number;
};

static pthread_mutex_t lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER; /* of the lists, and of which events rings have */
static struct cw_ring *rings;
static struct watch *watches;
static pthread_mutex_t sending = PTHREAD_MUTEX_INITIALIZER;
static SOCKET lifeline = INVALID_SOCKET;
static uint32_t heard; /* there, counted as the helper counts what it says */
static pthread_cond_t more_heard = PTHREAD_COND_INITIALIZER; /* with `sending`: also that nothing more will be */

void far_say(enum aside what, int number)
{
    struct message message = {what, (uint32_t)number};

    pthread_mutex_lock(&sending);
    if (lifeline != INVALID_SOCKET && far_send(lifeline, &message, sizeof message) < 0)
        shutdown(lifeline, SD_BOTH); /* the thread that listens tells everybody */
    pthread_mutex_unlock(&sending);
}

void cw_event_set(struct cw_event *event)
{
    SetEvent(event->handle);
}

static void set(struct cw_ring *ring)
{
    if (ring->event != NULL)
        cw_event_set(ring->event);
}

static void hear(const struct message *message)
{
    int descriptor = SIGNAL | (int)message->number;

    pthread_mutex_lock(&lock);
    for (struct cw_ring *ring = rings; ring != NULL; ring = ring->next)
        if (ring->own == descriptor) {
            if (message->what == OVER)
                __atomic_store_n(&ring->state, 1, __ATOMIC_RELEASE);
            far_signal_own(ring);
        }
    for (struct watch *watch = watches; watch != NULL; watch = watch->next)
        if (watch->number == descriptor)
            cw_event_set(watch->event);
    pthread_mutex_unlock(&lock);
}

void far_signal_own(struct cw_ring *ring)
{
    pthread_mutex_lock(&lock);
    set(ring);
    if (ring->event != NULL)
        cw_ring_rearm(ring);
    pthread_mutex_unlock(&lock);
}

static void tell_all(void)
{
    pthread_mutex_lock(&lock);
    for (struct cw_ring *ring = rings; ring != NULL; ring = ring->next)
        set(ring);
    pthread_mutex_unlock(&lock);
}

static void count(SOCKET on)
{
    pthread_mutex_lock(&sending);
    if (lifeline == on)
        heard++;
    pthread_cond_broadcast(&more_heard);
    pthread_mutex_unlock(&sending);
}

void far_wait_heard(uint32_t said, uint32_t of)
{
    pthread_mutex_lock(&sending);
    while (of == cw_process() && lifeline != INVALID_SOCKET && (int32_t)(said - heard) > 0)
        pthread_cond_wait(&more_heard, &sending);
    pthread_mutex_unlock(&sending);
}

static DWORD WINAPI listen_on(void *given)
{
    struct listener *listener = given;
    SOCKET mine = listener->socket;
    struct message message;

    while (far_receive(mine, &message, sizeof message) == 0) {
        hear(&message);
        count(mine);
    }
    cw_helper_gone(listener->process);
    free(listener);
    pthread_mutex_lock(&sending);
    if (lifeline == mine)
        lifeline = INVALID_SOCKET;
    pthread_cond_broadcast(&more_heard);
    pthread_mutex_unlock(&sending);
    closesocket(mine);
    tell_all();
    return 0;
}

int far_listen(SOCKET on)
{
    struct listener *listener = calloc(1, sizeof *listener);
    HMODULE stays; /* this library: a thread of it runs from now on */
    HANDLE thread;

    GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_PIN, (LPCWSTR)(void *)&far_listen,
                       &stays);
    pthread_mutex_lock(&sending);
    lifeline = on;
    heard = 0;
    pthread_mutex_unlock(&sending);
    if (listener != NULL)
        *listener = (struct listener){on, cw_process()};
    thread = listener != NULL ? CreateThread(NULL, 0, listen_on, listener, 0, NULL) : NULL;
    if (thread == NULL) {
        free(listener);
        errno = EAGAIN;
        return -1;
    }
    CloseHandle(thread);
    return 0;
}

/* rings that can be signalled */

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
    far_say(HEAR, ring->own & ~SIGNAL);
}

void cw_forget_ring(struct cw_ring *ring)
{
    pthread_mutex_lock(&lock);
    *ring->before = ring->next;
    if (ring->next != NULL)
        ring->next->before = ring->before;
    pthread_mutex_unlock(&lock);
}

/* events */

static int is_event(HANDLE handle)
{
    typedef LONG(WINAPI * query)(HANDLE event, int what, void *into, ULONG size, ULONG *needed);
    query ask = (query)(void *)GetProcAddress(GetModuleHandleW(L"ntdll.dll"), "NtQueryEvent");
    LONG about[2]; /* EVENT_BASIC_INFORMATION */

    return ask == NULL || ask(handle, 0, about, sizeof about, NULL) >= 0;
}

struct cw_event *cw_event_of(cw_handle handle)
{
    struct cw_event *made;
    HANDLE own;

    if (!DuplicateHandle(GetCurrentProcess(), handle, GetCurrentProcess(), &own, 0, FALSE, DUPLICATE_SAME_ACCESS))
        return NULL;
    made = is_event(own) ? calloc(1, sizeof *made) : NULL;
    if (made == NULL) {
        CloseHandle(own);
        return NULL;
    }
    made->handle = own;
    made->references = 1;
    return made;
}

void cw_event_release(struct cw_event *event)
{
    if (InterlockedDecrement(&event->references) > 0)
        return;
    CloseHandle(event->handle);
    free(event);
}

int cw_event_assign(struct cw_event *event, struct cw_ring *ring)
{
    struct cw_event *before;

    if (event != NULL)
        InterlockedIncrement(&event->references);
    pthread_mutex_lock(&lock);
    before = ring->event;
    ring->event = event;
    if (event != NULL)
        cw_ring_rearm(ring);
    pthread_mutex_unlock(&lock);
    if (before != NULL)
        cw_event_release(before);
    return 0;
}

int cw_event_watch(struct cw_event *event, int descriptor)
{
    struct watch *made = calloc(1, sizeof *made);

    if (made == NULL) {
        cw_close_descriptor(descriptor);
        return -1;
    }
    InterlockedIncrement(&event->references);
    pthread_mutex_lock(&lock);
    *made = (struct watch){descriptor, event, watches};
    watches = made;
    pthread_mutex_unlock(&lock);
    far_say(HEAR, descriptor & ~SIGNAL);
    return 0;
}

void cw_event_forget(struct cw_event *event, int descriptor)
{
    struct watch *gone = NULL;

    pthread_mutex_lock(&lock);
    for (struct watch **at = &watches; *at != NULL && gone == NULL; at = &(*at)->next)
        if ((*at)->number == descriptor) {
            gone = *at;
            *at = gone->next;
            break;
        }
    pthread_mutex_unlock(&lock);
    cw_close_descriptor(descriptor);
    free(gone);
    cw_event_release(event);
}
