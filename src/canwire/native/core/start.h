#ifndef CANWIRE_NATIVE_START_H
#define CANWIRE_NATIVE_START_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#pragma GCC visibility push(hidden)
/* warm.c: the name of the warm helper that this program could have, "" for none; words are its process and its name */
#define CW_WARM_NAME 80

void cw_warm_name(char name[CW_WARM_NAME], const char *python, const char *library, char *const settings[]);
int cw_warm_start(const char *name, int channel, char *const words[], char *const settings[]); /* 0, or -1: there is none */
int cw_start_helper(int channel); /* its end of a socket pair, which stays the caller's; 0, or -1 with errno */
#pragma GCC visibility pop
#endif
