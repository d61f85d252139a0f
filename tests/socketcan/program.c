/* What SocketCAN programs do with their descriptors besides reading and writing; each check says what it found. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <linux/can.h>
#include <linux/can/bcm.h>
#include <linux/can/raw.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
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

static int opened(const char *name, int flags)
{
    int fd = socket(PF_CAN, SOCK_RAW | flags, CAN_RAW);
    struct sockaddr_can address = {.can_family = AF_CAN};
    struct ifreq about;

    CHECK(fd >= 0);
    strcpy(about.ifr_name, name);
    CHECK(ioctl(fd, SIOCGIFINDEX, &about) == 0);
    address.can_ifindex = about.ifr_ifindex;
    CHECK(bind(fd, (struct sockaddr *)&address, sizeof address) == 0);
    return fd;
}

static struct can_frame frame(int id)
{
    struct can_frame made = {.can_id = (canid_t)id, .can_dlc = 1, .data = {(unsigned char)id}};
    return made;
}

static void sent(int fd, int id)
{
    struct can_frame one = frame(id);
    CHECK(write(fd, &one, sizeof one) == sizeof one);
}

static int received(int fd)
{
    struct can_frame one;
    CHECK(read(fd, &one, sizeof one) == sizeof one);
    return (int)one.can_id;
}

static void names(void)
{
    struct ifaddrs *all, *one;
    struct if_nameindex *list;
    char name[IF_NAMESIZE];
    unsigned index = if_nametoindex("can0");
    int found = 0, listed = 0, fd = opened("can0", 0);
    struct ifreq about = {.ifr_ifindex = (int)index};
    struct sockaddr_can own;
    socklen_t size = sizeof own;

    CHECK(index != 0 && strcmp(if_indextoname(index, name), "can0") == 0);
    CHECK(ioctl(fd, SIOCGIFNAME, &about) == 0 && strcmp(about.ifr_name, "can0") == 0);
    CHECK(ioctl(fd, SIOCGIFMTU, &about) == 0 && about.ifr_mtu == CANFD_MTU);
    CHECK(ioctl(fd, SIOCGIFFLAGS, &about) == 0 && about.ifr_flags & IFF_UP);
    CHECK(getsockname(fd, (struct sockaddr *)&own, &size) == 0 && own.can_ifindex == (int)index);
    CHECK(getifaddrs(&all) == 0);
    for (one = all; one != NULL; one = one->ifa_next)
        found += strcmp(one->ifa_name, "can0") == 0;
    freeifaddrs(all);
    CHECK((list = if_nameindex()) != NULL);
    for (struct if_nameindex *at = list; at->if_index != 0; at++)
        listed += strcmp(at->if_name, "HW000002_1") == 0;
    if_freenameindex(list);
    CHECK(found == 1 && listed == 1);
    strcpy(about.ifr_name, "nosuch0");
    FAILS(ioctl(fd, SIOCGIFINDEX, &about), ENODEV);
    close(fd);
}

static void mistakes(void)
{
    int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    struct can_frame one = frame(1);
    struct canfd_frame fd_frame = {.can_id = 1, .len = 1};
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = 4711};

    FAILS(write(fd, &one, sizeof one), ENXIO);
    FAILS(bind(fd, (struct sockaddr *)&address, sizeof address), ENODEV);
    FAILS(bind(fd, (struct sockaddr *)&address, 4), EINVAL);
    address.can_family = AF_INET;
    FAILS(bind(fd, (struct sockaddr *)&address, sizeof address), EINVAL);
    close(fd);
    fd = opened("can0", 0);
    FAILS(write(fd, &one, 15), EINVAL);
    FAILS(write(fd, &one, 0), EINVAL);
    FAILS(write(fd, &fd_frame, sizeof fd_frame), EINVAL);
    one.can_dlc = 9;
    FAILS(write(fd, &one, sizeof one), EINVAL);
    FAILS(setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &one, 7), EINVAL);
    FAILS(setsockopt(fd, SOL_CAN_RAW, 99, &one, 4), ENOPROTOOPT);
    close(fd);
    fd = opened("can0", 0);
    FAILS(shutdown(fd, SHUT_RDWR), EOPNOTSUPP);
    FAILS(listen(fd, 1), EOPNOTSUPP);
    FAILS(setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &one, 1), EINVAL);
    sent(fd, 1);
    close(fd);
    FAILS(socket(PF_CAN, SOCK_RAW, 7), EPROTOTYPE);
    FAILS(socket(PF_CAN, SOCK_DGRAM, 5), EPROTONOSUPPORT);
    FAILS(socket(PF_CAN, SOCK_STREAM, CAN_RAW), EPROTOTYPE);
    FAILS(socket(PF_CAN, SOCK_RAW, 42), EINVAL);
    fd = socket(PF_CAN, SOCK_DGRAM, CAN_BCM);
    FAILS(write(fd, &one, sizeof one), ENOTCONN);
    close(fd);
}

static void descriptors(void)
{
    int one = opened("can0", SOCK_NONBLOCK | SOCK_CLOEXEC), other = opened("can0", 0), twin, epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    struct can_frame none;
    int status;

    CHECK(fcntl(one, F_GETFD) & FD_CLOEXEC && fcntl(one, F_GETFL) & O_NONBLOCK);
    FAILS(read(one, &none, sizeof none), EAGAIN);
    CHECK(epoll_ctl(epoll, EPOLL_CTL_ADD, one, &event) == 0);
    CHECK(epoll_wait(epoll, &event, 1, 0) == 0);
    for (int id = 1; id <= 300; id++)
        sent(other, id);
    for (int id = 1; id <= 300; id++) {
        CHECK(epoll_wait(epoll, &event, 1, 30000) == 1);
        CHECK(received(one) == id);
    }
    CHECK(epoll_wait(epoll, &event, 1, 0) == 0);
    twin = dup(other);
    close(other);
    if (fork() == 0) {
        sent(twin, 0x111);
        _exit(0);
    }
    CHECK(wait(&status) > 0 && status == 0);
    CHECK(epoll_wait(epoll, &event, 1, 30000) == 1 && received(one) == 0x111);
    sent(one, 0x222);
    CHECK(received(twin) == 0x222);
    close(one);
    close(twin);
    close(epoll);
}

/* Whoever was told that there is something finds it, whenever it looks; and two readers share without loss. */
static void storm(void)
{
    int fd = opened("can0", SOCK_NONBLOCK), shared = opened("can0", SOCK_NONBLOCK), sender = opened("can0", 0), status;
    struct pollfd one = {fd, POLLIN, 0}, both = {shared, POLLIN, 0};
    struct can_frame seen;
    int pipes[2], counts[2] = {0, 0};

    CHECK(pipe(pipes) == 0);
    for (int reader = 0; reader < 2; reader++)
        if (fork() == 0) {
            int count = 0;
            while (poll(&both, 1, 2000) == 1)
                count += read(shared, &seen, sizeof seen) == sizeof seen;
            CHECK(write(pipes[1], &count, sizeof count) == sizeof count);
            _exit(0);
        }
    if (fork() == 0) {
        for (int id = 0; id < 20000; id++)
            sent(sender, id & 0x7FF);
        _exit(0);
    }
    for (int id = 0; id < 20000; id++) {
        CHECK(poll(&one, 1, 30000) == 1);
        CHECK(received(fd) == (id & 0x7FF));
    }
    CHECK(poll(&one, 1, 0) == 0);
    for (int child = 0; child < 3; child++)
        CHECK(wait(&status) > 0 && status == 0);
    CHECK(read(pipes[0], counts, sizeof counts) == sizeof counts);
    printf("%d and %d\n", counts[0], counts[1]);
    CHECK(counts[0] + counts[1] == 20000);
}

