/* What the files of the shim share: the layout of the table in shared memory, and who calls whom.
 *
 * The shim is preloaded into programs that `canwire run` starts. It keeps nothing of its own: whether a descriptor is one
 * of ours is asked of the kernel each time (our end of the pair is bound to a name that begins with the table's prefix
 * and ends with the number of its slot), so that dup, fork, exec and close need no help. ../table.py writes this table.
 */
#ifndef CANWIRE_SHIM_H
#define CANWIRE_SHIM_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <poll.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/uio.h>

#define EXPORT __attribute__((visibility("default")))

#define TABLE_MAGIC 0x31304e4143574e43ull /* "CNWCAN01" */
#define PREFIX_SIZE 16
#define MOST_INTERFACES 16384
#define FIRST_INDEX 1001 /* of the first place in the table; ../table.py counts on from there */
#define MOST_SLOTS 4096

#define INTERFACE_UP 1u
#define INTERFACE_STUCK 2u /* its queue is full and nothing goes out */
#define INTERFACE_GONE 4u
#define INTERFACE_OFF 8u /* bus-off: up, and not running */

struct interface {
    char name[16];
    int32_t index;
    int32_t mtu;
    uint32_t flags;
    uint32_t reserved[9];
};

struct slot { /* one socket; what stands here the program's calls change without asking the server */
    int32_t protocol;
    int32_t type;
    int32_t interface;        /* bound to this index, 0: to all, or not bound */
    uint32_t bound;
    uint32_t fd_frames;
    uint32_t receive_buffer;  /* bytes, as SO_RCVBUF shows them */
    uint32_t stamp;           /* SO_TIMESTAMP or SO_TIMESTAMPNS, old or new: the cmsg's type; 0: none */
    uint32_t stamping;        /* SO_TIMESTAMPING, old or new */
    uint32_t stamping_flags;
    uint32_t counts_drops;    /* SO_RXQ_OVFL */
    uint64_t last_stamp_ns;   /* SIOCGSTAMP */
    uint32_t error;           /* SO_ERROR */
    uint32_t receives;        /* CAN_ISOTP: the two identifiers */
    uint32_t sends;
    uint32_t receive_timeout_us; /* SO_RCVTIMEO as it was set: the kernel rounds it to its ticks */
    uint32_t broadcasts;         /* CAN_J1939: SO_BROADCAST */
    uint32_t watched;            /* poll has more to tell of it than the kernel: SO_J1939_ERRQUEUE, an error, a mapped ring */
    uint32_t queued_errors;      /* how much its error queue has */
    uint32_t ring_at; /* a mapped ring: one byte after where the state of what came last begins, 0: nothing came; packets.c */
};

struct table {
    uint64_t magic;
    uint32_t interfaces;
    uint32_t slots; /* in use */
    char prefix[PREFIX_SIZE];
    uint64_t now_ns;   /* where programs keep one time: the hub's ... */
    uint64_t epoch_ns; /* ... and what makes it the wall's */
    uint32_t timed;
    uint32_t watched;  /* how many sockets are, see struct slot */
    uint32_t netlink_port; /* of the server's netlink socket; 0: it has none */
    uint32_t link_sockets; /* programs have opened some */
    struct interface interface[MOST_INTERFACES];
    struct slot slot[MOST_SLOTS];
};

struct received { /* stands before what the server sends */
    uint64_t stamp_ns;
    uint32_t drops;
    int32_t interface;
    uint16_t flags;
    uint16_t error; /* an errno: there is no frame, the call fails with it */
    uint32_t length;
};

struct about { /* a CAN_J1939 message's own */
    uint64_t source_name;
    uint64_t destination_name;
    uint32_t pgn;
    uint8_t source;
    uint8_t destination;
    uint8_t priority;
    uint8_t rest; /* its number, where RECEIVED_HAS_REST */
};

struct sent { /* stands before what the program sends */
    int32_t interface;
    uint32_t length;
};

#define RECEIVED_LOCAL 1u /* MSG_DONTROUTE */
#define RECEIVED_OWN 2u   /* MSG_CONFIRM */
#define RECEIVED_HAS_REST 8u  /* of CAN_J1939: more bytes are at the server, see TAKE_REST */
#define RECEIVED_OUTGOING 4u /* AF_PACKET: it is on its way to the line */

