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

/* the program's side */

int lock_ring(struct ring *ring)
{
    int error = pthread_mutex_lock(&ring->lock);

    if (error == EOWNERDEAD) /* it was killed in here: counters are moved last, so that all is well */
        error = pthread_mutex_consistent(&ring->lock);
    return error;
}

void unlock_ring(struct ring *ring)
{
    pthread_mutex_unlock(&ring->lock);
}

static int is_of(const char *row, const char *data, size_t length)
{
    const struct received *header = (const struct received *)row;

    if (header->length != length)
        return 0; /* errors have none; neither have some messages of CAN_J1939 */
    return memcmp(row + sizeof *header, data, length < RECEIVED_PREFIX ? length : RECEIVED_PREFIX) == 0;
}

int take_row(struct block *block, const char *data, size_t length, int peeks, struct received *header,
             struct about *about)
{
    struct ring *ring = &block->received;
    uint64_t head = LOAD(ring->head);

    if (head - ring->tail > RECEIVED_ROWS / 2) /* or it was ahead: older ones may be overwritten under our eyes */
        ring->tail = head - RECEIVED_ROWS / 2;
    for (uint64_t at = ring->tail; at != head; at++) {
        const char *row = block->received_rows + at % RECEIVED_ROWS * RECEIVED_SIZE;
        if (is_of(row, data, length)) {
            memcpy(header, row, sizeof *header);
            *about = block->abouts[at % RECEIVED_ROWS];
            if (!peeks)
                ring->tail = at + 1;
            return 1;
        }
    }
    return 0;
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

/* For a program whose calls the server answers: the row of its oldest message. */
EXPORT int canwire_take_row(struct block *block, const char *data, size_t length, int peeks, struct received *header,
                            struct about *about)
{
    int found;

    if (lock_ring(&block->received) != 0)
        return 0;
    found = take_row(block, data, length, peeks, header, about);
    unlock_ring(&block->received);
    return found;
}

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

/* One row, and its message of so many bytes; 0: there was no room for the message. */
static int publish(struct block *block, const char *row, const char *data, size_t length, int fd)
{
    struct ring *ring = &block->received;

    memcpy(block->received_rows + ring->head % RECEIVED_ROWS * RECEIVED_SIZE, row, RECEIVED_SIZE);
    STORE(ring->head, ring->head + 1); /* before the message, so that who has that finds it */
    if (send(fd, data, length, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0 || (errno != EAGAIN && errno != ENOBUFS))
        return 1;
    STORE(ring->head, ring->head - 1);
    return 0;
}

/* How many of the rows there was room for. */
EXPORT long canwire_publish(struct block *block, const char *rows, long count, int fd)
{
    long done = 0;

    for (; done < count; done++, rows += RECEIVED_SIZE) {
        const struct received *header = (const struct received *)rows;
        if (!publish(block, rows, rows + sizeof *header, header->length, fd))
            break;
    }
    return done;
}

/* A message that may be longer than a row: its header, and its bytes. */
EXPORT int canwire_publish_message(struct block *block, const struct received *header, const char *data,
                                   const struct about *about, int fd)
{
    char row[RECEIVED_SIZE] = {0};

    memcpy(row, header, sizeof *header);
    memcpy(row + sizeof *header, data, header->length < RECEIVED_PREFIX ? header->length : RECEIVED_PREFIX);
    block->abouts[block->received.head % RECEIVED_ROWS] = *about;
    return publish(block, row, data, header->length, fd);
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
