/* AF_PACKET sockets: what tcpdump and Wireshark open. A program's descriptor is one of ours until it is bound to an interface
 * of the kernel's; then the kernel's own socket takes its place.
 *
 * Messages of the descriptor are frames, as of CAN_RAW. Where a program asks for a ring (PACKET_RX_RING), the server writes
 * into memory that the program maps, and messages of one byte only wake who waits: what poll tells is the state of the frame
 * or block that came last, as the kernel's packet_poll has it. Source: Linux' Documentation/networking/packet_mmap.rst.
 */
#include "ring.h"
#include "shim.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if_arp.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#ifndef ETH_P_CANFD
#define ETH_P_CANFD 0x000D
#endif

static struct mapped { /* the rings of this process' sockets, by slot: mapped for the looks of `ring_has_some` */
    char *memory;
    size_t size;
} mapped[MOST_SLOTS];

int open_packet_socket(int type, int protocol)
{
    struct request request = {.operation = OPEN_SOCKET, .a = type & 0xf, .b = PACKET << 16 | (protocol & 0xffff)};
    int about = ntohs((uint16_t)protocol), fd = -1;

    if (about != 0 && about != ETH_P_ALL && about != ETH_P_CAN && about != ETH_P_CANFD)
        return KERNELS_OWN;
    if (ask(&request, NULL, 0, NULL, NULL, &fd, type & SOCK_CLOEXEC) < 0)
        return -1;
    if (fd >= 0 && type & SOCK_NONBLOCK)
        REAL(fcntl)(fd, F_SETFL, REAL(fcntl)(fd, F_GETFL) | O_NONBLOCK);
    return fd;
}

/* Bound to an interface that we do not have: options that were set so far are the program's to set before. */
static int become_kernel_s(int fd, const struct slot *slot, const struct sockaddr *address, socklen_t length)
{
    int closes = REAL(fcntl)(fd, F_GETFD) & FD_CLOEXEC ? O_CLOEXEC : 0;
    int flags = REAL(fcntl)(fd, F_GETFL) & O_NONBLOCK ? SOCK_NONBLOCK : 0;
    int made = REAL(socket)(AF_PACKET, slot->type | flags | SOCK_CLOEXEC, (int)slot->receives);

    if (made < 0)
        return -1;
    int done = REAL(bind)(made, address, length) < 0 || dup3(made, fd, closes) < 0 ? -1 : 0;
    int before = errno;
    REAL(close)(made);
    errno = before;
    return done;
}

int bind_packet_socket(int fd, struct slot *slot, const struct sockaddr *address, socklen_t length)
{
    struct request request = {.operation = BIND, .slot = slot_number(slot)};
    struct sockaddr_ll name;

    if (length < offsetof(struct sockaddr_ll, sll_addr) || copy_in(&name, address, offsetof(struct sockaddr_ll, sll_addr)) != 0)
        return errno = length < offsetof(struct sockaddr_ll, sll_addr) ? EINVAL : EFAULT, -1;
    if (name.sll_family == AF_PACKET && name.sll_ifindex != 0 && interface_by_index(name.sll_ifindex) == NULL)
        return become_kernel_s(fd, slot, address, length);
    return ask(&request, address, length, NULL, NULL, NULL, 0) < 0 ? -1 : 0;
}

struct sockaddr_ll packet_name(const struct slot *slot, const struct received *header)
{
    struct sockaddr_ll name = {
        .sll_family = AF_PACKET, .sll_ifindex = header->interface, .sll_hatype = header->interface != 0 ? 280 : 0};

    name.sll_protocol = (uint16_t)slot->receives;
    if (header->length != 0) {
        name.sll_protocol = htons(header->length == CANFD_MTU ? ETH_P_CANFD : ETH_P_CAN);
        name.sll_pkttype = header->flags & RECEIVED_OUTGOING ? PACKET_OUTGOING : PACKET_BROADCAST;
    }
    return name;
}

/* AF_PACKET's PACKET_AUXDATA. */
void put_auxiliary(const struct received *header, struct msghdr *message, size_t *used)
{
    struct tpacket_auxdata data = {.tp_status = TP_STATUS_USER,
                                   .tp_len = header->length,
                                   .tp_snaplen = header->length};

    put_control(message, used, SOL_PACKET, PACKET_AUXDATA, &data, sizeof data);
}

/* ... and where it came from. */
int tell_packet(const struct slot *slot, const struct received *header, struct msghdr *message)
{
    struct sockaddr_ll name = packet_name(slot, header);

    if (message->msg_name == NULL)
        return 0;
    int error = copy_out(message->msg_name, &name, message->msg_namelen < sizeof name ? message->msg_namelen : sizeof name);
    message->msg_namelen = sizeof name;
    return error;
}

