/* The thread that takes in what the driver changes in task blocks, and calls applications back: ACAN32.DLL's. */
#include "acan_core.h"

#include <pthread.h>
#include <signal.h>

static uint32_t running; /* the process number for which the thread was started */
static BOOL started;

/* ACAN32.DLL waits for the block's event, and calls back; without a callback the application waits for it itself. */
static void tell(struct acan_block *block)
{
    LPACANTB tb = block->at;
    ACANCBFN call = tb->cbNotification;

    if (call == NULL) {
        SetEvent(block->event);
        return;
    }
    acan_begin_telling(block);
    call(tb);
    acan_end_telling();
}

static void take_in(const char *data, size_t length)
{
    for (size_t at = 0; at + sizeof(struct acan_shown) <= length;) {
        struct acan_shown shown;
        struct acan_block *block;

        memcpy(&shown, data + at, sizeof shown);
        at += sizeof shown;
        acan_lock();
        block = acan_number(shown.number);
        if (block != NULL) {
            acan_show(block, &shown);
            if (shown.notified)
                tell(block);
        }
        acan_unlock();
    }
}

/* As long as there is a helper; after ACAN_Exit it waits for what is registered next. */
static void *serve(void *argument)
{
    char data[CW_MOST_DATA];
    uint32_t process = (uint32_t)(uintptr_t)argument;
    struct cw_call call = {.method = "acan.wait", .out = data, .out_size = CW_MOST_DATA};

    while (process == cw_process() && cw_call(&call) == 0)
        if (call.result == 0)
            take_in(data, call.out_length);
    return NULL;
}

BOOL acan_start_service(void)
{
    uint32_t process = cw_process();
    pthread_attr_t how;
    pthread_t thread;
    sigset_t all, before;
    int made;

    if (started && running == process)
        return TRUE;
    pthread_attr_init(&how);
    pthread_attr_setdetachstate(&how, PTHREAD_CREATE_DETACHED);
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before); /* signals are the application's */
    made = pthread_create(&thread, &how, serve, (void *)(uintptr_t)process);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&how);
    if (made == 0) {
        running = process;
        started = TRUE;
    }
    return made == 0;
}
