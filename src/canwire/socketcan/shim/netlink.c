/* Sockets of NETLINK_ROUTE: the program gets one of NETLINK_USERSOCK, and what it sends to the kernel goes to the server.
 *
 * Such a socket is the kernel's own in everything else, and an ordinary user may send from one to another. The server
 * answers about its interfaces, and asks the kernel about all others (../netlink/).
 */
#include "shim.h"

#include <errno.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <string.h>

int open_link_socket(int type)
{
    int fd = -1;

    if (shim_table->netlink_port != 0 && (fd = REAL(socket)(AF_NETLINK, type, NETLINK_USERSOCK)) >= 0)
        __atomic_store_n(&shim_table->link_sockets, 1, __ATOMIC_RELAXED);
    if (fd < 0) {
        note(NOTE_NETLINK, program_invocation_short_name);
        fd = REAL(socket)(AF_NETLINK, type, NETLINK_ROUTE);
    }
    return fd;
}

int is_link_socket(int fd)
{
    int protocol = -1, before = errno;
    struct sockaddr_storage name;
    socklen_t size = sizeof name, length = sizeof protocol;

    if (shim_table == NULL || __atomic_load_n(&shim_table->link_sockets, __ATOMIC_RELAXED) == 0)
        return 0;
    if (REAL(getsockname)(fd, (struct sockaddr *)&name, &size) < 0 || name.ss_family != AF_NETLINK ||
        REAL(getsockopt)(fd, SOL_SOCKET, SO_PROTOCOL, &protocol, &length) < 0)
        protocol = -1;
    errno = before;
    return protocol == NETLINK_USERSOCK;
}

/* Groups are those of another protocol: the server tells each socket by itself. */
static int subscribe(int fd, int group)
{
    struct sockaddr_nl name = {.nl_family = AF_NETLINK};
    socklen_t length = sizeof name;

    if (REAL(getsockname)(fd, (struct sockaddr *)&name, &length) < 0)
        return -1;
    if (name.nl_pid == 0) { /* it has no address yet */
        if (REAL(bind)(fd, (struct sockaddr *)&name, sizeof name) < 0 ||
            REAL(getsockname)(fd, (struct sockaddr *)&name, &length) < 0)
            return -1;
    }
    struct request request = {.operation = SUBSCRIBE, .a = (int32_t)name.nl_pid, .b = group};
    return ask(&request, NULL, 0, NULL, NULL, NULL, 0) < 0 ? -1 : 0;
}

static int subscribe_all(int fd, uint32_t groups)
{
    for (int group = 1; groups != 0; group++, groups >>= 1)
        if (groups & 1 && subscribe(fd, group) < 0)
            return -1;
    return 0;
}

int bind_link_socket(int fd, const struct sockaddr *address, socklen_t length)
{
    struct sockaddr_nl name;

    if (length < sizeof name || copy_in(&name, address, sizeof name) != 0)
        return REAL(bind)(fd, address, length);
    uint32_t groups = name.nl_groups;
    struct sockaddr_nl own = {0};
    socklen_t size = sizeof own;
    name.nl_groups = 0;
    if (REAL(getsockname)(fd, (struct sockaddr *)&own, &size) == 0 && own.nl_pid != 0 && name.nl_pid == 0)
        return subscribe_all(fd, groups); /* bound by a membership before */
    return REAL(bind)(fd, (struct sockaddr *)&name, sizeof name) < 0 ? -1 : subscribe_all(fd, groups);
}

int set_link_option(int fd, int name, const void *value, socklen_t length)
{
    int group;

    if (name == NETLINK_ADD_MEMBERSHIP || name == NETLINK_DROP_MEMBERSHIP) {
        if (length < sizeof group)
            return errno = EINVAL, -1;
        if (copy_in(&group, value, sizeof group) != 0)
            return errno = EFAULT, -1;
        return subscribe(fd, name == NETLINK_ADD_MEMBERSHIP ? group : -group);
    }
    return REAL(setsockopt)(fd, SOL_NETLINK, name, value, length);
}

ssize_t send_to_server(int fd, const struct msghdr *message, int flags)
{
    struct sockaddr_nl server = {.nl_family = AF_NETLINK, .nl_pid = shim_table->netlink_port};
    struct sockaddr_nl theirs = {.nl_family = AF_NETLINK};
    struct msghdr changed = *message;

    if (message->msg_name != NULL && message->msg_namelen >= sizeof theirs &&
        (copy_in(&theirs, message->msg_name, sizeof theirs) != 0 || theirs.nl_pid != 0))
        return REAL(sendmsg)(fd, message, flags);
    changed.msg_name = &server;
    changed.msg_namelen = sizeof server;
    return REAL(sendmsg)(fd, &changed, flags);
}

void hide_server(struct msghdr *message)
{
    struct sockaddr_nl *name = message->msg_name;

    if (shim_table != NULL && __atomic_load_n(&shim_table->link_sockets, __ATOMIC_RELAXED) != 0 && name != NULL &&
        message->msg_namelen >= sizeof *name && name->nl_family == AF_NETLINK &&
        name->nl_pid == shim_table->netlink_port)
        name->nl_pid = 0;
}
