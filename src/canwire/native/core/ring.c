/* One end of a ring in memory that the hub has, too: ../../ring.py in C, word by word. */
#include "core.h"

#include <errno.h>
#include <string.h>

#define MAGIC 0x000147574e414301ull
#define HEADER_SIZE 256
#define LARGEST_CAPACITY (1u << 24)

enum word { CAPACITY = 1, RECORD_BYTES = 2, LIMIT = 3, HEAD = 8, TAIL = 16, WANTED = 17, FREE_WANTED = 24 };

static uint64_t look(const struct cw_ring *ring, enum word word)
{
    return __atomic_load_n(&ring->words[word], __ATOMIC_ACQUIRE);
}

static void put(struct cw_ring *ring, enum word word, uint64_t value)
{
    __atomic_store_n(&ring->words[word], value, __ATOMIC_RELEASE);
}

static uint64_t rounded(uint64_t capacity)
{
    uint64_t slots = 1;

    while (slots < capacity)
        slots *= 2;
    return slots;
}

/* the memory is what the helper says it is: a ring of this form, as large as it says */
static int fits(const struct cw_ring *ring, const struct cw_place *place)
{
    uint64_t need = place->begin + HEADER_SIZE + rounded(place->capacity) * place->record_size;

    return place->capacity >= 1 && place->capacity <= LARGEST_CAPACITY && place->record_size >= 1 &&
           place->begin % 8 == 0 && need <= ring->mapping_size && ring->words[0] == MAGIC &&
           ring->words[RECORD_BYTES] == place->record_size && ring->words[LIMIT] == place->capacity;
}

static int refused(struct cw_ring *ring, struct cw_call *with, int why)
{
    if (ring->mapping != NULL)
        cw_ring_unmap(ring);
    cw_close_descriptors(with);
    errno = why;
    return -1;
}

int cw_ring_open(struct cw_ring *ring, const struct cw_place *place, struct cw_call *with)
{
    memset(ring, 0, sizeof *ring);
    ring->own = ring->peer = -1;
    if (with->descriptor_count < 2)
        return refused(ring, with, EPROTO);
    if (cw_ring_map(ring, with->descriptors[0]) < 0)
        return refused(ring, with, errno);
    ring->words = (uint64_t *)((char *)ring->mapping + place->begin);
    if (ring->mapping_size < place->begin + HEADER_SIZE || !fits(ring, place))
        return refused(ring, with, EPROTO);
    ring->records = (unsigned char *)ring->words + HEADER_SIZE;
    ring->capacity = place->capacity;
    ring->record_size = place->record_size;
    ring->mask = rounded(place->capacity) - 1;
    ring->reads = place->reads;
    ring->state = place->state;
    ring->threshold = 1;
    ring->seen = look(ring, ring->reads ? HEAD : TAIL);
    cw_close_descriptor(with->descriptors[0]);
    ring->own = with->descriptors[1];
    ring->peer = with->descriptor_count > 2 ? with->descriptors[2] : -1;
    with->descriptor_count = 0;
    cw_keep_ring(ring);
    return 0;
}

void cw_ring_close(struct cw_ring *ring)
{
    if (ring->mapping == NULL)
        return;
    cw_event_assign(NULL, ring);
    cw_forget_ring(ring);
    cw_ring_unmap(ring);
    if (ring->own >= 0)
        cw_close_descriptor(ring->own);
    if (ring->peer >= 0)
        cw_close_descriptor(ring->peer);
    ring->own = ring->peer = -1;
}

int cw_ring_over(const struct cw_ring *ring)
{
    return ring->process != cw_process() || cw_ring_ended(ring);
}

/* A fill level above the capacity means that the other side is broken: then nothing can be read, and nothing written. */
uint32_t cw_ring_fill(struct cw_ring *ring)
{
    uint64_t head = look(ring, HEAD), count = head - look(ring, TAIL);

    if (ring->reads)
        ring->seen = head;
    return count <= ring->capacity ? (uint32_t)count : 0;
}

