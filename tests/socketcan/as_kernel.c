/* What Linux' CAN sockets do where it is easily done otherwise: each check stands for an answer of kernel 6.1. */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/can.h>
#include <linux/can/bcm.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#define CHECK(what)                                                                                                    \
    do {                                                                                                               \
        if (!(what)) {                                                                                                 \
            printf("%s:%d: %s: %s\n", __func__, __LINE__, #what, strerror(errno));                                     \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)
#define FAILS(call, error) CHECK((errno = 0, (call) < 0 && errno == (error)))

static struct sockaddr_can can0(void)
{
    return (struct sockaddr_can){.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can0")};
}

static int bound(void)
{
    int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    struct sockaddr_can address = can0();

    CHECK(fd >= 0 && bind(fd, (struct sockaddr *)&address, sizeof address) == 0);
    return fd;
}

static void sent(int fd, unsigned id)
{
    struct can_frame one = {.can_id = id, .can_dlc = 1};
    CHECK(write(fd, &one, sizeof one) == sizeof one);
}

static unsigned received(int fd)
{
    struct can_frame one;
    CHECK(read(fd, &one, sizeof one) == sizeof one);
    return one.can_id;
}

static void heard_by(int fd)
{
    struct pollfd something = {fd, POLLIN, 0};
    CHECK(poll(&something, 1, 30000) == 1);
}

/* What is looped back is what was written: a remote frame's data, too, which no bus carries (the kernel's test_raw_filter). */
static void remote(void)
{
    struct can_frame one = {.can_id = 0x123 | CAN_RTR_FLAG, .can_dlc = 3, .data = {1, 2, 3, 4}}, echo;
    int sender = bound(), other = bound(), yes = 1;

    CHECK(setsockopt(sender, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &yes, sizeof yes) == 0);
    CHECK(write(sender, &one, sizeof one) == sizeof one);
    CHECK(read(sender, &echo, sizeof echo) == sizeof echo && memcmp(&one, &echo, sizeof one) == 0);
    CHECK(read(other, &echo, sizeof echo) == sizeof echo && memcmp(&one, &echo, sizeof one) == 0);
}

/* Its identifier; `lost` is how many frames this socket has lost so far, as SO_RXQ_OVFL tells. */
static unsigned received_after(int fd, unsigned *lost)
{
    struct can_frame one;
    struct iovec part = {&one, sizeof one};
    char control[CMSG_SPACE(sizeof *lost)];
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};

    CHECK(recvmsg(fd, &message, 0) == sizeof one);
    struct cmsghdr *about = CMSG_FIRSTHDR(&message);
    if (about != NULL && about->cmsg_type == SO_RXQ_OVFL)
        memcpy(lost, CMSG_DATA(about), sizeof *lost);
    return one.can_id & CAN_EFF_MASK;
}

#define COUNT 20000u

/* A socket that is bound to nothing waits for room like any other; a reader that is late learns how many frames it has lost. */
static void unbound(void)
{
    int reader = bound(), sender = socket(PF_CAN, SOCK_RAW, CAN_RAW), yes = 1;
    struct sockaddr_can address = can0();
    unsigned next = 0, count = 0, lost = 0;
    pid_t child;

    CHECK(setsockopt(reader, SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes) == 0);
    if ((child = fork()) == 0) {
        for (unsigned id = 0;; id++) {
            struct can_frame one = {.can_id = id | CAN_EFF_FLAG, .can_dlc = 1};
            CHECK(sendto(sender, &one, sizeof one, 0, (struct sockaddr *)&address, sizeof address) == sizeof one);
            if (id >= COUNT)
                usleep(50000); /* until one of them arrives */
        }
    }
    for (;;) {
        heard_by(reader);
        unsigned id = received_after(reader, &lost);
        CHECK(id >= next);
        next = id + 1;
        if (id >= COUNT)
            break;
        count++;
    }
    CHECK(count + lost == next - 1);
    CHECK(kill(child, SIGKILL) == 0 && wait(NULL) == child);
}

static volatile sig_atomic_t alarms;

static void count_alarm(int number)
{
    (void)number;
    alarms++;
}

/* read() goes on after a handler of signal(), and not after one without SA_RESTART. */
static void restart(void)
{
    int fd = bound(), status, pipes[2];
    struct sigaction plain = {.sa_handler = count_alarm};
    struct can_frame one;
    char byte;

    signal(SIGALRM, count_alarm);
    CHECK(pipe(pipes) == 0);
    if (fork() == 0) {
        int sender = bound();
        CHECK(read(pipes[0], &byte, 1) == 1);
        for (int at = 0; at < 5; at++) {
            CHECK(kill(getppid(), SIGALRM) == 0);
            usleep(20000);
        }
        sent(sender, 0x123);
        _exit(0);
    }
    CHECK(write(pipes[1], "", 1) == 1);
    CHECK(received(fd) == 0x123 && alarms > 0);
    CHECK(wait(&status) > 0 && status == 0);
    sigaction(SIGALRM, &plain, NULL);
    ualarm(20000, 20000);
    FAILS(read(fd, &one, sizeof one), EINTR);
    ualarm(0, 0);
    struct timeval limit = {0, 1000};
    CHECK(setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit) == 0);
    FAILS(read(fd, &one, sizeof one), EAGAIN);
}

static void pointers(void)
{
    int fd = bound(), other = bound(), seven = 7;
    char *page = mmap(NULL, 8192, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0), *edge = page + 4096;
    struct can_frame one = {.can_id = 5};
    struct iovec none = {&one, 0};
    socklen_t size = sizeof seven;

    CHECK(page != MAP_FAILED && munmap(edge, 4096) == 0);
    FAILS(write(fd, NULL, 16), EFAULT);
    FAILS(send(fd, edge - 8, 16, 0), EFAULT);
    memcpy(edge - 16, &one, 16);
    CHECK(write(fd, edge - 16, 16) == 16);
    heard_by(other);
    CHECK(read(other, edge - 8, 0) == 0 && readv(other, &none, 1) == 0);
    CHECK(recv(other, edge - 16, 4000, MSG_PEEK) == 16); /* what is not written may be anything */
    FAILS(recv(other, &one, 16, MSG_ERRQUEUE), EAGAIN);
    CHECK(received(other) == 5);
    sent(fd, 6);
    heard_by(other);
    FAILS(recv(other, (void *)8, 16, 0), EFAULT);
    FAILS(recv(other, &one, 16, MSG_DONTWAIT), EAGAIN);
    sent(fd, 7);
    heard_by(other);
    FAILS(read(other, edge - 8, 16), EFAULT);
    FAILS(getsockopt(fd, SOL_CAN_RAW, CAN_RAW_LOOPBACK, NULL, &size), EFAULT);
    FAILS(setsockopt(fd, SOL_CAN_RAW, CAN_RAW_LOOPBACK, NULL, 4), EFAULT);
    FAILS(ioctl(fd, SIOCGIFINDEX, (void *)8), EFAULT);
    CHECK(setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, "can0", 5) == 0);
    FAILS(setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, "nosuch0", 8), ENODEV);
}

