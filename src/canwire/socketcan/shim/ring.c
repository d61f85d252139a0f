/* Both ends of a CAN_RAW socket's rings; the server calls its own by ctypes (../rings.py). */
#include "ring.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#define LOAD(place) __atomic_load_n(&(place), __ATOMIC_ACQUIRE)
#define STORE(place, value) __atomic_store_n(&(place), value, __ATOMIC_RELEASE)
#define FENCE() __atomic_thread_fence(__ATOMIC_SEQ_CST)

static struct block *blocks;

__attribute__((constructor)) static void map_blocks(void)
{
    const char *directory = getenv("CANWIRE_SOCKETCAN");
    char path[128];
    void *memory;
    int fd;

    if (directory == NULL || snprintf(path, sizeof path, "%s/rings", directory) >= (int)sizeof path)
        return;
    fd = open(path, O_RDWR | O_CLOEXEC);
    if (fd < 0)
        return;
    memory = mmap(NULL, sizeof(struct block) * MOST_SLOTS, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, fd, 0);
    if (memory != MAP_FAILED)
        blocks = memory;
    close(fd);
}

struct block *block_of(const struct slot *slot)
{
    return blocks != NULL ? &blocks[slot_number(slot)] : NULL;
}

static void notify(int fd)
{
    static const char byte;

    REAL(send)(fd, &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL);
}

/* the program's side */

int lock_ring(struct ring *ring)
{
    int error = pthread_mutex_lock(&ring->lock);

    if (error == EOWNERDEAD) /* it was killed in here: counters are moved last, so that all is well */
        error = pthread_mutex_consistent(&ring->lock);
    return error;
}

void unlock_sent(struct block *block)
{
    pthread_mutex_unlock(&block->sent.lock);
}

void unlock_received(struct block *block, int fd)
{
    struct ring *ring = &block->received;

    pthread_mutex_unlock(&ring->lock);
    FENCE();
    if (LOAD(ring->unsettled) && __atomic_exchange_n(&ring->unsettled, 0, __ATOMIC_SEQ_CST))
        notify(fd);
}

const char *oldest(struct block *block)
{
    struct ring *ring = &block->received;

    return LOAD(ring->head) == ring->tail ? NULL
                                          : block->received_rows + ring->tail % RECEIVED_ROWS * RECEIVED_SIZE;
}

void release_oldest(struct block *block, int fd)
{
    struct ring *ring = &block->received;
    uint64_t left = LOAD(ring->head) - ring->tail - 1;
    char byte;

    STORE(ring->tail, ring->tail + 1);
    if (left == 0 && ring->told) {
        REAL(recv)(fd, &byte, 1, MSG_DONTWAIT);
        ring->told = 0;
    }
    FENCE();
    if (LOAD(ring->wanted) && left <= RECEIVED_ROWS / 2 &&
        __atomic_exchange_n(&ring->wanted, 0, __ATOMIC_SEQ_CST))
        notify(fd);
}

char *next_free(struct block *block)
{
    struct ring *ring = &block->sent;

    return ring->head - LOAD(ring->tail) >= SENT_ROWS ? NULL : block->sent_rows + ring->head % SENT_ROWS * SENT_SIZE;
}

int commit(struct block *block, int fd)
{
    struct ring *ring = &block->sent;
    static const char byte;

    STORE(ring->head, ring->head + 1);
    FENCE();
    if (LOAD(ring->wanted) && __atomic_exchange_n(&ring->wanted, 0, __ATOMIC_SEQ_CST) &&
        REAL(send)(fd, &byte, 1, MSG_DONTWAIT | MSG_NOSIGNAL) < 0 && errno != EAGAIN)
        return ENETDOWN;
    return 0;
}

void wait_for_turn(struct block *block, int milliseconds)
{
    struct ring *ring = &block->sent;
    struct timespec span = {milliseconds / 1000, milliseconds % 1000 * 1000000L};
    uint32_t turn = LOAD(ring->turn);

    STORE(ring->waiting, 1);
    FENCE();
    if (LOAD(ring->head) - LOAD(ring->tail) >= SENT_ROWS)
        syscall(SYS_futex, &ring->turn, FUTEX_WAIT, turn, &span, NULL, 0);
}

/* the server's side */