/* requests to the server; each is one message on a connection of its own */
enum operation {
    OPEN_SOCKET = 1, /* a = type, b = protocol; the reply brings a descriptor */
    BIND,            /* data = struct sockaddr_can */
    CONNECT,
    SET_OPTION,      /* a = level, b = name, data = value */
    GET_OPTION,      /* a = level, b = name; the reply's data is the value */
    SEND_BCM,        /* a = interface or 0, data = struct bcm_msg_head and frames */
    SEND_ISOTP,      /* a = flags, data = PDU */
    NOTE,            /* a = enum note, data = text */
    AWAIT_TURN,      /* slot = a child whose end is waited for, -1: any, 0: none; a = AGAIN, SLEEPS, b = SA_RESTART,
                        data = int64_t until, ns; the answer is the turn, and the number of the signal that came with it */
    LEAVE_TIME,      /* this thread takes part no longer */
    SET_TIMER,       /* data = int64_t until SIGALRM, and then again each time, ns; the reply's data likewise: before */
    OPEN_TIMER,      /* a = TFD_NONBLOCK, b = a signal instead or 0, slot = the thread that gets it or 0, data = its int64_t
                        value; the reply is its number and brings a descriptor */
    TAKE_PART,       /* this thread, which has just begun, runs; a = the thread that forked it, if that one takes part */
    SET_TIMER_FD,    /* slot = its number, a = set it (else look), data and reply as of SET_TIMER */
    SEND_J1939,      /* a = size of an address that comes first, and MORE_FOLLOWS; data = address and bytes */
    NAME,            /* CAN_J1939: a = the peer's; the reply's data is a struct sockaddr_can */
    TAKE_ERROR,      /* the error queue's oldest: size of its data (uint32_t), data, control messages */
    PLACE_FILES,     /* a = enum folder, data = an interface, or nothing: have the files of the folder in the directory */
    MAP_RING,        /* AF_PACKET: the reply brings the descriptor of the memory, and its size */
    TAKE_REST = 21,  /* CAN_J1939: a = number of a rest; the reply is its size and brings a descriptor of memory */
    SUBSCRIBE = 20,       /* a = the port of a netlink socket, b = a group of rtnetlink's, below 0: no longer */
    SUPERVISE = 100, /* a = the descriptor of seccomp's notifications in the process that asks */
};

enum folder { NET_FOLDER, PROC_FOLDER };
enum note { NOTE_PROTOCOL = 1, NOTE_NETLINK, NOTE_EXEC, NOTE_CLOCK, NOTE_NOT_SUPERVISED };

struct request {
    uint32_t operation;
    int32_t slot;
    int32_t a;
    int32_t b;
    int32_t thread; /* set by `ask` */
};

#define MORE_FOLLOWS 0x100
#define AGAIN 1  /* this is no new wait */
#define SLEEPS 2 /* until then, whatever happens */

#define PACKET 256 /* the protocol of a slot: AF_PACKET's */

