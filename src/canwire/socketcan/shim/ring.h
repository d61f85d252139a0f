/* What stands beside the messages of a CAN socket, in memory that its server and every program that has it share.
 *
 * A program's end of the pair is a SOCK_SEQPACKET whose messages are frames (or a broadcast manager's, or PDUs), so that
 * poll, epoll's edges, SIGIO, fwrite, splice, io_uring and plain system calls find what the kernel gives them. What else a
 * message has (its time, interface, flags, losses, or an error instead of data) is a row of `received`. Who takes a message
 * by a call of the library takes the row that has the same bytes, and passes over rows of messages that were taken in other
 * ways. The server never waits: rows that nobody has taken are overwritten, long after their messages are gone.
 *
 * A CAN_RAW frame that the library sends goes through `sent` without a system call; a message of one byte, a kick, wakes
 * the server when it waits. Messages that programs send in other ways arrive as they are. The program's side has a lock,
 * because any number of threads and processes may have the socket; the server is one thread.
 */
#ifndef CANWIRE_RING_H
#define CANWIRE_RING_H

#include "shim.h"

#include <pthread.h>

#define RECEIVED_ROWS 2048u
#define SENT_ROWS 1024u
#define RECEIVED_SIZE 96u
#define SENT_SIZE 80u
#define RECEIVED_PREFIX (RECEIVED_SIZE - 24u) /* bytes of a message that its row has */

struct ring {
    pthread_mutex_t lock; /* of the program's side; robust */
    uint64_t head __attribute__((aligned(64)));
    uint64_t tail __attribute__((aligned(64)));
    uint32_t wanted __attribute__((aligned(64))); /* sent: the server waits for frames */
    uint32_t waiting;                             /* sent: somebody waits for room ... */
    uint32_t turn;                                /* ... on this word */
};

struct block {
    struct ring received;
    struct ring sent;
    char received_rows[RECEIVED_ROWS * RECEIVED_SIZE];
    char sent_rows[SENT_ROWS * SENT_SIZE];
    struct about abouts[RECEIVED_ROWS]; /* CAN_J1939: beside each row */
};

/* the program's side, under the ring's lock: 0, or an errno (EDEADLK in a signal handler of who has it) */
int lock_ring(struct ring *ring);
void unlock_ring(struct ring *ring);
/* The row of a message of so many bytes that begins with these; 0: there is none */
int take_row(struct block *block, const char *data, size_t length, int peeks, struct received *header,
             struct about *about);
char *next_free(struct block *block); /* NULL: full */
int commit(struct block *block, int fd);
void wait_for_turn(struct block *block, int milliseconds);

#endif
