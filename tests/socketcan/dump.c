/* candump's own calls, for programs that preload nothing: one frame with its interface and time, and one that answers. */
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#define CHECK(what)                                                                                                    \
    do {                                                                                                               \
        if (!(what)) {                                                                                                 \
            perror(#what);                                                                                             \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

int main(void)
{
    int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW), on = 1;
    struct ifreq about = {.ifr_name = "can0"};
    struct can_filter filter = {0x123, CAN_SFF_MASK};
    struct sockaddr_can address = {.can_family = AF_CAN}, from;
    struct can_frame frame;
    struct iovec part = {&frame, sizeof frame};
    char control[200];
    struct msghdr message = {.msg_name = &from, .msg_namelen = sizeof from, .msg_iov = &part, .msg_iovlen = 1};
    message.msg_control = control, message.msg_controllen = sizeof control;
    socklen_t length = sizeof from;
    unsigned stamped = 0;

    CHECK(fd >= 0 && ioctl(fd, SIOCGIFINDEX, &about) == 0);
    address.can_ifindex = about.ifr_ifindex;
    CHECK(setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter) == 0);
    CHECK(setsockopt(fd, SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on) == 0);
    CHECK(bind(fd, (struct sockaddr *)&address, sizeof address) == 0);
    CHECK(getsockname(fd, (struct sockaddr *)&from, &length) == 0 && from.can_ifindex == address.can_ifindex);
    CHECK(write(fd, &(struct can_frame){.can_id = 0x100, .can_dlc = 1}, sizeof frame) == sizeof frame);
    CHECK(recvmsg(fd, &message, 0) == sizeof frame);
    for (struct cmsghdr *at = CMSG_FIRSTHDR(&message); at != NULL; at = CMSG_NXTHDR(&message, at))
        stamped += at->cmsg_type == SO_TIMESTAMP && ((struct timeval *)CMSG_DATA(at))->tv_usec > 0;
    about = (struct ifreq){.ifr_ifindex = from.can_ifindex};
    CHECK(ioctl(fd, SIOCGIFNAME, &about) == 0);
    printf("%s %X [%d] %u\n", about.ifr_name, frame.can_id, frame.can_dlc, stamped);
    frame.can_id = 0x101;
    CHECK(sendto(fd, &frame, sizeof frame, 0, (struct sockaddr *)&address, sizeof address) == sizeof frame);
    CHECK(read(fd, &frame, sizeof frame) == sizeof frame && frame.can_id == 0x123);
    return 0;
}
