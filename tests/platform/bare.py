"""Takes away what Windows has not, before anything of canwire is imported, and runs the rest of the command line.

python -m tests.platform.bare serve --socket PATH       the verb, in such a process
python -m tests.platform.bare -c CODE ARGUMENTS         or some code
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys

MODULES = ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "_posixshmem")
OF_OS = (
    "memfd_create", "eventfd", "eventfd_read", "eventfd_write", "fork", "forkpty", "register_at_fork", "getuid",
    "geteuid", "getgid", "getegid", "mkfifo", "pipe2", "posix_spawn", "posix_spawnp", "setsid", "killpg", "fchmod",
    "chown", "lchown", "fchown", "posix_fallocate", "sendfile", "O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_DIRECTORY",
    "sched_setscheduler", "sched_setaffinity", "getpgid", "setpgid", "openpty", "ttyname",
)  # fmt: skip
OF_SOCKET = (
    "AF_UNIX", "SCM_RIGHTS", "SCM_CREDENTIALS", "SO_PEERCRED", "SO_PASSCRED", "CMSG_LEN", "CMSG_SPACE", "send_fds",
    "recv_fds", "socketpair", "MSG_CMSG_CLOEXEC", "MSG_DONTWAIT", "MSG_NOSIGNAL", "AF_CAN", "AF_NETLINK",
    "SO_REUSEPORT",
)  # fmt: skip
OF_SELECT = ("epoll", "poll")
SIGNALS = ("SIGINT", "SIGTERM", "SIGABRT", "SIGFPE", "SIGILL", "SIGSEGV", "SIG_DFL", "SIG_IGN")
OF_SIGNAL = (
    "alarm",
    "setitimer",
    "getitimer",
    "pthread_sigmask",
    "pthread_kill",
    "sigwait",
    "pause",
    "siginterrupt",
)


def strip() -> None:
    """From now on none of them is there for anybody in this process."""
    for name in MODULES:
        sys.modules[name] = None  # type: ignore[assignment]
    for module, names in ((os, OF_OS), (socket, OF_SOCKET), (select, OF_SELECT), (signal, OF_SIGNAL)):
        for name in names:
            if hasattr(module, name):
                delattr(module, name)
    for name in [name for name in dir(signal) if name.startswith("SIG") and name not in SIGNALS]:
        delattr(signal, name)
    for name in ("sendmsg", "recvmsg", "recvmsg_into"):
        setattr(socket.socket, name, None)


def main() -> int:
    strip()
    if sys.argv[1] == "-c":
        code = sys.argv[2]
        sys.argv[1:3] = []
        exec(compile(code, "<bare>", "exec"), {"__name__": "__main__"})
        return 0
    from canwire.commands import main as verb

    return verb()


if __name__ == "__main__":
    sys.exit(main())
