/* An ECU in C: it answers 7DF by 100 + its number, and sends 110 + its number after 25 ms of silence.
 *
 * ecu NUMBER WAY COUNT: how it waits (poll, ppoll, select, pselect, epoll, epoll2, timeout, sleep, alarm, timerfd, interval,
 * semaphore, condition, mutex, timer, timer_thread, timer_thread_id, sigwait, barrier) and how often. At the end it prints what its clocks say.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdint.h>
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
#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif

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

/* So long, by a timer that is read; `interval`: one timer for all waits. */
static void by_timer(int interval)
{
    static int timer = -1;
    struct itimerspec set = {{0, interval ? SILENCE_MS * 1000000 : 0}, {0, SILENCE_MS * 1000000}}, left;
    uint64_t times;

    if (timer < 0 || !interval) {
        timer = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
        timerfd_settime(timer, 0, &set, NULL);
    }
    timerfd_gettime(timer, &left);
    if (left.it_value.tv_nsec != SILENCE_MS * 1000000 || read(timer, &times, sizeof times) != sizeof times || times != 1)
        exit(3);
    if (!interval)
        close(timer);
}

/* So long, for what never comes from another thread. */
static void by_lock(const char *way)
{
    static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
    sem_t semaphore;
    struct timespec end;
    int error;

    clock_gettime(CLOCK_REALTIME, &end);
    end.tv_nsec += SILENCE_MS * 1000000;
    if (end.tv_nsec >= 1000000000) {
        end.tv_sec++;
        end.tv_nsec -= 1000000000;
    }
    sem_init(&semaphore, 0, 0);
    pthread_mutex_lock(&mutex);
    if (strcmp(way, "semaphore") == 0)
        error = sem_timedwait(&semaphore, &end) < 0 ? errno : 0;
    else if (strcmp(way, "condition") == 0)
        error = pthread_cond_timedwait(&condition, &mutex, &end);
    else
        error = pthread_mutex_timedlock(&mutex, &end);
    pthread_mutex_unlock(&mutex);
    if (error != ETIMEDOUT)
        exit(4);
}

static sem_t called;

static void call(union sigval value)
{
    if (value.sival_int == 7)
        sem_post(&called);
}

/* So long, by timer_create. */
static void by_posix_timer(const char *way)
{
    struct itimerspec once = {.it_value = {0, SILENCE_MS * 1000000}}, left;
    struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGUSR1, .sigev_value = {.sival_int = 7}};
    timer_t timer;
    sigset_t set;
    siginfo_t found = {0};

    sigemptyset(&set);
    sigaddset(&set, SIGUSR1);
    sigprocmask(strcmp(way, "sigwait") == 0 ? SIG_BLOCK : SIG_UNBLOCK, &set, NULL);
    signal(SIGUSR1, nothing);
    if (strcmp(way, "timer_thread") == 0) {
        sem_init(&called, 0, 0);
        event.sigev_notify = SIGEV_THREAD;
        event.sigev_notify_function = call;
    } else if (strcmp(way, "timer_thread_id") == 0)
        event.sigev_notify = SIGEV_THREAD_ID, event.sigev_notify_thread_id = gettid();
    if (timer_create(CLOCK_MONOTONIC, &event, &timer) < 0)
        exit(8);
    if (timer_settime(timer, 0, &once, NULL) < 0 || timer_gettime(timer, &left) < 0 || left.it_value.tv_nsec > SILENCE_MS * 1000000)
        exit(5);
    if (strcmp(way, "timer_thread") == 0)
        sem_wait(&called);
    else if (strcmp(way, "sigwait") != 0)
        pause();
    else if (sigwaitinfo(&set, &found) != SIGUSR1 || found.si_value.sival_int != 7 || found.si_code != SI_TIMER)
        exit(6);
    if (timer_delete(timer) < 0)
        exit(7);
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
    if (strncmp(way, "epoll", 5) == 0) {
        int epoll = epoll_create1(0);
        epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event);
        int found = way[5] == '2' ? epoll_pwait2(epoll, &event, 1, &span, NULL) : epoll_wait(epoll, &event, 1, SILENCE_MS);
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
    } else if (strcmp(way, "timerfd") == 0 || strcmp(way, "interval") == 0)
        by_timer(way[0] == 'i');
    else if (strcmp(way, "semaphore") == 0 || strcmp(way, "condition") == 0 || strcmp(way, "mutex") == 0)
        by_lock(way);
    else if (strncmp(way, "timer", 5) == 0 || strcmp(way, "sigwait") == 0)
        by_posix_timer(way);
    else if (strcmp(way, "barrier") == 0) {
        pthread_barrier_t barrier;
        pthread_barrier_init(&barrier, NULL, 1);
        pthread_barrier_wait(&barrier);
    } else
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
