/* CAN_J1939 messages that are longer than what a socket pair has room for. */
#include "shim.h"

#include <errno.h>
#include <unistd.h>

/* The first bytes came by the pair (`length`), and so many of them were handed over (`done`): the rest comes from the server's
 * memory. -1 and errno. */
ssize_t take_rest(const struct slot *slot, int number, ssize_t length, struct msghdr *message, ssize_t done)
{
    struct request request = {.operation = TAKE_REST, .slot = slot_number(slot), .a = number};
    int memory = -1;
    long size = ask(&request, NULL, 0, NULL, NULL, &memory, 1);
    size_t skipped = (size_t)done, at = 0;
    off_t taken = 0;

    if (size < 0 || memory < 0)
        return -1;
    for (; at < message->msg_iovlen && taken < size && done >= length; at++) {
        struct iovec part = message->msg_iov[at];
        size_t skip = part.iov_len < skipped ? part.iov_len : skipped;
        skipped -= skip;
        if (part.iov_len == skip)
            continue;
        ssize_t got = pread(memory, (char *)part.iov_base + skip, part.iov_len - skip, taken);
        if (got < 0) {
            done = -1;
            break;
        }
        taken += got;
    }
    int before = errno;
    REAL(close)(memory);
    errno = before;
    if (taken < size)
        message->msg_flags |= MSG_TRUNC;
    return done < 0 ? -1 : done + (ssize_t)taken;
}
