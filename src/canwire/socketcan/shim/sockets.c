/* Making sockets, binding them, and their options. */
#include "timed.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <linux/if_packet.h>
#include <linux/netlink.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#ifndef SO_TIMESTAMP_NEW
#define SO_TIMESTAMP_NEW 63
#define SO_TIMESTAMPNS_NEW 64
#define SO_TIMESTAMPING_NEW 65
#endif
#define SO_TIMESTAMP_OLD_ 29
#define SO_TIMESTAMPNS_OLD_ 35
#define SO_TIMESTAMPING_OLD_ 37
#define PROTOCOLS 8 /* CAN_NPROTO */
#define KINDS 11 /* SOCK_MAX */
#define LARGEST_OPTION 65536
#define TRANSMIT_STAMPS                                                                                                \
    (SOF_TIMESTAMPING_TX_HARDWARE | SOF_TIMESTAMPING_TX_SOFTWARE | SOF_TIMESTAMPING_TX_SCHED)

int open_can_socket(int type, int protocol)
{
    struct request request = {.operation = OPEN_SOCKET, .a = type & 0xf, .b = protocol};
    int fd = -1;

    if (protocol < 0 || protocol >= PROTOCOLS || (type & 0xf) >= KINDS ||
        type & ~(0xf | SOCK_CLOEXEC | SOCK_NONBLOCK)) {
        errno = EINVAL;
        return -1;
    }
    if (ask(&request, NULL, 0, NULL, NULL, &fd, type & SOCK_CLOEXEC) < 0)
        return -1;
    if (fd >= 0 && type & SOCK_NONBLOCK)
        REAL(fcntl)(fd, F_SETFL, REAL(fcntl)(fd, F_GETFL) | O_NONBLOCK);
    if (timed())
        seat_taken();
    return fd;
}

EXPORT int socket(int domain, int type, int protocol)
{
    if (shim_table == NULL)
        return REAL(socket)(domain, type, protocol);
    if (domain == AF_CAN)
        return open_can_socket(type, protocol);
    if (domain == AF_NETLINK && protocol == 0)
        return open_link_socket(type);
    if (domain == AF_PACKET && shim_table->interfaces > 0) {
        int fd = open_packet_socket(type, protocol);
        if (fd != KERNELS_OWN)
            return fd;
    }
    return REAL(socket)(domain, type, protocol);
}

static int ask_with_address(enum operation operation, const struct slot *slot, const struct sockaddr *address,
                            socklen_t length)
{
    struct request request = {.operation = operation, .slot = slot_number(slot)};

    return ask(&request, address, length, NULL, NULL, NULL, 0) < 0 ? -1 : 0;
}

EXPORT int bind(int fd, const struct sockaddr *address, socklen_t length)
{
    struct slot *slot = slot_of(fd);

    if (slot == NULL && is_link_socket(fd))
        return bind_link_socket(fd, address, length);
    if (slot != NULL && slot->protocol == PACKET)
        return bind_packet_socket(fd, slot, address, length);
    return slot == NULL ? REAL(bind)(fd, address, length) : ask_with_address(BIND, slot, address, length);
}

EXPORT int connect(int fd, const struct sockaddr *address, socklen_t length)
{
    struct slot *slot = slot_of(fd);

    return slot == NULL ? REAL(connect)(fd, address, length) : ask_with_address(CONNECT, slot, address, length);
}

static int is_stamp(int name)
{
    return name == SO_TIMESTAMP_OLD_ || name == SO_TIMESTAMP_NEW || name == SO_TIMESTAMPNS_OLD_ ||
           name == SO_TIMESTAMPNS_NEW;
}

static int is_stamping(int name)
{
    return name == SO_TIMESTAMPING_OLD_ || name == SO_TIMESTAMPING_NEW;
}

/* Of the socket itself; 1: not one that differs from the kernel's socket below, which may have it. */
static int set_socket_option(struct slot *slot, int name, const void *value, socklen_t length)
{
    int number;

    if ((name == SO_ATTACH_FILTER || name == SO_ATTACH_BPF) && slot->protocol == PACKET && slot->watched)
        return errno = ENOPROTOOPT, -1; /* what wakes the program is no frame: libpcap filters by itself then */
    if (name == SO_BINDTODEVICE) { /* which a CAN socket's bind does not look at */
        char device[IFNAMSIZ] = "";
        if (copy_in(device, value, length < sizeof device - 1 ? length : sizeof device - 1) != 0)
            errno = EFAULT;
        else if (device[0] == '\0' || interface_by_name(device) != NULL)
            return 0;
        else
            return 1;
        return -1;
    }
    if (name == SO_RCVTIMEO) {
        struct timeval limit;
        if (length >= sizeof limit && copy_in(&limit, value, sizeof limit) == 0)
            slot->receive_timeout_us =
                limit.tv_sec > 4000 ? 4000000000u : (uint32_t)(limit.tv_sec * 1000000 + limit.tv_usec);
        return 1;
    }
    int broadcasts = name == SO_BROADCAST && slot->protocol == CAN_J1939;
    if (!broadcasts && name != SO_RCVBUF && name != SO_RCVBUFFORCE && name != SO_RXQ_OVFL && !is_stamp(name) && !is_stamping(name))
        return 1;
    if (length < sizeof number) {
        errno = EINVAL;
        return -1;
    }
    if (copy_in(&number, value, sizeof number) != 0) {
        errno = EFAULT;
        return -1;
    }
    if (is_stamping(name) && number & ~SOF_TIMESTAMPING_MASK) {
        errno = EINVAL;
        return -1;
    }
    if (broadcasts)
        slot->broadcasts = number != 0;
    else if (name == SO_RXQ_OVFL)
        slot->counts_drops = number != 0;
    else if (is_stamp(name))
        slot->stamp = number != 0 ? (uint32_t)name : 0;
    else if (is_stamping(name)) {
        uint32_t before = slot->stamping_flags;
        slot->stamping = (uint32_t)name;
        slot->stamping_flags = (uint32_t)number;
        if ((before | slot->stamping_flags) & TRANSMIT_STAMPS) {
            struct request request = {
                .operation = SET_OPTION, .slot = slot_number(slot), .a = SOL_SOCKET, .b = name};
            return ask(&request, NULL, 0, NULL, NULL, NULL, 0) < 0 ? -1 : 0;
        }
    } else
        slot->receive_buffer = number < 1152 ? 2304 : number > 0x3fffffff ? 0x7fffffff : (uint32_t)number * 2;
    return 0;
}

