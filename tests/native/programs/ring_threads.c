/* A ring between two threads under ThreadSanitizer: records in batches of any size, each end sleeps on its event when
 * there is nothing to do. Every record is looked at; a signal that is lost leaves both asleep, which the alarm ends.
 *
 *     ring_threads RECORDS      is built by .ci/thread_sanitizer */
#include "core.h"

#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#define SLOTS 64
#define SIZE 80
#define PATIENCE_S 300

static uint64_t memory[(256 + SLOTS * SIZE) / 8] __attribute__((aligned(64)));
static uint64_t wanted, sleeps[2];

static struct cw_ring end_of(int reads, int own, int peer)
{
    struct cw_ring ring;

    memset(&ring, 0, sizeof ring);
    ring.words = memory;
    ring.records = (unsigned char *)memory + 256;
    ring.capacity = SLOTS;
    ring.record_size = SIZE;
    ring.mask = SLOTS - 1;
    ring.reads = reads;
    ring.threshold = 1;
    ring.own = own;
    ring.peer = peer;
    return ring;
}

/* There is nothing to do: ask for a signal, and wait for it. */
static void sleep_on(struct cw_ring *ring)
{
    struct pollfd event = {ring->own, POLLIN, 0};
    uint64_t taken;

    sleeps[ring->reads ? 0 : 1]++;
    cw_ring_arm(ring);
    poll(&event, 1, -1);
    if (read(ring->own, &taken, sizeof taken) < 0)
        abort();
}

static unsigned some(unsigned *state, unsigned most)
{
    *state = *state * 1103515245u + 12345u;
    return 1 + (*state >> 16) % most;
}

static void *produce(void *argument)
{
    struct cw_ring *ring = argument;
    unsigned chance = 1;

    for (uint64_t number = 0; number < wanted;) {
        uint32_t count;
        uint64_t *room = cw_ring_acquire_free(ring, &count);

        if (room == NULL) {
            sleep_on(ring);
            continue;
        }
        if (count > some(&chance, 20))
            count = some(&chance, count);
        for (uint32_t k = 0; k < count; k++)
            for (int word = 0; word < SIZE / 8; word++)
                room[k * SIZE / 8 + word] = number + k + word;
        cw_ring_commit(ring, count);
        number += count;
    }
    return NULL;
}

static void *consume(void *argument)
{
    struct cw_ring *ring = argument;
    unsigned chance = 2;

    for (uint64_t number = 0; number < wanted;) {
        uint32_t count;
        const uint64_t *records = cw_ring_acquire(ring, &count);

        if (records == NULL) {
            sleep_on(ring);
            continue;
        }
        if (count > some(&chance, 40))
            count = some(&chance, count);
        for (uint32_t k = 0; k < count; k++)
            for (int word = 0; word < SIZE / 8; word++)
                if (records[k * SIZE / 8 + word] != number + k + word) {
                    fprintf(stderr, "record %llu is another\n", (unsigned long long)(number + k));
                    exit(1);
                }
        cw_ring_release(ring, count);
        number += count;
    }
    return NULL;
}

int main(int count, char **words)
{
    int filled = eventfd(0, 0), emptied = eventfd(0, 0);
    struct cw_ring reader = end_of(1, filled, emptied), writer = end_of(0, emptied, filled);
    pthread_t threads[2];

    wanted = count > 1 ? strtoull(words[1], NULL, 10) : 100000;
    alarm(PATIENCE_S);
    pthread_create(&threads[0], NULL, produce, &writer);
    pthread_create(&threads[1], NULL, consume, &reader);
    for (int k = 0; k < 2; k++)
        pthread_join(threads[k], NULL);
    printf("%llu records, slept %llu and %llu times\n", (unsigned long long)wanted, (unsigned long long)sleeps[0],
           (unsigned long long)sleeps[1]);
    return 0;
}