/* The usual idiom: a struct with room for several frames, written whole. */
static void long_bcm(void)
{
    struct {
        struct bcm_msg_head head;
        struct can_frame frame[4];
    } message = {.head = {.opcode = TX_SETUP, .flags = SETTIMER | STARTTIMER, .count = 1, .can_id = 0x300, .nframes = 1}};
    int fd = socket(PF_CAN, SOCK_DGRAM, CAN_BCM), reader = bound();
    struct sockaddr_can address = can0();
    size_t taken = sizeof message.head + sizeof message.frame[0];

    message.head.ival1.tv_usec = 1000;
    message.frame[0] = (struct can_frame){.can_id = 0x300, .can_dlc = 1};
    CHECK(connect(fd, (struct sockaddr *)&address, sizeof address) == 0);
    CHECK(write(fd, &message, sizeof message) == (ssize_t)taken);
    CHECK(received(reader) == 0x300);
    message.head.opcode = RX_SETUP;
    message.head.flags = 0;
    CHECK(write(fd, &message, sizeof message) == (ssize_t)taken);
    message.head.opcode = TX_SEND;
    FAILS(write(fd, &message, sizeof message), EINVAL);
    message.head.opcode = TX_SETUP;
    message.head.nframes = 5;
    FAILS(write(fd, &message, sizeof message), EFAULT);
}

static void error_frames(void)
{
    int fd = bound();
    sent(fd, CAN_ERR_FLAG | 4);
    sent(fd, 1);
}

int main(int count, char **words)
{
    struct {
        const char *name;
        void (*call)(void);
    } all[] = {{"unbound", unbound}, {"remote", remote}, {"restart", restart}, {"pointers", pointers},
               {"bcm", long_bcm},    {"errors", error_frames}};

    for (size_t at = 0; count > 1 && at < sizeof all / sizeof all[0]; at++)
        if (strcmp(all[at].name, words[1]) == 0)
            all[at].call();
    puts("done");
    return 0;
}
