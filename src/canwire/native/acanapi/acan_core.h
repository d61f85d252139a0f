/* What the files of libacan share. ../acan/blocks.py has the same forms in Python. */
#ifndef CANWIRE_ACAN_CORE_H
#define CANWIRE_ACAN_CORE_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "canwire.h"
#include "ACAN.H"

#pragma GCC visibility push(hidden)

struct acan_shown { /* what the driver keeps of a block */
    uint32_t number;
    uint32_t version; /* a later one has a higher number */
    uint16_t status, occupation, read_index, write_index;
    uint8_t rec, tec, alc, ecc;
    uint8_t notified; /* the application is to be told now */
    uint8_t moved;    /* channels have received something */
    uint16_t reserved;
};

struct acan_moved { /* what one of them has received */
    uint8_t channel, length, data[8];
};

struct acan_block { /* one that is registered */
    LPACANTB at;
    uint32_t number;
    uint32_t version;
    uint32_t process; /* it is over once cw_process has changed: its helper has ended */
    HANDLE event;
    struct acan_block *next;
};

/* library.c. Ask the helper: TRUE for success. */
BOOL acan_call(struct cw_call *call);
extern uint32_t acan_helper; /* its process id; 0 before ACAN_Init */

/* blocks.c: under the lock, but for acan_drop_all */
void acan_lock(void);
void acan_unlock(void);
struct acan_block *acan_find(LPACANTB at); /* those that are over are dropped */
struct acan_block *acan_number(uint32_t number);
void acan_keep(struct acan_block *block);
void acan_drop(struct acan_block *block); /* once nobody is telling its application; it is freed */
void acan_drop_all(void);
void acan_show(struct acan_block *block, const struct acan_shown *shown); /* and what channels have received */
/* Between these two nobody drops the block; the lock is given up meanwhile. */
void acan_begin_telling(struct acan_block *block);
void acan_end_telling(void);

/* service.c */
BOOL acan_start_service(void); /* under the lock; TRUE: its thread runs */

#pragma GCC visibility pop
#endif
