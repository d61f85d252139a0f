/* Children that a program forks: one computes before its first wait, one reads a pipe, one runs another program.
 *
 * It prints how long after the fork the first of them was heard of, in ms of the hub's.
 */
#define _GNU_SOURCE
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static double at_ms(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1e3 + now.tv_nsec / 1e6;
}

static int made(void)
{
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can0")};
    int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);

    return fd < 0 || bind(fd, (struct sockaddr *)&address, sizeof address) < 0 ? -1 : fd;
}

static void compute(void) /* processor time is the computer's own */
{
    struct timespec used;

    do
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    while (used.tv_sec == 0 && used.tv_nsec < 50000000);
}

int main(void)
{
    struct can_frame frame = {.can_id = 0x123};
    int fd = made(), pipes[2];
    char byte;

    if (fd < 0 || pipe(pipes) < 0)
        return 1;
    struct timeval patience = {.tv_sec = 1};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    double begin = at_ms();
    pid_t child = fork();
    if (child == 0) {
        compute();
        usleep(5000);
        _exit(write(made(), &frame, sizeof frame) != sizeof frame);
    }
    if (read(fd, &frame, sizeof frame) != sizeof frame)
        return 2;
    printf("computed %.0f\n", at_ms() - begin);
    waitpid(child, NULL, 0);

    child = fork();
    if (child == 0)
        _exit(read(pipes[0], &byte, 1) != 1 || write(made(), &frame, sizeof frame) != sizeof frame);
    usleep(10000);
    patience.tv_sec = 0; /* it takes part again when it opens its socket: by the computer's clock, after any time of the hub's */
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (write(pipes[1], "", 1) != 1 || read(fd, &frame, sizeof frame) != sizeof frame)
        return 3;
    printf("read\n");
    waitpid(child, NULL, 0);

    fflush(stdout);
    child = fork();
    if (child == 0)
        execlp("cat", "cat", NULL);
    usleep(10000);
    waitpid(child, NULL, 0);
    printf("ran\n");
    return 0;
}
