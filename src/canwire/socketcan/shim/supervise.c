/* Programs that preload nothing (static ones, Go): the kernel stops the calls that a CAN socket needs, and the server answers.
 *
 * seccomp's user notification, which no rights are needed for once no_new_privs is set. Reads and writes are not stopped
 * at: the messages of the descriptor that the server puts into the program are frames. ../supervised/ is the other end.
 */
#include "shim.h"

#include <errno.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stddef.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined(__x86_64__)
#define OWN_ARCH AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define OWN_ARCH AUDIT_ARCH_AARCH64
#else
#define OWN_ARCH 0
#endif

#ifndef PR_SET_PTRACER
#define PR_SET_PTRACER 0x59616d61
#endif

#define LOAD(offset) BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offset)
#define ARGUMENT(number) (offsetof(struct seccomp_data, args) + 8 * (number))
#define IF(value, then, otherwise) BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, then, otherwise)
#define PASS BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)
#define ASK BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_USER_NOTIF)

static const struct sock_filter filter[] = {
    LOAD(offsetof(struct seccomp_data, arch)),
    IF(OWN_ARCH, 1, 0),
    PASS,
    LOAD(offsetof(struct seccomp_data, nr)),
    IF(SYS_recvmmsg, 19, 0),
    IF(SYS_sendmmsg, 18, 0),
    IF(SYS_bind, 17, 0),
    IF(SYS_connect, 16, 0),
    IF(SYS_getsockname, 15, 0),
    IF(SYS_setsockopt, 14, 0),
    IF(SYS_getsockopt, 13, 0),
    IF(SYS_recvmsg, 12, 0),
    IF(SYS_sendmsg, 11, 0),
    IF(SYS_socket, 4, 0),
    IF(SYS_ioctl, 11, 0),
    IF(SYS_sendto, 5, 0),
    IF(SYS_recvfrom, 4, 0),
    PASS,
    LOAD(ARGUMENT(0)), /* socket: of AF_CAN, and rtnetlink's */
    IF(AF_CAN, 4, 0),
    IF(AF_NETLINK, 3, 2),
    LOAD(ARGUMENT(4)), /* sendto, recvfrom: with an address, whose low half is never 0 */
    IF(0, 0, 1),
    PASS,
    ASK,
    PASS,
    LOAD(ARGUMENT(1)), /* ioctl: about interfaces and stamps, 0x89.. */
    BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 0xffffff00),
    IF(0x8900, 0, 1),
    ASK,
    PASS,
};

static int install(void)
{
    struct sock_fprog program = {sizeof filter / sizeof *filter, (struct sock_filter *)filter};

    if (OWN_ARCH == 0)
        return errno = ENOSYS, -1;
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) < 0)
        return -1;
    return (int)syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_NEW_LISTENER, &program);
}

/* This thread's program is to be answered by the server from now on: 0, or an errno. */
EXPORT int canwire_supervise(void)
{
    struct request request = {.operation = SUPERVISE};
    int64_t result = -ENETDOWN;
    struct request probe = {.operation = SUPERVISE, .b = 1};
    int fd = dial();

    if (fd < 0)
        return ENETDOWN;
    prctl(PR_SET_PTRACER, -1L, 0, 0, 0); /* the server looks into its memory; where Yama is not, there is nothing to do */
    probe.a = fd;
    if (ask(&probe, NULL, 0, NULL, NULL, NULL, 0) < 0) { /* before there is no way back */
        int error = errno;
        REAL(close)(fd);
        return error;
    }
    int listener = install(); /* hereafter only calls that are not stopped at */
    if (listener >= 0) {
        request.a = listener;
        request.thread = (int32_t)syscall(SYS_gettid);
        if (syscall(SYS_write, fd, &request, sizeof request) != sizeof request ||
            syscall(SYS_read, fd, &result, sizeof result) != sizeof result)
            result = -ENETDOWN;
        syscall(SYS_close, listener);
    } else
        result = -errno;
    syscall(SYS_close, fd);
    return (int)-result;
}
