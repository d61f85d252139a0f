/* Threads by Microsoft's C library. */
#ifndef CANWIRE_PROCESS_H
#define CANWIRE_PROCESS_H
#include <windows.h>
#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)
/* (uintptr_t)-1: no thread; the handle closes itself when the thread ends */
uintptr_t _beginthread(void (*start)(void *), unsigned stack, void *argument);
/* 0: no thread; the handle is the caller's to close */
uintptr_t _beginthreadex(void *rights, unsigned stack, unsigned (*start)(void *), void *argument, unsigned flags,
                         unsigned *number);
void _endthread(void);
void _endthreadex(unsigned code);
#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#define _getpid getpid
#endif
