/* Copies from and into the program's memory that fail with EFAULT where the kernel's do, instead of a signal.
 *
 * The kernel copies what lies outside the pages that a thread used last; programs use the same buffer again and again, so
 * that nearly every copy is a plain one.
 */
#include "shim.h"

#include <errno.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

#define PAGE 4096u

struct span { /* of pages that were there; empty: none */
    uintptr_t begin, end;
};

static __thread volatile struct span written, read_from;

static int inside(const volatile struct span *span, const void *place, size_t length)
{
    uintptr_t begin = (uintptr_t)place;

    return begin >= span->begin && begin < span->end && length <= span->end - begin;
}

static void remember(volatile struct span *span, const void *place, size_t length)
{
    span->end = 0; /* a signal handler may come in between */
    span->begin = (uintptr_t)place & ~(uintptr_t)(PAGE - 1);
    span->end = ((uintptr_t)place + length + PAGE - 1) & ~(uintptr_t)(PAGE - 1);
}

typedef ssize_t copy(pid_t, const struct iovec *, unsigned long, const struct iovec *, unsigned long, unsigned long);

/* 1: copied; 0: nobody may ask the kernel for it here; -1: EFAULT */
static int by_kernel(copy *call, const void *own, const void *theirs, size_t length)
{
    struct iovec local = {(void *)own, length}, remote = {(void *)theirs, length};
    int before = errno;
    ssize_t done = call(getpid(), &local, 1, &remote, 1, 0);
    int bad = done >= 0 ? (size_t)done < length : errno == EFAULT;

    errno = before;
    return bad ? -1 : done >= 0;
}

int copy_out(void *into, const void *from, size_t length)
{
    if (length == 0)
        return 0;
    if (!inside(&written, into, length)) {
        int done = by_kernel(process_vm_writev, from, into, length);
        if (done < 0)
            return EFAULT;
        remember(&written, into, length);
        if (done > 0)
            return 0;
    }
    memcpy(into, from, length);
    return 0;
}

int copy_in(void *into, const void *from, size_t length)
{
    if (length == 0)
        return 0;
    if (!inside(&written, from, length) && !inside(&read_from, from, length)) {
        int done = by_kernel(process_vm_readv, into, from, length);
        if (done < 0)
            return EFAULT;
        remember(&read_from, from, length);
        if (done > 0)
            return 0;
    }
    memcpy(into, from, length);
    return 0;
}

int fetch_message(struct vector *vector, const struct msghdr *message)
{
    int error = copy_in(&vector->message, message, sizeof *message);

    if (error == 0 && vector->message.msg_iovlen > MOST_PARTS)
        error = EMSGSIZE;
    if (error == 0)
        error = copy_in(vector->parts, vector->message.msg_iov, vector->message.msg_iovlen * sizeof *vector->parts);
    vector->message.msg_iov = vector->parts;
    if (error != 0)
        errno = error;
    return error != 0 ? -1 : 0;
}
