/* The blocks that this process has registered. */
#include "acan_core.h"

#include <pthread.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t told = PTHREAD_COND_INITIALIZER;
static struct acan_block *blocks;
static int ended; /* the program: nothing writes to its memory any more */
static struct acan_block *telling; /* the one whose application is just told */
static pthread_t teller;

void acan_unlock(void)
{
    pthread_mutex_unlock(&lock);
}

/* A fork's blocks are its parent's, and over; it has no thread. */
static void in_child(void)
{
    pthread_mutex_init(&lock, NULL);
    pthread_cond_init(&told, NULL);
    telling = NULL;
    acan_helper = 0;
}

static void lock_for_fork(void)
{
    pthread_mutex_lock(&lock);
}

static void prepare_forks(void)
{
    pthread_atfork(lock_for_fork, acan_unlock, in_child);
}

void acan_lock(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    pthread_once(&once, prepare_forks);
    pthread_mutex_lock(&lock);
}

struct acan_block *acan_number(uint32_t number)
{
    struct acan_block *block = blocks;

    while (block != NULL && (block->number != number || block->process != cw_process()))
        block = block->next;
    return ended ? NULL : block;
}

void acan_keep(struct acan_block *block)
{
    block->next = blocks;
    blocks = block;
}

void acan_begin_telling(struct acan_block *block)
{
    telling = block;
    teller = pthread_self();
    pthread_mutex_unlock(&lock);
}

void acan_end_telling(void)
{
    pthread_mutex_lock(&lock);
    telling = NULL;
    pthread_cond_broadcast(&told);
}

void acan_drop(struct acan_block *block)
{
    struct acan_block **at = &blocks;

    while (*at != NULL && *at != block)
        at = &(*at)->next;
    if (*at == NULL)
        return;
    *at = block->next;
    while (telling == block && !pthread_equal(teller, pthread_self()))
        pthread_cond_wait(&told, &lock);
    CloseHandle(block->event);
    free(block);
}

void acan_drop_all(void)
{
    acan_lock();
    while (blocks != NULL)
        acan_drop(blocks);
    acan_unlock();
}

struct acan_block *acan_find(LPACANTB at)
{
    struct acan_block *block = blocks;

    while (block != NULL && block->at != at)
        block = block->next;
    if (block != NULL && block->process != cw_process()) {
        acan_drop(block);
        return NULL;
    }
    return block;
}

/* Asked for and written under the lock, so that it is written in its order. */
static void take_moved(struct acan_block *block)
{
    PACANID table = (PACANID)(block->at + 1);
    struct acan_moved moved[255];
    struct cw_call call = {.method = "acan.moved", .object = block->number, .out = moved, .out_size = sizeof moved};
    size_t count = acan_call(&call) ? call.out_length / sizeof *moved : 0;

    for (size_t k = 0; k < count; k++)
        if (moved[k].channel < block->at->bNId && table[moved[k].channel].lpAddress != NULL)
            memcpy(table[moved[k].channel].lpAddress, moved[k].data, moved[k].length);
}

void acan_show(struct acan_block *block, const struct acan_shown *shown)
{
    LPACANTB tb = block->at;

    if (shown->moved)
        take_moved(block);
    if ((int32_t)(shown->version - block->version) < 0)
        return; /* another thread was quicker with what came later */
    block->version = shown->version;
    tb->wStatus = shown->status;
    tb->wRMBOccupation = shown->occupation;
    tb->wRIndex = shown->read_index;
    tb->wWIndex = shown->write_index;
    tb->bREC = shown->rec;
    tb->bTEC = shown->tec;
    tb->bALC = shown->alc;
    tb->bECC = shown->ecc;
}

__attribute__((destructor)) static void end(void)
{
    pthread_mutex_lock(&lock);
    ended = 1;
    pthread_mutex_unlock(&lock);
}
