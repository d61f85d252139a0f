/* What the files of Windows' functions share. */
#ifndef CANWIRE_WINDOWS_CORE_H
#define CANWIRE_WINDOWS_CORE_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "canwire.h"
#include "windows.h"

#pragma GCC visibility push(hidden)
int cw_fail(DWORD code); /* sets GetLastError, and is 0 */
HANDLE cw_handle_or_fail(struct cw_object *object); /* takes the reference; NULL: no memory, GetLastError says so */
#pragma GCC visibility pop
#endif