static void across_exec(const char *self)
{
    int fd = opened("can0", 0), other = opened("can0", 0), status;
    char number[16];

    snprintf(number, sizeof number, "%d", fd);
    if (fork() == 0) {
        execl(self, self, "send", number, NULL);
        _exit(2);
    }
    CHECK(wait(&status) > 0 && status == 0);
    CHECK(received(other) == 0x7E5);
    close(fd);
    close(other);
}

static void own_frames(void)
{
    int fd = opened("can0", 0), on = 1;
    struct can_frame one;
    struct iovec part = {&one, sizeof one};
    struct sockaddr_can from;
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1, .msg_name = &from, .msg_namelen = sizeof from};

    CHECK(setsockopt(fd, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &on, sizeof on) == 0);
    sent(fd, 5);
    CHECK(recvmsg(fd, &message, 0) == sizeof one && one.can_id == 5);
    CHECK(message.msg_flags & MSG_CONFIRM && message.msg_flags & MSG_DONTROUTE);
    CHECK(from.can_family == AF_CAN && from.can_ifindex == (int)if_nametoindex("can0"));
    close(fd);
}

/* The next frame, and what of those before was lost. */
static int received_with_losses(int fd, unsigned *lost)
{
    struct can_frame one;
    char control[256];
    struct iovec part = {&one, sizeof one};
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};

    CHECK(recvmsg(fd, &message, 0) == sizeof one);
    for (struct cmsghdr *at = CMSG_FIRSTHDR(&message); at != NULL; at = CMSG_NXTHDR(&message, at))
        if (at->cmsg_type == SO_RXQ_OVFL)
            memcpy(lost, CMSG_DATA(at), sizeof *lost);
    return (int)one.can_id;
}

