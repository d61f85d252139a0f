/* The two rings of a CAN_RAW socket, in memory that its server and every program that has the socket share.
 *
 * A frame costs no system call: the server writes rows into `received`, the program into `sent`. The socket pair only
 * tells that there is something. It holds one byte, a token, while `received` is not empty, so that poll, select and epoll
 * are right; the other way a byte, a kick, wakes the server when it waits. The program's side has a lock, because any
 * number of threads and processes may have the socket; the server is one thread.
 *
 * The token is given and taken under the lock, so that whoever is told that there is something finds it. The server never
 * waits for the lock: where it is taken, who has it kicks once it is free, and the server looks again.
 */
#ifndef CANWIRE_RING_H
#define CANWIRE_RING_H

#include "shim.h"

#include <pthread.h>

#define RECEIVED_ROWS 2048u
#define SENT_ROWS 1024u
#define RECEIVED_SIZE 96u
#define SENT_SIZE 80u

struct ring {
    pthread_mutex_t lock; /* of the program's side; robust */
    uint64_t head __attribute__((aligned(64)));
    uint64_t tail __attribute__((aligned(64)));
    uint32_t told __attribute__((aligned(64))); /* received: a token is in the socket */
    uint32_t unsettled;                         /* received: the server could not look whether one is needed */
    uint32_t wanted;                            /* received: the server wants room; sent: it waits for frames */
    uint32_t waiting;                           /* sent: somebody waits for room ... */
    uint32_t turn;                              /* ... on this word */
};

struct block {
    struct ring received;
    struct ring sent;
    char received_rows[RECEIVED_ROWS * RECEIVED_SIZE];
    char sent_rows[SENT_ROWS * SENT_SIZE];
};

/* the program's side, under the ring's lock: 0, or an errno (EDEADLK in a signal handler of who has it) */
int lock_ring(struct ring *ring);
void unlock_sent(struct block *block);
void unlock_received(struct block *block, int fd);
const char *oldest(struct block *block); /* NULL: nothing has come */
void release_oldest(struct block *block, int fd);
char *next_free(struct block *block); /* NULL: full */
int commit(struct block *block, int fd);
void wait_for_turn(struct block *block, int milliseconds);

#endif
