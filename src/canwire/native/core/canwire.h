/* The seam of canwire's native side: what an interface in C or C++ is built on.
 *
 * Frames go through rings in memory that the hub has, too; nothing of Python is in this process. All that is asked
 * seldom goes to a helper process, which holds the connection to the hub and uses canwire's Python interface of the
 * same name, so that rules and error codes exist once. The helper is started by the first call, and ends with this
 * process, however that ends. ../helper/ is its other end; docs/architecture.md tells how an interface is built on this.
 */
#ifndef CANWIRE_NATIVE_H
#define CANWIRE_NATIVE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define CW_METHOD_SIZE 40
#define CW_MOST_DESCRIPTORS 8
#define CW_MOST_DATA 65536 /* bytes of one call, and of its answer */
#define CW_FOR_EVER (-1)

/* calls: helper.c */

struct cw_call {
    const char *method; /* "vci.open_socket": the interface, and what its answers/ calls it */
    uint32_t object;    /* of the helper's, 0 for none */
    const void *in;
    size_t in_size;
    void *out; /* room for the answer's data */
    size_t out_size;
    /* the answer */
    int32_t result;    /* the interface's own code, 0 for success */
    uint32_t value;    /* a number, for instance that of a new object */
    size_t out_length; /* of the data: as long as it was, even where the room was smaller */
    int descriptors[CW_MOST_DESCRIPTORS];
    int descriptor_count;
};

/* Ask and wait for the answer; any thread may. 0, or -1 with errno when nobody answers: the helper could not be started
 * or has ended. Descriptors are the caller's to close; data beyond the room is lost. */
int cw_call(struct cw_call *call);
void cw_close_descriptors(struct cw_call *call);

/* Another number in each fork, and after a helper's end: what was opened under another one is over. */
uint32_t cw_process(void);

#ifndef _WIN32
/* One time with others, where CANWIRE_TIMED is 1: timed.c. Waits for handles and rings take part by themselves. */
int cw_timed(void);
int64_t cw_hub_now(void);          /* nanoseconds; -1: this thread takes no part, the clock's time counts */
int cw_sleep(int64_t milliseconds); /* 1: done; 0: likewise */
uint32_t cw_expect_thread(void);   /* before one is started: it takes part from then on, in the order of these calls */
void cw_thread_begins(uint32_t expected, int succeeded); /* in that thread; or in who could not start it */
void cw_changed(void);             /* something that other threads may wait for: they look when this one waits */
int cw_others_run(void);           /* a lock is not free: others have their turns; 0: likewise */
#else /* nobody does on Windows */
#define cw_timed() 0
#define cw_hub_now() (-1)
#define cw_changed() ((void)0)
#endif

/* rings: ring.c. One thread at a time uses an end, as in the hub; any number may wait on it. */

struct cw_place { /* what the helper answers for a ring, with descriptors: memory, own, and peer if there is one */
    uint64_t begin;
    uint32_t capacity;
    uint32_t record_size;
    uint32_t reads;
    uint32_t state; /* its word on the page of states */
};

struct cw_event;

struct cw_ring {
    uint64_t *words;
    unsigned char *records;
    uint64_t mask;
    uint64_t seen;      /* the other side's counter when this side last looked */
    uint64_t threshold; /* records to read, or room for records, at which this side is signalled; 1..capacity */
    void *mapping;
    size_t mapping_size;
    uint32_t capacity;
    uint32_t record_size;
    uint32_t reads;
    uint32_t state;
    uint32_t process;
    int own;           /* readable once the other side has signalled */
    int peer;          /* -1: it wants no signals */
    struct cw_event *event; /* what is signalled with it; NULL: nothing */
    struct cw_ring *next, **before;
};

int cw_ring_open(struct cw_ring *ring, const struct cw_place *place, struct cw_call *with); /* takes the descriptors */
void cw_ring_close(struct cw_ring *ring);
int cw_ring_over(const struct cw_ring *ring); /* its lease, its hub or its helper is gone, or this is a fork */
uint32_t cw_ring_fill(struct cw_ring *ring);
uint32_t cw_ring_free(struct cw_ring *ring);
/* The reading end: the oldest records that lie in one piece, and giving them back. */
const void *cw_ring_acquire(struct cw_ring *ring, uint32_t *count);
void cw_ring_release(struct cw_ring *ring, uint32_t count);
/* The writing end: free records that lie in one piece, and handing them on. */
void *cw_ring_acquire_free(struct cw_ring *ring, uint32_t *count);
void cw_ring_commit(struct cw_ring *ring, uint32_t count);
void cw_ring_set_threshold(struct cw_ring *ring, uint32_t threshold);
void cw_ring_touched(struct cw_ring *ring); /* after reading and writing: an event waits for the next occasion */
/* 1: the threshold is met; 0: not in so many milliseconds (CW_FOR_EVER); -1: over, and nothing is left to read. */
int cw_ring_wait(struct cw_ring *ring, int64_t milliseconds);

/* handles of one process, as Windows has them: handles.c. A kind is the address of a cw_kind. */

typedef void *cw_handle;

struct cw_object;
struct cw_kind {
    const char *name;
    void (*destroy)(struct cw_object *object);                      /* the last reference is gone */
    int (*take)(struct cw_object *object);                          /* to wait for it: signalled? and take the signal */
    int (*descriptor)(struct cw_object *object);                    /* readable when `take` may succeed */
};

struct cw_object { /* the first member of what a handle stands for */
    const struct cw_kind *kind;
    uint32_t references;
};

cw_handle cw_handle_new(struct cw_object *object);                             /* NULL: no memory */
struct cw_object *cw_handle_get(cw_handle handle, const struct cw_kind *kind); /* NULL kind: any; a reference more */
void cw_object_release(struct cw_object *object);
int cw_handle_close(cw_handle handle); /* 0, or -1: there is no such handle */

/* events: events.c. Rings and the list of boards signal them. */

extern const struct cw_kind cw_event_kind;
struct cw_event *cw_event_new(int manual_reset, int signalled);
void cw_event_set(struct cw_event *event);
void cw_event_reset(struct cw_event *event);
/* The event of a handle of the program's, one reference more; NULL: it is none. */
struct cw_event *cw_event_of(cw_handle handle);
void cw_event_release(struct cw_event *event);
/* Have a ring signal this event, in place of one before; NULL: none. The ring keeps a reference. 0, or -1: no memory. */
int cw_event_assign(struct cw_event *event, struct cw_ring *ring);
/* Likewise a descriptor, which is only read and the event's from now on; cw_event_forget ends that, and closes it. */
int cw_event_watch(struct cw_event *event, int descriptor);
void cw_event_forget(struct cw_event *event, int descriptor);

#define CW_WAIT_TIMEOUT 258
#define CW_WAIT_FAILED (-1)
/* Index of the object that was signalled, 0 where all of them are, CW_WAIT_TIMEOUT, or CW_WAIT_FAILED for bad handles. */
int cw_wait(cw_handle const *handles, uint32_t count, int all, int64_t milliseconds);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
