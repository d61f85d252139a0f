/* Threads with handles, and critical sections. */
#include "process.h"
#include "windows_core.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

struct thread {
    struct cw_object object;
    int ended; /* an eventfd that nobody empties */
    DWORD code;
    LPTHREAD_START_ROUTINE start;
    void *argument;
    uint32_t expected; /* where it keeps the hub's time with others */
};

static __thread struct thread *here;

static void destroy(struct cw_object *object)
{
    close(((struct thread *)object)->ended);
    free(object);
}

static int descriptor(struct cw_object *object)
{
    return ((struct thread *)object)->ended;
}

static int take(struct cw_object *object)
{
    return __atomic_load_n(&((struct thread *)object)->code, __ATOMIC_ACQUIRE) != STILL_ACTIVE;
}

static const struct cw_kind kind = {"thread", destroy, take, descriptor};

static void end(void *thread)
{
    DWORD still = STILL_ACTIVE; /* pthread_exit, or a cancellation: without a code */

    __atomic_compare_exchange_n(&((struct thread *)thread)->code, &still, 0, 0, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE);
    eventfd_write(((struct thread *)thread)->ended, 1);
    cw_object_release(thread);
}

static void *run(void *started)
{
    struct thread *thread = started;
    DWORD code;

    here = thread;
    pthread_cleanup_push(end, thread);
    cw_thread_begins(thread->expected, 1);
    code = thread->start(thread->argument);
    __atomic_store_n(&thread->code, code, __ATOMIC_RELEASE);
    pthread_cleanup_pop(1);
    return NULL;
}

/* Two references: the thread's own and the handle's. */
static struct thread *started(LPTHREAD_START_ROUTINE start, void *argument, SIZE_T stack)
{
    struct thread *made = calloc(1, sizeof *made);
    pthread_attr_t how;
    pthread_t number;

    if (made == NULL)
        return NULL;
    *made = (struct thread){{&kind, 2}, eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), STILL_ACTIVE, start, argument, 0};
    pthread_attr_init(&how);
    pthread_attr_setdetachstate(&how, PTHREAD_CREATE_DETACHED);
    if (stack >= 65536) /* a smaller one would do for Windows' printf, and not for glibc's */
        pthread_attr_setstacksize(&how, stack);
    made->expected = cw_timed() ? cw_expect_thread() : 0;
    if (made->ended < 0 || pthread_create(&number, &how, run, made) != 0) {
        cw_thread_begins(made->expected, 0);
        if (made->ended >= 0)
            close(made->ended);
        free(made);
        made = NULL;
    }
    pthread_attr_destroy(&how);
    return made;
}

HANDLE CreateThread(LPSECURITY_ATTRIBUTES rights, SIZE_T stack, LPTHREAD_START_ROUTINE start, LPVOID argument,
                    DWORD flags, LPDWORD number)
{
    struct thread *thread;

    (void)rights;
    if (start == NULL || flags & 4) { /* CREATE_SUSPENDED: Linux has no such thing */
        cw_fail(start == NULL ? ERROR_INVALID_PARAMETER : ERROR_NOT_SUPPORTED);
        return NULL;
    }
    thread = started(start, argument, stack);
    if (number != NULL)
        *number = (DWORD)(uintptr_t)thread;
    return cw_handle_or_fail((struct cw_object *)thread);
}

uintptr_t _beginthreadex(void *rights, unsigned stack, unsigned (*start)(void *), void *argument, unsigned flags,
                         unsigned *number)
{
    return (uintptr_t)CreateThread(rights, stack, (LPTHREAD_START_ROUTINE)start, argument, flags, number);
}

struct plain {
    void (*start)(void *);
    void *argument;
};

static DWORD run_plain(void *both)
{
    struct plain plain = *(struct plain *)both;

    free(both);
    plain.start(plain.argument);
    return 0;
}

uintptr_t _beginthread(void (*start)(void *), unsigned stack, void *argument)
{
    struct plain *both = malloc(sizeof *both);
    HANDLE thread = NULL;

    if (both != NULL) {
        *both = (struct plain){start, argument};
        thread = CreateThread(NULL, stack, run_plain, both, 0, NULL);
    }
    if (thread == NULL) {
        free(both);
        return (uintptr_t)-1;
    }
    return (uintptr_t)thread; /* who waits for it needs it open; it is closed with the process */
}

void ExitThread(DWORD code)
{
    if (here != NULL)
        __atomic_store_n(&here->code, code, __ATOMIC_RELEASE);
    pthread_exit(NULL);
}

void _endthread(void)
{
    ExitThread(0);
}

void _endthreadex(unsigned code)
{
    ExitThread(code);
}

BOOL GetExitCodeThread(HANDLE thread, LPDWORD code)
{
    struct thread *found = (struct thread *)cw_handle_get(thread, &kind);

    if (found == NULL || code == NULL) {
        if (found != NULL)
            cw_object_release(&found->object);
        return cw_fail(found == NULL ? ERROR_INVALID_HANDLE : ERROR_INVALID_PARAMETER);
    }
    *code = __atomic_load_n(&found->code, __ATOMIC_ACQUIRE);
    cw_object_release(&found->object);
    return TRUE;
}

BOOL SetThreadPriority(HANDLE thread, int priority) /* Linux' scheduler knows better, and rights are needed */
{
    (void)thread, (void)priority;
    return TRUE;
}

BOOL SetPriorityClass(HANDLE process, DWORD priority)
{
    (void)process, (void)priority;
    return TRUE;
}

DWORD GetCurrentThreadId(void)
{
    return (DWORD)syscall(SYS_gettid);
}

DWORD GetCurrentProcessId(void)
{
    return (DWORD)getpid();
}

HANDLE GetCurrentThread(void)
{
    return (HANDLE)(LONG_PTR)-2;
}

HANDLE GetCurrentProcess(void)
{
    return (HANDLE)(LONG_PTR)-1;
}

_Static_assert(sizeof(pthread_mutex_t) <= sizeof(CRITICAL_SECTION), "a critical section is a mutex");

void InitializeCriticalSection(LPCRITICAL_SECTION section)
{
    pthread_mutexattr_t how;

    pthread_mutexattr_init(&how);
    pthread_mutexattr_settype(&how, PTHREAD_MUTEX_RECURSIVE);
    pthread_mutex_init((pthread_mutex_t *)section, &how);
    pthread_mutexattr_destroy(&how);
}

void EnterCriticalSection(LPCRITICAL_SECTION section)
{
    pthread_mutex_t *mutex = (pthread_mutex_t *)section;

    while (pthread_mutex_trylock(mutex) != 0)
        if (!cw_timed() || !cw_others_run()) { /* else who has it may be waiting for a turn */
            pthread_mutex_lock(mutex);
            return;
        }
}

BOOL TryEnterCriticalSection(LPCRITICAL_SECTION section)
{
    return pthread_mutex_trylock((pthread_mutex_t *)section) == 0;
}

void LeaveCriticalSection(LPCRITICAL_SECTION section)
{
    pthread_mutex_unlock((pthread_mutex_t *)section);
    cw_changed();
}

void DeleteCriticalSection(LPCRITICAL_SECTION section)
{
    pthread_mutex_destroy((pthread_mutex_t *)section);
}