EXPORT int setsockopt(int fd, int level, int name, const void *value, socklen_t length)
{
    struct slot *slot = slot_of(fd);
    struct request request = {.operation = SET_OPTION, .a = level, .b = name};

    if (slot == NULL && level == SOL_NETLINK && is_link_socket(fd))
        return set_link_option(fd, name, value, length);
    if (slot == NULL)
        return REAL(setsockopt)(fd, level, name, value, length);
    if (level == SOL_SOCKET) {
        int done = set_socket_option(slot, name, value, length);
        return done <= 0 ? done : REAL(setsockopt)(fd, level, name, value, length);
    }
    request.slot = slot_number(slot);
    if (slot->protocol == PACKET && level == SOL_PACKET && name == PACKET_RX_RING)
        REAL(setsockopt)(fd, SOL_SOCKET, SO_DETACH_FILTER, &level, sizeof level);
    if (length > LARGEST_OPTION) {
        errno = EINVAL;
        return -1;
    }
    return ask(&request, value, length, NULL, NULL, NULL, 0) < 0 ? -1 : 0;
}

static int get_socket_option(int fd, struct slot *slot, int name, int *number)
{
    switch (name) {
    case SO_DOMAIN: *number = slot->protocol == PACKET ? AF_PACKET : AF_CAN; return 0;
    case SO_TYPE: *number = slot->type; return 0;
    case SO_PROTOCOL: *number = slot->protocol == PACKET ? (int)slot->receives : 0; return 0; /* can_create sets none */
    case SO_RCVBUF: *number = (int)slot->receive_buffer; return 0;
    case SO_RXQ_OVFL: *number = (int)slot->counts_drops; return 0;
    case SO_ERROR: *number = take_error(fd, slot); return 0;
    default: break;
    }
    if (name == SO_BROADCAST && slot->protocol == CAN_J1939)
        *number = (int)slot->broadcasts;
    else if (is_stamp(name))
        *number = slot->stamp == (uint32_t)name;
    else if (is_stamping(name))
        *number = (int)slot->stamping_flags;
    else
        return 1;
    return 0;
}

static int given(void *into, const void *from, size_t length)
{
    if (copy_out(into, from, length) == 0)
        return 0;
    errno = EFAULT;
    return -1;
}

EXPORT int getsockopt(int fd, int level, int name, void *value, socklen_t *length)
{
    struct slot *slot = slot_of(fd);
    struct request request = {.operation = GET_OPTION, .a = level, .b = name};
    char reply[LARGEST_OPTION];
    size_t size = sizeof reply;
    int number;

    if (slot == NULL && level == SOL_SOCKET && name == SO_PROTOCOL && is_link_socket(fd)) {
        number = 0; /* NETLINK_ROUTE */
        *length = *length < sizeof number ? *length : sizeof number;
        return given(value, &number, *length);
    }
    if (slot == NULL)
        return REAL(getsockopt)(fd, level, name, value, length);
    if (level == SOL_SOCKET) {
        if (get_socket_option(fd, slot, name, &number) != 0)
            return REAL(getsockopt)(fd, level, name, value, length);
        *length = *length < sizeof number ? *length : sizeof number;
        return given(value, &number, *length);
    }
    request.slot = slot_number(slot);
    if (slot->protocol == PACKET && level == SOL_PACKET) {
        int done = get_packet_option(slot, name, value, length);
        if (done <= 0)
            return done;
    }
    if (slot->protocol == CAN_RAW && (level != SOL_CAN_RAW || (int)*length < 0)) {
        errno = EINVAL;
        return -1;
    }
    if (ask(&request, NULL, 0, reply, &size, NULL, 0) < 0)
        return -1;
    if (level == SOL_CAN_RAW && name == CAN_RAW_FILTER && *length < size) { /* as the kernel: tell how long it is */
        *length = (socklen_t)size;
        errno = ERANGE;
        return -1;
    }
    *length = *length < size ? *length : (socklen_t)size;
    return given(value, reply, *length);
}
