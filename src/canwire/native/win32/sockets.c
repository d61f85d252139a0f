/* TCP on this machine, without a child that inherits it. */
#include "win32.h"

#include <errno.h>

int far_sockets_ready(void)
{
    static WSADATA about;
    static LONG ready;

    if (InterlockedCompareExchange(&ready, 0, 0) == 0) {
        if (WSAStartup(MAKEWORD(2, 2), &about) != 0) {
            errno = ENETDOWN;
            return -1;
        }
        InterlockedExchange(&ready, 1);
    }
    return 0;
}

SOCKET far_socket(void)
{
    SOCKET made = WSASocketW(AF_INET, SOCK_STREAM, IPPROTO_TCP, NULL, 0, WSA_FLAG_OVERLAPPED | WSA_FLAG_NO_HANDLE_INHERIT);

    if (made == INVALID_SOCKET)
        errno = ENOBUFS;
    return made;
}

SOCKET far_dial(uint16_t port)
{
    struct sockaddr_in where = {.sin_family = AF_INET, .sin_port = htons(port)};
    SOCKET made = far_socket();
    DWORD now = 1;

    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (made == INVALID_SOCKET)
        return made;
    if (connect(made, (struct sockaddr *)&where, sizeof where) != 0) {
        closesocket(made);
        errno = ECONNREFUSED;
        return INVALID_SOCKET;
    }
    setsockopt(made, IPPROTO_TCP, TCP_NODELAY, (const char *)&now, sizeof now);
    return made;
}

int far_send(SOCKET socket, const void *data, size_t size)
{
    const char *at = data;

    while (size > 0) {
        int sent = send(socket, at, (int)size, 0);
        if (sent <= 0)
            return -1;
        at += sent;
        size -= (size_t)sent;
    }
    return 0;
}

int far_receive(SOCKET socket, void *into, size_t size)
{
    char *at = into;

    while (size > 0) {
        int got = recv(socket, at, (int)size, 0);
        if (got <= 0)
            return -1;
        at += got;
        size -= (size_t)got;
    }
    return 0;
}
