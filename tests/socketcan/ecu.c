/* An ECU in C: it answers 7DF by 100 + its number, and sends 110 + its number after 25 ms of silence.
 *
 * ecu NUMBER WAY COUNT: how it waits (poll, ppoll, select, pselect, epoll, timeout, sleep, alarm, timerfd) and how often. At the end it
 * prints what its clocks say.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#define SILENCE_MS 25

static int opened(void)
{
    int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can0")};
    struct can_filter request = {0x7DF, CAN_SFF_MASK};

    if (fd < 0 || bind(fd, (struct sockaddr *)&address, sizeof address) < 0 ||
        setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &request, sizeof request) < 0) {
        perror("can0");
        exit(1);
    }
    return fd;
}

static void nothing(int number)
{
    (void)number;
}

/* Whether there is something to read. */
static int waited(int fd, const char *way)
{
    struct timespec span = {0, SILENCE_MS * 1000000};
    struct timeval limit = {0, SILENCE_MS * 1000};
    struct pollfd one = {fd, POLLIN, 0};
    struct epoll_event event = {.events = EPOLLIN};
    struct can_frame frame;
    fd_set set;

    FD_ZERO(&set);
    FD_SET(fd, &set);
    if (strcmp(way, "poll") == 0)
        return poll(&one, 1, SILENCE_MS);
    if (strcmp(way, "ppoll") == 0)
        return ppoll(&one, 1, &span, NULL);
    if (strcmp(way, "select") == 0)
        return select(fd + 1, &set, NULL, NULL, &limit);
    if (strcmp(way, "pselect") == 0)
        return pselect(fd + 1, &set, NULL, NULL, &span, NULL);
    if (strcmp(way, "epoll") == 0) {
        int epoll = epoll_create1(0);
        epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event);
        int found = epoll_wait(epoll, &event, 1, SILENCE_MS);
        close(epoll);
        return found;
    }
    if (strcmp(way, "timeout") == 0) {
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        return recv(fd, &frame, sizeof frame, MSG_PEEK) > 0;
    }
    if (strcmp(way, "alarm") == 0) {
        struct itimerval once = {.it_value = limit};
        signal(SIGALRM, nothing);
        setitimer(ITIMER_REAL, &once, NULL);
        pause();
    } else if (strcmp(way, "timerfd") == 0)
        close(timerfd_create(CLOCK_MONOTONIC, 0));
    else
        clock_nanosleep(CLOCK_MONOTONIC, 0, &span, NULL);
    return poll(&one, 1, 0);
}

int main(int count, char **words)
{
    int fd = opened(), number = atoi(words[1]), answered = 0;
    struct timespec monotonic, real;
    struct timeval day;

    if (count != 4)
        return 2;
    for (int at = 0; at < atoi(words[3]); at++) {
        struct can_frame frame = {0};
        if (waited(fd, words[2]) > 0) {
            read(fd, &frame, sizeof frame);
            frame.can_id = 0x100u + (unsigned)number;
            answered++;
        } else {
            frame.can_id = 0x110u + (unsigned)number;
            frame.can_dlc = 1;
            frame.data[0] = (unsigned char)at;
        }
        if (write(fd, &frame, sizeof frame) != sizeof frame)
            return 1;
    }
    clock_gettime(CLOCK_MONOTONIC, &monotonic);
    clock_gettime(CLOCK_REALTIME, &real);
    gettimeofday(&day, NULL);
    printf("%d answered, %lld.%09ld %lld.%09ld %lld.%06ld %lld\n", answered, (long long)monotonic.tv_sec,
           monotonic.tv_nsec, (long long)real.tv_sec, real.tv_nsec, (long long)day.tv_sec, (long)day.tv_usec,
           (long long)time(NULL));
    return 0;
}