uint32_t cw_ring_free(struct cw_ring *ring)
{
    uint64_t tail = look(ring, TAIL), count = look(ring, HEAD) - tail;

    if (!ring->reads)
        ring->seen = tail;
    return count <= ring->capacity ? ring->capacity - (uint32_t)count : 0;
}

static void *piece(struct cw_ring *ring, uint64_t counter, uint32_t available, uint32_t *count)
{
    uint64_t first = counter & ring->mask, until_wrap = ring->mask + 1 - first;

    *count = available < until_wrap ? available : (uint32_t)until_wrap;
    return available ? ring->records + first * ring->record_size : NULL;
}

const void *cw_ring_acquire(struct cw_ring *ring, uint32_t *count)
{
    return piece(ring, ring->words[TAIL], cw_ring_fill(ring), count);
}

void *cw_ring_acquire_free(struct cw_ring *ring, uint32_t *count)
{
    return piece(ring, ring->words[HEAD], cw_ring_free(ring), count);
}

/* The counter has moved: the other side is woken if it wanted to be by now. */
static void tell(struct cw_ring *ring, enum word wanted_word, uint64_t counter)
{
    uint64_t wanted;

    __atomic_thread_fence(__ATOMIC_SEQ_CST);
    wanted = __atomic_load_n(&ring->words[wanted_word], __ATOMIC_RELAXED);
    if (wanted != 0 && counter - wanted <= LARGEST_CAPACITY && ring->peer >= 0) {
        __atomic_store_n(&ring->words[wanted_word], 0, __ATOMIC_RELAXED);
        cw_ring_signal(ring, ring->peer);
    }
}

void cw_ring_release(struct cw_ring *ring, uint32_t count)
{
    uint64_t tail = ring->words[TAIL] + count;

    put(ring, TAIL, tail);
    tell(ring, FREE_WANTED, tail);
}

void cw_ring_commit(struct cw_ring *ring, uint32_t count)
{
    uint64_t head = ring->words[HEAD] + count;

    put(ring, HEAD, head);
    tell(ring, WANTED, head);
}

/* Ask for a signal once the other side's counter has gone so far beyond what was seen that the threshold is met. */
void cw_ring_arm(struct cw_ring *ring)
{
    enum word wanted_word = ring->reads ? WANTED : FREE_WANTED, theirs = ring->reads ? HEAD : TAIL;
    uint64_t waiting = ring->reads ? ring->seen - ring->words[TAIL] : ring->words[HEAD] - ring->seen;
    uint64_t there = waiting > ring->capacity ? 0 : ring->reads ? waiting : ring->capacity - waiting;
    uint64_t missing = ring->threshold > there ? ring->threshold - there : 1;
    uint64_t goal = ring->seen + missing;

    if (goal == 0) /* which would mean: no signal; better one too early than none */
        goal = UINT64_MAX;
    __atomic_store_n(&ring->words[wanted_word], goal, __ATOMIC_RELAXED);
    __atomic_thread_fence(__ATOMIC_SEQ_CST);
    if (look(ring, theirs) - goal <= LARGEST_CAPACITY) { /* it got there before it could see what is wanted */
        __atomic_store_n(&ring->words[wanted_word], 0, __ATOMIC_RELAXED);
        cw_ring_signal(ring, ring->own);
    }
}

int cw_ring_met(struct cw_ring *ring)
{
    return (ring->reads ? cw_ring_fill(ring) : cw_ring_free(ring)) >= ring->threshold;
}

void cw_ring_rearm(struct cw_ring *ring)
{
    cw_ring_met(ring); /* what is there now is told */
    cw_ring_arm(ring);
}

void cw_ring_touched(struct cw_ring *ring)
{
    if (ring->event != NULL)
        cw_ring_arm(ring);
}

void cw_ring_set_threshold(struct cw_ring *ring, uint32_t threshold)
{
    ring->threshold = threshold < 1 ? 1 : threshold > ring->capacity ? ring->capacity : threshold;
    if (ring->event != NULL)
        cw_ring_rearm(ring);
}