EXPORT unsigned long canwire_block_size(void)
{
    return sizeof(struct block);
}

EXPORT void canwire_prepare(struct block *block)
{
    pthread_mutexattr_t kind;

    memset(&block->received, 0, sizeof block->received);
    memset(&block->sent, 0, sizeof block->sent);
    pthread_mutexattr_init(&kind);
    pthread_mutexattr_setpshared(&kind, PTHREAD_PROCESS_SHARED);
    pthread_mutexattr_setrobust(&kind, PTHREAD_MUTEX_ROBUST);
    pthread_mutexattr_settype(&kind, PTHREAD_MUTEX_ERRORCHECK);
    pthread_mutex_init(&block->received.lock, &kind);
    pthread_mutex_init(&block->sent.lock, &kind);
    pthread_mutexattr_destroy(&kind);
    block->sent.wanted = 1;
}

/* The token is there if anything waits. */
static void settle(struct ring *ring, int fd)
{
    int error;

    STORE(ring->unsettled, 1);
    FENCE();
    error = pthread_mutex_trylock(&ring->lock);
    if (error == EOWNERDEAD)
        error = pthread_mutex_consistent(&ring->lock);
    if (error != 0)
        return; /* who has it kicks */
    STORE(ring->unsettled, 0);
    if (ring->head != ring->tail && !ring->told) {
        ring->told = 1;
        notify(fd);
    }
    pthread_mutex_unlock(&ring->lock);
}

/* How many of the rows there was room for. */
EXPORT long canwire_publish(struct block *block, const char *rows, long count, int fd)
{
    struct ring *ring = &block->received;
    uint64_t head = ring->head, waiting = head - LOAD(ring->tail);
    long room = waiting > RECEIVED_ROWS ? 0 : (long)(RECEIVED_ROWS - waiting);

    if (count < room)
        room = count;
    for (long at = 0; at < room; at++)
        memcpy(block->received_rows + (head + (uint64_t)at) % RECEIVED_ROWS * RECEIVED_SIZE, rows + at * RECEIVED_SIZE,
               RECEIVED_SIZE);
    if (room > 0) {
        STORE(ring->head, head + (uint64_t)room);
        settle(ring, fd);
    }
    return room;
}

/* Somebody has kicked: perhaps for a token. */
EXPORT void canwire_kicked(struct block *block, int fd)
{
    settle(&block->received, fd);
}

/* Have a kick once at least half of the ring is free; 0: it is now, and there will be none. */
EXPORT int canwire_want_room(struct block *block)
{
    struct ring *ring = &block->received;

    STORE(ring->wanted, 1);
    FENCE();
    if (ring->head - LOAD(ring->tail) > RECEIVED_ROWS / 2)
        return 1;
    STORE(ring->wanted, 0);
    return 0;
}

static void offer_room(struct ring *ring)
{
    FENCE();
    if (LOAD(ring->waiting) && LOAD(ring->head) - ring->tail <= SENT_ROWS / 2) {
        STORE(ring->waiting, 0);
        __atomic_fetch_add(&ring->turn, 1, __ATOMIC_SEQ_CST);
        syscall(SYS_futex, &ring->turn, FUTEX_WAKE, 0x7fffffff, NULL, NULL, 0);
    }
}

EXPORT long canwire_collect(struct block *block, char *rows, long limit)
{
    struct ring *ring = &block->sent;
    uint64_t tail = ring->tail, waiting = LOAD(ring->head) - tail;
    long count = waiting > SENT_ROWS ? 0 : (long)waiting;

    if (limit < count)
        count = limit;
    for (long at = 0; at < count; at++)
        memcpy(rows + at * SENT_SIZE, block->sent_rows + (tail + (uint64_t)at) % SENT_ROWS * SENT_SIZE, SENT_SIZE);
    STORE(ring->tail, tail + (uint64_t)count);
    offer_room(ring);
    return count;
}

/* Have a kick with the next frame; 0: there is one already. */
EXPORT int canwire_want_frames(struct block *block)
{
    struct ring *ring = &block->sent;

    STORE(ring->wanted, 1);
    FENCE();
    if (LOAD(ring->head) == ring->tail)
        return 1;
    STORE(ring->wanted, 0);
    return 0;
}
