/* What the files of libcandrv share. */
#ifndef CANWIRE_CANDRV_H
#define CANWIRE_CANDRV_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "canwire.h"
#include "fileapi.h"

#pragma GCC visibility push(hidden)

/* a call that failed: GetLastError is `code`, and the answer is 0 */
static inline int candrv_fail(DWORD code)
{
    SetLastError(code);
    return 0;
}

/* device.c. A device's handle, and whether this is one: its number at the helper, 0 with GetLastError set. No reference
 * is kept while a call waits, so that CloseHandle from another thread ends the call, as the manual has it. */
HANDLE device_open(LPCSTR name, DWORD access, DWORD share, DWORD creation);
uint32_t device_number(HANDLE handle);
BOOL device_read(uint32_t number, LPVOID buffer, DWORD count, LPDWORD read);
BOOL device_write(uint32_t number, LPCVOID buffer, DWORD count, LPDWORD written);
/* Ask the helper about a device: TRUE for success, or FALSE with GetLastError set. */
BOOL device_call(struct cw_call *call);

/* plain.c: files of Linux' */
extern const struct cw_kind plain_kind;
HANDLE plain_open(LPCSTR name, DWORD access, DWORD creation);
BOOL plain_read(struct cw_object *file, LPVOID buffer, DWORD count, LPDWORD read);
BOOL plain_write(struct cw_object *file, LPCVOID buffer, DWORD count, LPDWORD written);

/* names.c */
int names_narrow(char *into, size_t room, LPCWSTR name); /* UTF-8; 0, or -1: it is too long or no text */

#pragma GCC visibility pop
#endif
