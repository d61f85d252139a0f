/* Four threads hand frames to the one that sends them; each of them sleeps, and a semaphore counts what was sent.
 *
 * At the end it prints how many were sent, and when.
 */
#define _GNU_SOURCE
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define WORKERS 4
#define FRAMES 10

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static sem_t sent;
static struct can_frame queue[WORKERS * FRAMES];
static int first, behind;

static void *work(void *number)
{
    for (int at = 0; at < FRAMES; at++) {
        usleep(5000 * (1 + (unsigned)(uintptr_t)number));
        pthread_mutex_lock(&mutex);
        queue[behind++] = (struct can_frame){.can_id = 0x100u + (unsigned)(uintptr_t)number, .can_dlc = 1, .data = {(uint8_t)at}};
        pthread_cond_signal(&changed);
        pthread_mutex_unlock(&mutex);
    }
    return number;
}

static void *carry(void *nothing)
{
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can0")};
    int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);

    (void)nothing;
    if (fd < 0 || bind(fd, (struct sockaddr *)&address, sizeof address) < 0)
        return "can0";
    for (int at = 0; at < WORKERS * FRAMES; at++) {
        pthread_mutex_lock(&mutex);
        while (first == behind)
            pthread_cond_wait(&changed, &mutex);
        struct can_frame frame = queue[first++];
        pthread_mutex_unlock(&mutex);
        if (write(fd, &frame, sizeof frame) != sizeof frame)
            return "write";
        sem_post(&sent);
    }
    close(fd);
    return NULL;
}

int main(void)
{
    pthread_t workers[WORKERS], carrier;
    struct timespec now;
    void *result;
    int count = 0;

    sem_init(&sent, 0, 0);
    pthread_create(&carrier, NULL, carry, NULL);
    for (uintptr_t at = 0; at < WORKERS; at++)
        pthread_create(&workers[at], NULL, work, (void *)at);
    for (; count < WORKERS * FRAMES; count++)
        sem_wait(&sent);
    for (uintptr_t at = 0; at < WORKERS; at++) {
        pthread_join(workers[at], &result);
        if (result != (void *)at)
            return 1;
    }
    pthread_join(carrier, &result);
    if (result != NULL)
        return 2;
    clock_gettime(CLOCK_MONOTONIC, &now);
    printf("%d sent, %lld.%09ld\n", count, (long long)now.tv_sec, now.tv_nsec);
    return 0;
}
