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

/* Groups are those of another protocol: nothing is told of changes. */
int bind_link_socket(int fd, const struct sockaddr *address, socklen_t length)
{
    struct sockaddr_nl name;

    if (length < sizeof name || copy_in(&name, address, sizeof name) != 0)
        return REAL(bind)(fd, address, length);
    name.nl_groups = 0;
    return REAL(bind)(fd, (struct sockaddr *)&name, sizeof name);
}

int set_link_option(int fd, int name, const void *value, socklen_t length)
{
    if (name == NETLINK_ADD_MEMBERSHIP || name == NETLINK_DROP_MEMBERSHIP)
        return 0;
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