/* A reader that reads nothing: what does not fit is counted, and others lose nothing. */
static void overflow(void)
{
    int lazy = opened("can0", 0), reader = opened("can0", 0), sender = opened("can0", 0), on = 1, small = 0;
    unsigned lost = 0, seen = 0;
    struct pollfd more = {lazy, POLLIN, 0};

    CHECK(setsockopt(lazy, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) == 0);
    CHECK(setsockopt(lazy, SOL_SOCKET, SO_RCVBUF, &small, sizeof small) == 0);
    CHECK(setsockopt(sender, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0) == 0);
    for (int id = 0; id < 6000; id++) {
        sent(sender, id & 0x7FF);
        CHECK(received(reader) == (id & 0x7FF));
    }
    while (poll(&more, 1, 300) == 1 && ++seen)
        CHECK(received_with_losses(lazy, &lost) >= 0);
    CHECK(lost == 0);
    sent(sender, 0x7FF);
    CHECK(received_with_losses(lazy, &lost) == 0x7FF);
    printf("seen %u, lost %u\n", seen, lost);
    CHECK(seen > 0 && seen < 10 && seen + lost == 6000); /* 2304 bytes, as the kernel counts them */
    close(lazy);
    close(reader);
    close(sender);
}

/* A line without anybody who acknowledges: its queue fills, and nothing of it goes out. */
static void full(void)
{
    int patient = opened("HW000002_1", 0), quick = opened("HW000002_1", SOCK_NONBLOCK);
    struct timeval limit = {0, 1000};
    struct can_frame one = frame(1);
    int count = 0;

    while (write(quick, &one, sizeof one) == sizeof one)
        CHECK(++count < 10000);
    CHECK(errno == ENOBUFS && count >= 10);
    while (write(patient, &one, sizeof one) == sizeof one)
        CHECK(++count < 20000);
    CHECK(errno == ENOBUFS);
    CHECK(setsockopt(patient, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit) == 0);
    CHECK(write(patient, &one, sizeof one) < 0 && (errno == EAGAIN || errno == ENOBUFS));
    close(patient);
    close(quick);
}

/* Times as the kernel tells them, in each of the forms that it has. */
static void stamps(void)
{
    int fd = opened("can0", 0), other = opened("can0", 0), on = 1, forms = 0x10 | 0x40;
    struct timeval coarse, *told = NULL;
    struct timespec *fine = NULL;
    struct can_frame one;
    struct iovec part = {&one, sizeof one};
    char control[256];
    struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};

    FAILS(ioctl(fd, SIOCGSTAMP_OLD, &coarse), ENOENT);
    CHECK(setsockopt(fd, SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on) == 0);
    CHECK(setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPING, &forms, sizeof forms) == 0);
    sent(other, 1);
    CHECK(recvmsg(fd, &message, 0) == sizeof one);
    for (struct cmsghdr *at = CMSG_FIRSTHDR(&message); at != NULL; at = CMSG_NXTHDR(&message, at)) {
        if (at->cmsg_type == SO_TIMESTAMP)
            told = (struct timeval *)CMSG_DATA(at);
        if (at->cmsg_type == SO_TIMESTAMPING)
            fine = (struct timespec *)CMSG_DATA(at);
    }
    CHECK(told != NULL && fine != NULL && fine[2].tv_sec == told->tv_sec && fine[2].tv_nsec / 1000 == told->tv_usec);
    CHECK(ioctl(fd, SIOCGSTAMP_OLD, &coarse) == 0 && coarse.tv_sec == told->tv_sec && coarse.tv_usec == told->tv_usec);
    sent(other, 2);
    struct pollfd second = {fd, POLLIN, 0};
    int waiting;
    CHECK(poll(&second, 1, 30000) == 1);
    FAILS(ioctl(fd, FIONREAD, &waiting), ENOTTY);
    message.msg_controllen = sizeof(struct cmsghdr) + 1;
    CHECK(recvmsg(fd, &message, MSG_PEEK) == sizeof one && message.msg_flags & MSG_CTRUNC);
    CHECK(recv(fd, &one, 8, MSG_TRUNC) == 8); /* 6.1 does not know this flag as one that is given */
    CHECK(recv(fd, &one, 8, MSG_DONTWAIT) < 0 && errno == EAGAIN);
    close(fd);
    close(other);
}

static void thousands(void)
{
    int fds[1500], last;

    for (int at = 0; at < 1500; at++)
        fds[at] = opened("can0", 0);
    last = opened("can0", 0);
    sent(fds[0], 0x123);
    CHECK(received(last) == 0x123 && received(fds[1]) == 0x123 && received(fds[1499]) == 0x123);
    for (int at = 0; at < 1500; at++)
        close(fds[at]);
    close(last);
}

int main(int count, char **words)
{
    if (count == 3) {
        sent(atoi(words[2]), 0x7E5);
        return 0;
    }
    if (strcmp(words[1], "names") == 0)
        names();
    else if (strcmp(words[1], "mistakes") == 0)
        mistakes();
    else if (strcmp(words[1], "descriptors") == 0)
        descriptors();
    else if (strcmp(words[1], "exec") == 0)
        across_exec(words[0]);
    else if (strcmp(words[1], "own") == 0)
        own_frames();
    else if (strcmp(words[1], "overflow") == 0)
        overflow();
    else if (strcmp(words[1], "storm") == 0)
        storm();
    else if (strcmp(words[1], "full") == 0)
        full();
    else if (strcmp(words[1], "stamps") == 0)
        stamps();
    else
        thousands();
    puts("done");
    return 0;
}
