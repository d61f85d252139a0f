/* Two CAN_J1939 sockets of a program that preloads nothing: a long message with its addresses and priority. */
#include <linux/can.h>
#include <linux/can/j1939.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#define CHECK(what)                                                                                                    \
    do {                                                                                                               \
        if (!(what)) {                                                                                                 \
            perror(#what);                                                                                             \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

static struct sockaddr_can at(int index, unsigned pgn, unsigned address)
{
    struct sockaddr_can name = {.can_family = AF_CAN, .can_ifindex = index};

    name.can_addr.j1939.pgn = pgn;
    name.can_addr.j1939.addr = address;
    return name;
}

int main(void)
{
    int one = socket(PF_CAN, SOCK_DGRAM, CAN_J1939), other = socket(PF_CAN, SOCK_DGRAM, CAN_J1939), seen = 0;
    struct ifreq about = {.ifr_name = "can0"};
    char data[100] = "long", got[200], control[200];
    struct sockaddr_can from;
    struct iovec part = {got, sizeof got};
    struct msghdr message = {.msg_name = &from, .msg_namelen = sizeof from, .msg_iov = &part, .msg_iovlen = 1};

    message.msg_control = control, message.msg_controllen = sizeof control;
    CHECK(ioctl(one, SIOCGIFINDEX, &about) == 0);
    struct sockaddr_can here = at(about.ifr_ifindex, J1939_NO_PGN, 0x20), there = at(about.ifr_ifindex, J1939_NO_PGN, 0x30);
    CHECK(bind(one, (struct sockaddr *)&here, sizeof here) == 0 && bind(other, (struct sockaddr *)&there, sizeof there) == 0);
    there = at(about.ifr_ifindex, 0x12300, 0x30);
    CHECK(sendto(one, data, sizeof data, 0, (struct sockaddr *)&there, sizeof there) == sizeof data);
    CHECK(recvmsg(other, &message, 0) == sizeof data && memcmp(got, data, sizeof data) == 0);
    CHECK(from.can_addr.j1939.addr == 0x20 && from.can_addr.j1939.pgn == 0x12300);
    for (struct cmsghdr *part_of = CMSG_FIRSTHDR(&message); part_of != NULL; part_of = CMSG_NXTHDR(&message, part_of))
        if (part_of->cmsg_level == SOL_CAN_J1939)
            seen = seen * 256 + *CMSG_DATA(part_of);
    printf("%x\n", seen);
    return 0;
}
