/* What the files of Windows' side share: a helper over TCP on this machine, and what is said on its first connection. */
#ifndef CANWIRE_WIN32_H
#define CANWIRE_WIN32_H
#define WIN32_LEAN_AND_MEAN
#define _WIN32_WINNT 0x0A00
#include <winsock2.h>
#include <windows.h>

#include "core.h"

#define TOKEN_SIZE 32
#define NAME_SIZE 64           /* of what is passed on with an answer (../helper/far.py) */
#define SIGNAL 0x40000000      /* a descriptor with this bit is the number of a signal, else it is a handle */

enum aside { SIGNALLED = 1, OVER = 2, RING = 3, HEAR = 4, FORGET = 5 }; /* ../helper/far.py */

/* start.c: the helper's first connection, and the port for more; 0, or -1 with errno */
struct far_helper {
    SOCKET lifeline;
    unsigned char token[TOKEN_SIZE];
    uint16_t port;
};
int far_start(struct far_helper *helper);

/* sockets.c */
int far_sockets_ready(void); /* 0, or -1 with errno */
SOCKET far_socket(void); /* that no child inherits; INVALID_SOCKET with errno */
SOCKET far_dial(uint16_t port);
int far_send(SOCKET socket, const void *data, size_t size); /* all of it; 0, or -1 */
int far_receive(SOCKET socket, void *into, size_t size);

/* signals.c */
int far_listen(SOCKET lifeline); /* has a thread hear what is signalled there; 0, or -1 with errno */
void far_say(enum aside what, int number);
void far_wait_heard(uint32_t said, uint32_t of); /* until so much was heard of the helper, or that process of it is over */
void far_signal_own(struct cw_ring *ring); /* sets its event, which is set anew at the next occasion */
#endif
