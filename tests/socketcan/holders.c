/* Threads that sleep while they hold a lock that another one waits for, and children that a parent waits for.
 *
 * holders: it prints how long each of these waits took, in ms of the hub's. holders sleep: it sleeps for 30 ms.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER, checked = PTHREAD_ERRORCHECK_MUTEX_INITIALIZER_NP;
static pthread_rwlock_t lock = PTHREAD_RWLOCK_INITIALIZER;
static double began_ms;

static double at_ms(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1e3 + now.tv_nsec / 1e6;
}

static void tell(const char *what)
{
    printf("%s %.0f\n", what, at_ms() - began_ms);
    fflush(stdout);
    began_ms = at_ms();
}

static void *hold(void *what)
{
    if (what == &mutex)
        pthread_mutex_lock(&mutex);
    else
        pthread_rwlock_wrlock(&lock);
    usleep(20000);
    return (void *)(intptr_t)(what == &mutex ? pthread_mutex_unlock(&mutex) : pthread_rwlock_unlock(&lock));
}

static void *read_it(void *nothing)
{
    pthread_rwlock_rdlock(&lock);
    usleep(20000);
    pthread_rwlock_unlock(&lock);
    return nothing;
}

static pthread_t begun(void *(*routine)(void *), void *argument)
{
    pthread_t thread;

    pthread_create(&thread, NULL, routine, argument);
    usleep(1000);
    began_ms = at_ms() - 1;
    return thread;
}

static void locks(void)
{
    pthread_t thread = begun(hold, &mutex);
    pthread_mutex_lock(&mutex);
    tell("mutex");
    pthread_mutex_unlock(&mutex);
    pthread_join(thread, NULL);

    thread = begun(read_it, NULL);
    pthread_rwlock_wrlock(&lock);
    tell("writer");
    pthread_rwlock_unlock(&lock);
    pthread_join(thread, NULL);

    thread = begun(hold, &lock);
    pthread_rwlock_rdlock(&lock);
    tell("reader");
    pthread_rwlock_unlock(&lock);
    pthread_join(thread, NULL);

    pthread_mutex_lock(&checked);
    usleep(pthread_mutex_lock(&checked) == EDEADLK ? 35000 : 0);
    tell("already its own");
}

static pid_t slept(void)
{
    pid_t child = fork();

    if (child == 0) {
        usleep(30000);
        _exit(7);
    }
    return child;
}

static void children(const char *own)
{
    siginfo_t found = {0};
    int status = 0;
    struct timespec used;
    pid_t child = slept();

    if (waitpid(child, &status, 0) == child && WEXITSTATUS(status) == 7)
        tell("child that sleeps");
    child = slept();
    if (wait(&status) == child && WEXITSTATUS(status) == 7)
        tell("any child");
    child = slept();
    if (waitid(P_PID, (id_t)child, &found, WEXITED) == 0 && found.si_pid == child && found.si_status == 7)
        tell("waitid");
    child = fork();
    if (child == 0)
        execl("/bin/sh", "sh", "-c", "\"$0\" sleep; exit 0", own, NULL);
    if (waitpid(child, &status, 0) == child && status == 0)
        tell("shell whose command sleeps");
    child = fork();
    if (child == 0) {
        do
            clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
        while (used.tv_sec == 0 && used.tv_nsec < 5000000);
        _exit(0);
    }
    if (waitpid(child, &status, 0) == child)
        tell("child that computes");
    if (wait(&status) < 0 && errno == ECHILD)
        printf("none left\n");
}

int main(int count, char **words)
{
    if (count == 2 && strcmp(words[1], "sleep") == 0)
        return usleep(30000);
    locks();
    children(words[0]);
    return 0;
}