/* real.c */
#define REAL(name)                                                                                                     \
    ({                                                                                                                 \
        static __typeof__(&name) found;                                                                                \
        __typeof__(&name) function = __atomic_load_n(&found, __ATOMIC_RELAXED);                                        \
        if (function == NULL) {                                                                                        \
            function = (__typeof__(&name))real_function(#name);                                                        \
            __atomic_store_n(&found, function, __ATOMIC_RELAXED);                                                      \
        }                                                                                                              \
        function;                                                                                                      \
    })
#define NEWER(name) /* of a function that once was another one, whose name it has kept */                                \
    ({                                                                                                                 \
        static __typeof__(&name) found;                                                                                \
        __typeof__(&name) function = __atomic_load_n(&found, __ATOMIC_RELAXED);                                        \
        if (function == NULL) {                                                                                        \
            function = (__typeof__(&name))newer_function(#name);                                                       \
            __atomic_store_n(&found, function, __ATOMIC_RELAXED);                                                      \
        }                                                                                                              \
        function;                                                                                                      \
    })
void *newer_function(const char *name);
void *real_function(const char *name); /* ends the process where there is none */

int open_can_socket(int type, int protocol); /* sockets.c */

/* table.c */
extern struct table *shim_table;
struct slot *slot_of(int fd); /* NULL: not ours; errno is kept */
int slot_number(const struct slot *slot);
struct interface *interface_by_name(const char *name);
struct interface *interface_by_index(int index);

socklen_t address_length(const struct slot *slot); /* of a name, as the kernel tells it */

/* netlink.c: sockets of NETLINK_ROUTE, which lead to the server */
int open_link_socket(int type);
int is_link_socket(int fd);
int bind_link_socket(int fd, const struct sockaddr *address, socklen_t length);
int set_link_option(int fd, int name, const void *value, socklen_t length);
ssize_t send_to_server(int fd, const struct msghdr *message, int flags);
void hide_server(struct msghdr *message); /* as the kernel's */

/* control.c: -1 and errno, or the reply's number; `size` is the room for the reply's data, and then its length */
long ask(const struct request *request, const void *data, size_t length, void *reply, size_t *size, int *descriptor,
         int close_on_exec);
int canwire_supervise(void); /* supervise.c: before this process becomes a program that preloads nothing; 0 or an errno */
int dial(void); /* a connection to the server; -1 */
long note(enum note what, const char *text);

/* ring.c, and ring.h for what it works on; NULL for a socket that has none */
struct block *block_of(const struct slot *slot);

/* memory.c: the program's memory; 0, or EFAULT */
int copy_out(void *into, const void *from, size_t length);
int copy_in(void *into, const void *from, size_t length);
#define MOST_PARTS 1024 /* UIO_MAXIOV */
struct vector { /* a program's message, fetched */
    struct msghdr message;
    struct iovec parts[MOST_PARTS];
};
int fetch_message(struct vector *vector, const struct msghdr *message); /* -1 and errno */

/* rests.c */
ssize_t take_rest(const struct slot *slot, int number, ssize_t length, struct msghdr *message, ssize_t done);

/* packets.c: AF_PACKET */
#define KERNELS_OWN (-2)
int open_packet_socket(int type, int protocol); /* KERNELS_OWN: nothing of ours can be meant */
int bind_packet_socket(int fd, struct slot *slot, const struct sockaddr *address, socklen_t length);
int packet_destination(const struct slot *slot, const struct msghdr *message);
int get_packet_option(struct slot *slot, int name, void *value, socklen_t *length); /* 1: the server knows */
int ring_has_some(int fd, struct slot *slot);
int rings_ready(int count, const fd_set *reads); /* select: how many of them have some; the others will block */
struct sockaddr_ll;
void put_auxiliary(const struct received *header, struct msghdr *message, size_t *used);
int tell_packet(const struct slot *slot, const struct received *header, struct msghdr *message);
struct sockaddr_ll packet_name(const struct slot *slot, const struct received *header);

/* receive.c, send.c */
void put_control(struct msghdr *message, size_t *used, int level, int type, const void *data, size_t length);
ssize_t receive_message(int fd, struct slot *slot, struct msghdr *message, int flags);
ssize_t receive_error(struct slot *slot, struct msghdr *message); /* MSG_ERRQUEUE */
void drop_tokens(int fd, struct slot *slot); /* empty messages ahead of others, of errors that were told otherwise */
int take_error(int fd, struct slot *slot); /* the errno that waits, as the kernel's sk_err; 0: none */
ssize_t send_message(int fd, struct slot *slot, const struct msghdr *message, int flags);
size_t size_of_message(const struct msghdr *message);
int gather(const struct msghdr *message, char *into);                            /* its bytes: 0, or EFAULT */
int destination(const struct slot *slot, const struct msghdr *message);          /* an interface; 0, -1 and errno: none */
int waits_to_send(int fd, int flags);                                            /* it blocks where there is no room */
ssize_t send_asked(int fd, struct slot *slot, const struct msghdr *message, int flags); /* asked.c */

/* errors.c: error queues, and POLLERR while there is something in them or an error waits; mapped rings' POLLIN */
struct epoll_event;
int with_watched(struct pollfd *fds, unsigned long count);
int polled_once(struct pollfd *fds, unsigned long count, const sigset_t *mask);
int poll_watched(struct pollfd *fds, unsigned long count, const struct timespec *span, const sigset_t *mask);
int epolled_once(int fd, struct epoll_event *events, int most, const sigset_t *mask);
int with_watched_of(int epoll, struct epoll_event *events, int found, int most);
int epoll_watched(int fd, struct epoll_event *events, int most, int milliseconds, const sigset_t *mask);

#endif
