/* Task blocks: registering, acknowledging, deregistering. */
#include "acan_core.h"

#include <sys/prctl.h>
#include <unistd.h>

#define MOST_FILTERS 255
#define MOST_MESSAGES 4096 /* of one answer */

struct filter {
    uint64_t address;
    uint32_t and_mask, xor_value;
    uint8_t action, length, reserved[6];
};

struct description {
    uint32_t process, reserved;
    uint16_t size, room;
    uint8_t conditions, count, pad[2];
    struct filter filters[MOST_FILTERS];
} __attribute__((packed));

/* A channel's bytes are read by the helper, in the moment when somebody asks for them: security modules want to hear
 * from the program that it agrees. Without such a module this is refused, and not needed. */
static void allow_reading(void)
{
    prctl(PR_SET_PTRACER, (unsigned long)__atomic_load_n(&acan_helper, __ATOMIC_ACQUIRE), 0, 0, 0);
}

static size_t describe(struct description *into, LPACANTB tb)
{
    PACANID table = (PACANID)(tb + 1);

    *into = (struct description){.process = (uint32_t)getpid(), .size = tb->wRMBSize, .room = tb->lpRMB != NULL,
                                 .conditions = tb->bSCFilter, .count = tb->bNId};
    for (int k = 0; k < tb->bNId; k++) {
        into->filters[k] = (struct filter){(uintptr_t)table[k].lpAddress, table[k].dwAnd, table[k].dwXor,
                                           table[k].bAction, table[k].bLength, {0}};
        if (table[k].bAction & IDA_CHANSND)
            allow_reading();
    }
    return offsetof(struct description, filters) + tb->bNId * sizeof(struct filter);
}

/* Under the lock, so that the service's thread finds what it is told of. */
static BOOL registered(struct acan_block *block)
{
    struct description description;
    struct acan_shown shown;
    uint32_t process = cw_process();
    struct cw_call call = {.method = "acan.register", .in = &description, .out = &shown, .out_size = sizeof shown};

    call.in_size = describe(&description, block->at);
    if (acan_find(block->at) != NULL || !acan_start_service() || !acan_call(&call) || call.out_length != sizeof shown)
        return FALSE;
    block->number = call.value;
    block->process = process;
    block->at->bNotType = TBNT_EVENT;
    block->at->hEvent = block->event;
    acan_show(block, &shown);
    acan_keep(block);
    return TRUE;
}

BOOL ACAN_Register(LPACANTB tb)
{
    struct acan_block *block = tb != NULL ? calloc(1, sizeof *block) : NULL;
    BOOL done = FALSE;

    if (block == NULL)
        return FALSE;
    block->at = tb;
    block->event = CreateEventA(NULL, FALSE, FALSE, NULL);
    acan_lock();
    if (block->event != NULL)
        done = registered(block);
    acan_unlock();
    if (!done) {
        if (block->event != NULL)
            CloseHandle(block->event);
        free(block);
    }
    return done;
}

static uint32_t number_of(LPACANTB tb)
{
    struct acan_block *found;
    uint32_t number;

    acan_lock();
    found = acan_find(tb);
    number = found != NULL ? found->number : 0;
    acan_unlock();
    return number;
}

static void show(LPACANTB tb, const struct acan_shown *shown)
{
    struct acan_block *found;

    acan_lock();
    found = acan_find(tb);
    if (found != NULL && found->number == shown->number)
        acan_show(found, shown);
    acan_unlock();
}

WORD ACAN_AckEventCheck(LPACANTB tb)
{
    struct acan_shown shown;
    struct cw_call call = {.method = "acan.ack_event", .object = number_of(tb), .out = &shown, .out_size = sizeof shown};

    if (call.object == 0 || !acan_call(&call) || call.out_length != sizeof shown)
        return 0;
    show(tb, &shown);
    return (WORD)call.value;
}

WORD ACAN_AckEvent(LPACANTB tb)
{
    return ACAN_AckEventCheck(tb);
}

BOOL ACAN_Deregister(LPACANTB tb)
{
    struct cw_call call = {.method = "acan.deregister", .object = number_of(tb)};
    struct acan_block *found;

    if (call.object == 0)
        return FALSE;
    if (!acan_call(&call))
        call.result = 1;
    acan_lock();
    found = acan_number(call.object);
    if (found != NULL)
        acan_drop(found);
    acan_unlock();
    return call.result == 0;
}

static int retrieved(LPACANTB tb, uint32_t number, char *into, DWORD count)
{
    DWORD asked[2] = {count, into != NULL};
    char data[CW_MOST_DATA];
    struct acan_shown shown;
    struct cw_call call = {.method = "acan.retrieve_messages", .object = number, .in = asked, .in_size = sizeof asked,
                           .out = data, .out_size = sizeof data};

    if (!acan_call(&call) || call.out_length != sizeof shown + call.value * ACANMBSZ || call.value > count)
        return -1;
    memcpy(&shown, data, sizeof shown);
    show(tb, &shown);
    memcpy(into, data + sizeof shown, call.value * ACANMBSZ);
    return (int)call.value;
}

int ACAN_RetrieveMessages(LPACANTB tb)
{
    uint32_t number = number_of(tb);
    int sum = 0, got;

    if (number == 0)
        return -1;
    do {
        got = retrieved(tb, number, tb->lpBuf != NULL ? (char *)tb->lpBuf + sum * ACANMBSZ : NULL, tb->wCount - sum);
        sum += got > 0 ? got : 0;
    } while (got == MOST_MESSAGES && sum < tb->wCount);
    return got < 0 && sum == 0 ? -1 : sum;
}

BOOL ACAN_SendMessage(LPACANMB message, BYTE priority)
{
    struct {
        uint32_t priority;
        ACANMB message;
    } asked = {priority, {0}};
    struct cw_call call = {.method = "acan.send_message", .in = &asked, .in_size = sizeof asked.priority};

    if (message != NULL) {
        asked.message = *message;
        call.in_size += ACANMBSZ;
    }
    return acan_call(&call);
}
