#ifndef CANWIRE_NATIVE_START_H
#define CANWIRE_NATIVE_START_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#pragma GCC visibility push(hidden)
int cw_start_helper(int channel); /* its end of a socket pair, which stays the caller's; 0, or -1 with errno */
#pragma GCC visibility pop
#endif
