"""A machine of its own as far as the network goes: `unshare -Urn python holder.py SOCKET ADDRESS`.

It has the loopback and one interface, whose other end goes to who started it, over SOCKET; it lives as long as that.
"""

from __future__ import annotations

import fcntl
import os
import socket
import struct
import subprocess
import sys

_TUNSETIFF, _TUN, _NO_HEADER = 0x400454CA, 0x0001, 0x1000  # linux/if_tun.h


def main(number: str, address: str) -> None:
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, _TUNSETIFF, struct.pack("16sH22s", b"lan", _TUN | _NO_HEADER, b""))
    for words in (f"addr add {address}/24 dev lan", "link set lan up", "link set lo up"):
        subprocess.run(["ip", *words.split()], check=True)
    with socket.socket(fileno=int(number)) as to_parent:
        socket.send_fds(to_parent, [b"up"], [tun])
        os.close(tun)
        to_parent.recv(1)  # until it is closed there


if __name__ == "__main__":
    main(*sys.argv[1:])
