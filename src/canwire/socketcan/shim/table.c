/* The table in shared memory, and which descriptors are ours. */
#include "shim.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/un.h>
#include <unistd.h>

struct table *shim_table;

__attribute__((constructor)) static void map_table(void)
{
    const char *directory = getenv("CANWIRE_SOCKETCAN");
    char path[sizeof(((struct sockaddr_un *)0)->sun_path)];
    void *memory;
    int fd;

    if (directory == NULL || snprintf(path, sizeof path, "%s/table", directory) >= (int)sizeof path)
        return;
    fd = open(path, O_RDWR | O_CLOEXEC);
    if (fd < 0)
        return;
    memory = mmap(NULL, sizeof(struct table), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (memory != MAP_FAILED && ((struct table *)memory)->magic == TABLE_MAGIC)
        shim_table = memory;
    REAL(close)(fd);
}

/* The name of our end is "\0canwire-xxxxxxxx-" and four hexadecimal digits, the slot's number. */
struct slot *slot_of(int fd)
{
    struct sockaddr_un name;
    socklen_t length = sizeof name;
    unsigned number = 0;
    int before = errno;

    if (shim_table == NULL || fd < 0 || __atomic_load_n(&shim_table->slots, __ATOMIC_RELAXED) == 0)
        return NULL;
    if (REAL(getsockname)(fd, (struct sockaddr *)&name, &length) < 0) {
        errno = before;
        return NULL;
    }
    size_t prefix = strlen(shim_table->prefix);
    if (name.sun_family != AF_UNIX || length != offsetof(struct sockaddr_un, sun_path) + 1 + prefix + 4 ||
        name.sun_path[0] != '\0' || memcmp(name.sun_path + 1, shim_table->prefix, prefix) != 0)
        return NULL;
    for (int digit = 0; digit < 4; digit++) {
        char c = name.sun_path[1 + prefix + digit];
        number = number << 4 | (unsigned)(c <= '9' ? c - '0' : c - 'a' + 10);
    }
    return number < MOST_SLOTS ? &shim_table->slot[number] : NULL;
}

socklen_t address_length(const struct slot *slot)
{
    if (slot->protocol == CAN_J1939)
        return sizeof(struct sockaddr_can);
    return slot->protocol == CAN_ISOTP ? offsetof(struct sockaddr_can, can_addr.tp) + sizeof(canid_t[2])
                                       : offsetof(struct sockaddr_can, can_addr);
}

int slot_number(const struct slot *slot)
{
    return (int)(slot - shim_table->slot);
}

struct interface *interface_by_name(const char *name)
{
    for (uint32_t at = 0; shim_table != NULL && at < shim_table->interfaces && at < MOST_INTERFACES; at++)
        if (strncmp(shim_table->interface[at].name, name, sizeof shim_table->interface[at].name) == 0 &&
            !(shim_table->interface[at].flags & INTERFACE_GONE))
            return &shim_table->interface[at];
    return NULL;
}

struct interface *interface_by_index(int index)
{
    if (shim_table == NULL || index < FIRST_INDEX)
        return NULL;
    struct interface *interface = &shim_table->interface[(index - FIRST_INDEX) % MOST_INTERFACES];
    return interface->index == index && !(interface->flags & INTERFACE_GONE) ? interface : NULL;
}
