/* Rings of a helper on Windows: memory is a file that both ends have mapped, signals go over the first connection. */
#include "win32.h"

#include <errno.h>

int cw_ring_map(struct cw_ring *ring, int descriptor)
{
    HANDLE mapping = CreateFileMappingW((HANDLE)(intptr_t)descriptor, NULL, PAGE_READWRITE, 0, 0, NULL);
    void *at = mapping != NULL ? MapViewOfFile(mapping, FILE_MAP_READ | FILE_MAP_WRITE, 0, 0, 0) : NULL;
    MEMORY_BASIC_INFORMATION about;

    if (mapping != NULL)
        CloseHandle(mapping); /* the view keeps it */
    if (at == NULL || VirtualQuery(at, &about, sizeof about) == 0) {
        if (at != NULL)
            UnmapViewOfFile(at);
        errno = ENOMEM;
        return -1;
    }
    ring->mapping = at;
    ring->mapping_size = about.RegionSize;
    return 0;
}

void cw_ring_unmap(struct cw_ring *ring)
{
    UnmapViewOfFile(ring->mapping);
    ring->mapping = NULL;
}

int cw_ring_ended(const struct cw_ring *ring)
{
    return __atomic_load_n(&ring->state, __ATOMIC_ACQUIRE) != 0;
}

void cw_ring_signal(struct cw_ring *ring, int descriptor)
{
    if (descriptor != ring->own)
        far_say(RING, descriptor & ~SIGNAL);
    else
        far_signal_own(ring); /* it got there before it was armed */
}
