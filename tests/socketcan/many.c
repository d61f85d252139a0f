/* Many messages in one call: sendmmsg, recvmmsg, and io_uring's ring; by a program that is linked statically, too. */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <time.h>
#include <linux/errqueue.h>
#include <linux/io_uring.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static int opened(void)
{
    int fd = socket(AF_CAN, SOCK_RAW, CAN_RAW);
    struct ifreq about = {.ifr_name = "can0"};
    struct sockaddr_can name = {.can_family = AF_CAN};

    ioctl(fd, SIOCGIFINDEX, &about);
    name.can_ifindex = about.ifr_ifindex;
    return bind(fd, (void *)&name, sizeof name) < 0 ? -1 : fd;
}

static void many(int from, int to)
{
    struct can_frame frames[4] = {{.can_id = 1}, {.can_id = 2}, {.can_id = 3}, {.can_id = 4}}, came[4] = {{0}};
    struct iovec parts[4], theirs[4];
    struct mmsghdr messages[4] = {{{0}}}, heard[4] = {{{0}}};
    struct sockaddr_can names[4];
    struct timespec limit = {5, 0};

    for (int at = 0; at < 4; at++) {
        parts[at] = (struct iovec){&frames[at], sizeof *frames};
        theirs[at] = (struct iovec){&came[at], sizeof *came};
        messages[at].msg_hdr = (struct msghdr){.msg_iov = &parts[at], .msg_iovlen = 1};
        heard[at].msg_hdr = (struct msghdr){
            .msg_iov = &theirs[at], .msg_iovlen = 1, .msg_name = &names[at], .msg_namelen = sizeof names[at]};
    }
    int sent = sendmmsg(from, messages, 4, 0);
    int got = recvmmsg(to, heard, 4, 0, &limit);
    printf("sent %d of %u bytes, heard %d of %u: %x %x %x %x, address %d\n", sent, messages[3].msg_len, got,
           heard[3].msg_len, came[0].can_id, came[1].can_id, came[2].can_id, came[3].can_id,
           names[3].can_family == AF_CAN && names[3].can_ifindex > 1000);
    got = recvmmsg(to, heard, 4, MSG_DONTWAIT, NULL);
    printf("then %d, errno %d\n", got, errno);
}

static void stamped(int fd)
{
    int wanted = SOF_TIMESTAMPING_TX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
    struct can_frame frame = {.can_id = 5, .len = 1}, back = {0};
    char control[256];
    struct iovec part = {&back, sizeof back};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    struct sockaddr_can name;
    socklen_t length = sizeof name;

    setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPING, &wanted, sizeof wanted);
    getsockname(fd, (void *)&name, &length);
    sendto(fd, &frame, sizeof frame, 0, (void *)&name, sizeof name);
    for (int tries = 0; tries < 2000 && recvmsg(fd, &message, MSG_ERRQUEUE) < 0; tries++)
        usleep(1000);
    printf("stamped %x, %d bytes of control, flags %x\n", back.can_id, (int)message.msg_controllen, message.msg_flags);
}

static void by_ring(int from, int to)
{
    struct io_uring_params about = {0};
    int ring = (int)syscall(SYS_io_uring_setup, 4, &about);
    struct can_frame frame = {.can_id = 0x77, .len = 2}, came = {0};

    if (ring < 0) {
        printf("ring: %d\n", errno);
        return;
    }
    size_t size = about.cq_off.cqes + about.cq_entries * sizeof(struct io_uring_cqe);
    char *queues = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, ring, IORING_OFF_SQ_RING);
    struct io_uring_sqe *entries = mmap(NULL, about.sq_entries * sizeof *entries, PROT_READ | PROT_WRITE, MAP_SHARED,
                                        ring, IORING_OFF_SQES);
    for (int at = 0; at < 2; at++) {
        memset(&entries[at], 0, sizeof entries[at]);
        entries[at].opcode = at == 0 ? IORING_OP_WRITE : IORING_OP_READ;
        entries[at].fd = at == 0 ? from : to;
        entries[at].addr = (unsigned long)(at == 0 ? &frame : &came);
        entries[at].len = sizeof frame;
        ((unsigned *)(queues + about.sq_off.array))[at] = (unsigned)at;
    }
    __atomic_store_n((unsigned *)(queues + about.sq_off.tail), 2, __ATOMIC_RELEASE);
    int done = (int)syscall(SYS_io_uring_enter, ring, 2, 2, IORING_ENTER_GETEVENTS, NULL, 0);
    printf("ring: %d done, heard %x of %d bytes\n", done, came.can_id, came.len);
}

int main(void)
{
    int from = opened(), to = opened();

    many(from, to);
    by_ring(from, to);
    stamped(from);
    return 0;
}
