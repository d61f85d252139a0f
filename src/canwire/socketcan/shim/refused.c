/* What a CAN socket does not do. */
#include "shim.h"

#include <errno.h>
#include <linux/can.h>
#include <unistd.h>

static int refused(int fd)
{
    if (slot_of(fd) == NULL)
        return 0;
    errno = EOPNOTSUPP;
    return 1;
}

EXPORT int shutdown(int fd, int how)
{
    return refused(fd) ? -1 : REAL(shutdown)(fd, how);
}

EXPORT int accept(int fd, struct sockaddr *restrict address, socklen_t *restrict length)
{
    return refused(fd) ? -1 : REAL(accept)(fd, address, length);
}

EXPORT int accept4(int fd, struct sockaddr *restrict address, socklen_t *restrict length, int flags)
{
    return refused(fd) ? -1 : REAL(accept4)(fd, address, length, flags);
}

EXPORT int socketpair(int domain, int type, int protocol, int both[2])
{
    if (shim_table == NULL || domain != AF_CAN)
        return REAL(socketpair)(domain, type, protocol, both);
    int fd = open_can_socket(type, protocol);
    if (fd >= 0) {
        REAL(close)(fd);
        errno = EOPNOTSUPP;
    }
    return -1;
}

EXPORT int listen(int fd, int backlog)
{
    return refused(fd) ? -1 : REAL(listen)(fd, backlog);
}
