/* getsockname and getpeername. */
#include "shim.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/if_packet.h>
#include <stddef.h>

static int name_of_j1939(const struct slot *slot, int peer, struct sockaddr *address, socklen_t *length)
{
    struct request request = {.operation = NAME, .slot = slot_number(slot), .a = peer};
    struct sockaddr_can name;
    size_t size = sizeof name;

    if (ask(&request, NULL, 0, &name, &size, NULL, 0) < 0)
        return -1;
    int error = copy_out(address, &name, *length < size ? *length : size);
    *length = (socklen_t)size;
    return error != 0 ? (errno = error, -1) : 0;
}

static int put_name(struct sockaddr *address, socklen_t *length, const void *name, socklen_t whole)
{
    int error = copy_out(address, name, *length < whole ? *length : whole);

    *length = whole;
    return error != 0 ? (errno = error, -1) : 0;
}

EXPORT int getsockname(int fd, struct sockaddr *address, socklen_t *length)
{
    struct slot *slot = slot_of(fd);
    struct sockaddr_can name = {.can_family = AF_CAN};

    if (slot == NULL)
        return REAL(getsockname)(fd, address, length);
    if (slot->protocol == PACKET) {
        struct received from = {.interface = slot->interface};
        struct sockaddr_ll own = packet_name(slot, &from);
        return put_name(address, length, &own, offsetof(struct sockaddr_ll, sll_addr));
    }
    name.can_ifindex = slot->interface;
    name.can_addr.tp.rx_id = slot->receives;
    name.can_addr.tp.tx_id = slot->sends;
    if (slot->protocol == CAN_J1939)
        return name_of_j1939(slot, 0, address, length);
    if (slot->protocol == CAN_BCM) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return put_name(address, length, &name, address_length(slot));
}

EXPORT int getpeername(int fd, struct sockaddr *address, socklen_t *length)
{
    struct slot *slot = slot_of(fd);

    if (slot == NULL)
        return REAL(getpeername)(fd, address, length);
    if (slot->protocol == CAN_J1939)
        return name_of_j1939(slot, 1, address, length);
    errno = EOPNOTSUPP;
    return -1;
}
