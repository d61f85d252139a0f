/* Rings of a helper on Linux: memory and events are descriptors that came with a call. */
#include "core.h"

#include <stddef.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

int cw_ring_map(struct cw_ring *ring, int descriptor)
{
    struct stat about;
    void *mapping;

    if (fstat(descriptor, &about) < 0)
        return -1;
    mapping = mmap(NULL, (size_t)about.st_size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (mapping == MAP_FAILED)
        return -1;
    ring->mapping = mapping;
    ring->mapping_size = (size_t)about.st_size;
    return 0;
}

void cw_ring_unmap(struct cw_ring *ring)
{
    munmap(ring->mapping, ring->mapping_size);
    ring->mapping = NULL;
}

int cw_ring_ended(const struct cw_ring *ring)
{
    return cw_state_of(ring->state) != 0;
}

void cw_ring_signal(struct cw_ring *ring, int descriptor)
{
    static const uint64_t one = 1;

    (void)ring;
    cw_changed();
    if (write(descriptor, &one, sizeof one) < 0)
        return; /* full: it has a wake-up pending anyway; or it is gone */
}

int cw_drain(int descriptor)
{
    char rest[4096];

    return read(descriptor, rest, sizeof rest) > 0;
}

int cw_ring_wait(struct cw_ring *ring, int64_t milliseconds)
{
    int64_t until = cw_deadline(milliseconds);

    while (!cw_ring_met(ring)) {
        struct pollfd about[2] = {{ring->own, POLLIN, 0}, {cw_lifeline(), POLLIN, 0}};

        if (cw_ring_over(ring))
            return -1;
        cw_ring_arm(ring);
        if (cw_poll(about, 2, until) == 0)
            return 0;
        if (about[1].revents)
            return cw_ring_met(ring) ? 1 : -1;
        if (about[0].revents)
            cw_drain(ring->own);
    }
    if (!ring->reads && cw_ring_over(ring)) /* what has come can still be read, but nothing more goes out */
        return -1;
    cw_ring_touched(ring);
    return 1;
}