/* The interface that a message is for; -1 and errno: it cannot go. */
int packet_destination(const struct slot *slot, const struct msghdr *message)
{
    struct sockaddr_ll name;

    if (message->msg_name == NULL)
        return slot->interface;
    if (message->msg_namelen < offsetof(struct sockaddr_ll, sll_addr) ||
        copy_in(&name, message->msg_name, offsetof(struct sockaddr_ll, sll_addr)) != 0 || name.sll_family != AF_PACKET)
        return errno = EINVAL, -1;
    return name.sll_ifindex;
}

/* What of the ring's the server need not be asked for: how long a header is. 0, -1 and errno; 1: ask. */
int get_packet_option(struct slot *slot, int name, void *value, socklen_t *length)
{
    int version = 0;
    (void)slot;

    if (name != PACKET_HDRLEN)
        return 1;
    if (*length < sizeof version)
        return errno = EINVAL, -1;
    if (copy_in(&version, value, sizeof version) != 0)
        return errno = EFAULT, -1;
    if (version != TPACKET_V2 && version != TPACKET_V3) /* the first one has words of the machine's size */
        return errno = EINVAL, -1;
    int size = version == TPACKET_V2 ? sizeof(struct tpacket2_hdr) : sizeof(struct tpacket3_hdr);
    *length = sizeof size;
    return copy_out(value, &size, sizeof size) != 0 ? (errno = EFAULT, -1) : 0;
}

static void *map_ring(struct slot *slot, size_t length, int protection, int flags)
{
    struct request request = {.operation = MAP_RING, .slot = slot_number(slot)};
    struct mapped *own = &mapped[slot_number(slot)];
    int memory = -1;
    long size = ask(&request, NULL, 0, NULL, NULL, &memory, 1);

    if (size < 0 || memory < 0)
        return MAP_FAILED;
    void *found = MAP_FAILED;
    errno = EINVAL;
    if ((size_t)size == length)
        found = (void *)syscall(SYS_mmap, NULL, length, protection, flags, memory, 0);
    if (found != MAP_FAILED) {
        if (own->memory != NULL)
            munmap(own->memory, own->size);
        own->size = length;
        own->memory = (char *)syscall(SYS_mmap, NULL, length, PROT_READ, MAP_SHARED, memory, 0);
        if (own->memory == MAP_FAILED)
            own->memory = NULL;
    }
    int before = errno;
    REAL(close)(memory);
    errno = before;
    return found;
}

/* By the system call: programs map memory before there is a way to look for the C library's function. */
EXPORT void *mmap(void *address, size_t length, int protection, int flags, int fd, off_t offset)
{
    struct slot *slot = shim_table != NULL && fd >= 0 && !(flags & MAP_ANONYMOUS) ? slot_of(fd) : NULL;

    if (slot != NULL && slot->protocol == PACKET)
        return map_ring(slot, length, protection, flags);
    return (void *)syscall(SYS_mmap, address, length, protection, flags, fd, offset);
}

EXPORT void *mmap64(void *address, size_t length, int protection, int flags, int fd, off64_t offset)
{
    return mmap(address, length, protection, flags, fd, offset);
}

int ring_has_some(int fd, struct slot *slot)
{
    const struct mapped *own = &mapped[slot_number(slot)];
    struct pollfd end = {fd, 0, 0};
    char bytes[16];
    int came = 0;

    for (;;) { /* those that woke somebody, and those of errors, which are empty, as a read is after the server's end */
        ssize_t got = REAL(recv)(fd, bytes, sizeof bytes, MSG_DONTWAIT);
        if (got < 0 || (got == 0 && (REAL(poll)(&end, 1, 0) != 0)))
            break;
        came |= got > 0;
    }
    uint32_t at = __atomic_load_n(&slot->ring_at, __ATOMIC_ACQUIRE);
    if (own->memory == NULL || at > own->size)
        return came; /* another process has mapped it */
    return at != 0 && __atomic_load_n((const uint32_t *)(own->memory + at - 1), __ATOMIC_ACQUIRE) != TP_STATUS_KERNEL;
}

int rings_ready(int count, const fd_set *reads)
{
    int ready = 0;

    for (int fd = 0; fd < count; fd++) {
        struct slot *slot = FD_ISSET(fd, reads) ? slot_of(fd) : NULL;
        if (slot != NULL && slot->protocol == PACKET && slot->watched)
            ready += ring_has_some(fd, slot);
    }
    return ready;
}
