/* Whole messages that programs write (CAN_BCM, CAN_ISOTP, CAN_J1939): the server takes and answers each. */
#include "shim.h"

#include <errno.h>
#include <linux/can.h>
#include <stdlib.h>
#include <string.h>

#define LARGEST_ETP (0xffffffu * 7) /* SAE J1939-21: packets, and bytes in each */
#define CHUNK 65536 /* bytes of a request */

/* CAN_J1939: the server has to know the address, and takes long messages in parts. */
static long ask_in_parts(struct request *request, const struct msghdr *message, const char *packet, size_t size)
{
    size_t ahead = message->msg_name != NULL ? message->msg_namelen : 0;
    char part[sizeof(struct sockaddr_storage) + CHUNK];

    if (ahead > sizeof(struct sockaddr_storage))
        return errno = EINVAL, -1;
    if (copy_in(part, message->msg_name, ahead) != 0)
        return errno = EFAULT, -1;
    for (size_t done = 0;;) {
        size_t span = size - done < CHUNK ? size - done : CHUNK;
        int last = done + span == size;
        memcpy(part + ahead, packet + done, span);
        request->a = (int32_t)ahead | (last ? 0 : MORE_FOLLOWS);
        if (ask(request, part, ahead + span, NULL, NULL, NULL, 0) < 0)
            return -1;
        if (last)
            return (long)size;
        done += span;
    }
}

/* Those of whole messages: the server answers each, so that its errors are those of this call. */
ssize_t send_asked(int fd, struct slot *slot, const struct msghdr *message, int flags)
{
    int j1939 = slot->protocol == CAN_J1939;
    struct request request = {.operation = j1939 ? SEND_J1939 : slot->protocol == CAN_BCM ? SEND_BCM : SEND_ISOTP,
                              .slot = slot_number(slot)};
    size_t size = size_of_message(message);
    char *packet;
    long done;

    request.a = j1939 ? 0 : destination(slot, message);
    request.b = waits_to_send(fd, flags);
    if (request.a < 0)
        return -1;
    if (size > (j1939 ? LARGEST_ETP : 1u << 20)) {
        errno = EMSGSIZE;
        return -1;
    }
    if ((packet = malloc(size + 1)) == NULL) {
        errno = ENOMEM;
        return -1;
    }
    int error = slot->protocol != CAN_BCM ? take_error(fd, slot) : 0;
    if (error == 0)
        error = gather(message, packet);
    if (error != 0)
        done = -1;
    else if (j1939)
        done = ask_in_parts(&request, message, packet, size);
    else
        done = ask(&request, packet, size, NULL, NULL, NULL, 0);
    error = error == 0 ? errno : error;
    free(packet);
    errno = error;
    return done;
}
