"""AF_PACKET: what packet sockets hear and send, mapped rings in both layouts, and the programs that use them."""

from __future__ import annotations

import errno
import struct
import sys
from pathlib import Path
from typing import Any

import numpy
import pytest

from canwire.socketcan.loop import Loop
from canwire.socketcan.packets.blocks import BlockRing
from canwire.socketcan.packets.frames import FrameRing
from canwire.socketcan.packets.ring import V2, V3, RingRequest
from canwire.socketcan.wire import received_dtype
from tests.cases import each
from tests.missing import find_program
from tests.socketcan.bench import Bench

SENT = """
import errno, mmap, select, socket, struct
ALL, CAN, CANFD = 3, 0xC, 0xD
SOL_PACKET = 263
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
wire.bind(("can0",))
frame, long = struct.pack("<IB3x8s", 0x123, 8, b"abcdefgh"), struct.pack("<IB3x64s", 0x124, 64, bytes(range(64)))
def heard(protocol, kind=socket.SOCK_RAW):
    made = socket.socket(socket.AF_PACKET, kind, 0)
    made.settimeout(10)
    made.bind(("can0", protocol))
    return made
"""

HEARD = """
everything, classic, fd = heard(ALL), heard(CAN), heard(CANFD, socket.SOCK_DGRAM)
assert everything.getsockname() == ("can0", ALL, 0, 280, b"")
everything.setsockopt(SOL_PACKET, 8, 1)
wire.send(frame), wire.send(long)
came = [everything.recvmsg(100, 200) for _ in range(4)]
assert sorted((data, name[1], name[2]) for data, _, _, name in came) == sorted(
    (data, protocol, kind) for data, protocol in ((frame, CAN), (long, CANFD)) for kind in (1, 4)
)
((level, kind, auxiliary),) = came[0][1]
assert (level, kind, struct.unpack("<3I", auxiliary[:12])) == (SOL_PACKET, 8, (1, len(came[0][0]), len(came[0][0])))
assert classic.recv(100) == frame and fd.recvfrom(100)[1][:3] == ("can0", CANFD, 1)
assert struct.unpack("<II", everything.getsockopt(SOL_PACKET, 6, 8)) == (4, 0)
assert struct.unpack("<II", everything.getsockopt(SOL_PACKET, 6, 8)) == (0, 0)
"""

SENDS = """
sender = heard(CAN)
sender.send(frame)
assert wire.recv(72) == frame
sender.sendto(long, ("can0", CANFD))
assert wire.recv(72) == long
assert sender.recv(100) == frame  # its own, as it was on the bus
for bad, error in ((bytes(73), errno.EMSGSIZE), (None, errno.ENXIO)):
    try:
        heard(0).send(bad) if bad else socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0).send(frame)
    except OSError as failed:
        assert failed.errno == error, failed
    else:
        raise AssertionError(error)
assert sender.send(bytes(20)) == 20  # no frame: dropped, and nothing said, as by a driver
"""

KERNELS = """
kernel = socket.socket(socket.AF_PACKET, socket.SOCK_RAW | socket.SOCK_NONBLOCK, 0)
try:
    kernel.bind(("lo", 0x88B5))
except PermissionError:  # an ordinary user's
    pass
else:
    assert kernel.getsockname()[:2] == ("lo", 0x88B5) and not kernel.getblocking()
"""


@pytest.mark.conforms("N-50")
@pytest.mark.parametrize(
    "what", [HEARD, SENDS, KERNELS], ids=["heard", "sends", "of the kernel's interfaces"]
)
def test_packet_sockets(bench: Bench, what: str) -> None:
    bench.run(sys.executable, "-c", SENT + what)


RING = """
import ctypes
version, sizes = {version}, (1 << 16, 4, 1 << 11, 128)
ring = heard(CAN)
ring.setsockopt(SOL_PACKET, 10, version)
ring.setsockopt(SOL_PACKET, 5, struct.pack("<7I", *sizes, {retire_ms}, 0, 0)[: 16 if version == 1 else 28])
memory = mmap.mmap(ring.fileno(), 1 << 18)
try:
    ring.setsockopt(socket.SOL_SOCKET, 26, bytes(16))
except OSError as failed:
    assert failed.errno == errno.ENOPROTOOPT, failed  # its messages are none of frames: libpcap filters by itself
else:
    raise AssertionError("a filter")
poll = select.poll()
poll.register(ring, select.POLLIN)
assert poll.poll(0) == [] and select.select([ring], [], [], 0)[0] == []
wire.send(frame)
assert select.select([ring], [], [], 10)[0] == [ring] and poll.poll(10_000) == [(ring.fileno(), select.POLLIN)]
assert poll.poll(0) and poll.poll(0)  # until it is taken
{look}
assert poll.poll(0) == [] and select.select([ring], [], [], 0)[0] == []
wire.send(frame)
assert poll.poll(10_000) == [(ring.fileno(), select.POLLIN)]
assert struct.unpack("<II", ring.getsockopt(SOL_PACKET, 6, 12)[:8]) == (2, 0)
import subprocess
subprocess.run(["ip", "link", "set", "can0", "down"], check=True)
poll.modify(ring, 0)
assert poll.poll(10_000) == [(ring.fileno(), select.POLLERR)]
assert ring.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == errno.ENETDOWN
assert poll.poll(0) == []
"""

LOOK_2 = """
status, length, kept, mac, net, seconds, ns = struct.unpack_from("<3I2H2I", memory)
assert (status & 1, length, kept, mac) == (1, 16, 16, net), (status, length, kept, mac, net)
assert memory[mac:mac + 16] == frame and struct.unpack_from("<H", memory, 32) == (17,)
struct.pack_into("<I", memory, 0, 0)
"""

LOOK_3 = """
version_of, private, state, count, first, used = struct.unpack_from("<6I", memory)
assert (version_of, state & 1, count, first) == (2, 1, 1, 48)
following, seconds, ns, kept, length, status, mac, net = struct.unpack_from("<6I2H", memory, first)
assert (following, kept, length) == (0, 16, 16) and memory[first + mac:first + mac + 16] == frame
struct.pack_into("<I", memory, 8, 0)
"""


@pytest.mark.conforms("N-50")
@pytest.mark.parametrize(("version", "look"), [(V2, LOOK_2), (V3, LOOK_3)], ids=["V2", "V3"])
def test_a_mapped_ring(bench: Bench, version: int, look: str) -> None:
    find_program("ip")
    bench.run(sys.executable, "-c", SENT + RING.format(version=version, look=look, retire_ms=1))


def rows(*ids: int, size: int = 16) -> Any:
    found = numpy.zeros(len(ids), received_dtype())
    found["can_id"], found["length"], found["stamp_ns"] = ids, size, 3_000_000_007
    return found


ADDRESS = numpy.zeros(1, "V20")


def put(ring: FrameRing | BlockRing, frames: Any) -> bool:
    return ring.put(frames, ADDRESS.repeat(len(frames)))


def test_frames_that_do_not_fit_are_counted() -> None:
    ring = FrameRing(RingRequest(V2, 0, 4096, 2, 1024, 8))
    assert put(ring, rows(*range(6)))
    assert put(ring, rows(*range(6, 16)))
    assert (ring.packets, ring.drops, ring.last_at) == (16, 8, 4096 + 3 * 1024)
    assert not put(ring, rows(99))
    ids = [struct.unpack_from("<I", ring.memory.bytes, 1024 * at + 80)[0] for at in range(8)]
    assert ids == list(range(8))
    struct.pack_into("<I", ring.memory.bytes, 0, 0)  # the program has read the first one
    assert put(ring, rows(77))
    assert struct.unpack_from("<I", ring.memory.bytes, 80)[0] == 77
    ring.close()


def test_a_block_is_handed_over_when_it_is_full_or_its_time_is_over() -> None:
    loop, expired = Loop(), []
    ring = BlockRing(RingRequest(V3, 0, 4096, 2, 4096, 2, 1), loop, lambda: (expired.append(1), loop.stop()))
    assert not put(ring, rows(1, 2))
    loop.run()
    count = [struct.unpack_from("<II", ring.memory.bytes, 4096 * block + 8) for block in (0, 1)]
    assert (expired, count) == ([1], [(1 | 1 << 5, 2), (0, 0)])
    assert put(ring, rows(*range(50)))  # 36 in a block: the rest has none
    assert (ring.drops, ring.freezes, struct.unpack_from("<I", ring.memory.bytes, 4096 + 12)[0]) == (
        14,
        1,
        36,
    )
    struct.pack_into("<I", ring.memory.bytes, 8, 0)
    assert not put(ring, numpy.concatenate([rows(1), rows(2, size=72), rows(3)]))
    ring.close()
    loop.close()


@each(
    ("sizes", "version", "error"),
    [
        ((4000, 1, 1024, 3), V2, errno.EINVAL),
        ((4096, 1, 1024, 5), V2, errno.EINVAL),
        ((4096, 1, 64, 64), V2, errno.EINVAL),
        ((4096, 1, 1000, 4), V2, errno.EINVAL),
        ((4096, 1 << 20, 4096, 1 << 20), V2, errno.ENOMEM),
        ((4096, 1, 1024, 4), 0, errno.EINVAL),
        ((4096, 1, 1024, 4), V3, errno.EINVAL),  # so short a request is another version's
    ],
)
def test_rings_that_cannot_be(sizes: tuple[int, ...], version: int, error: int) -> None:
    with pytest.raises(OSError, match=r"\[Errno") as failed:
        RingRequest.parse(struct.pack("<4I", *sizes), version, 0)
    assert failed.value.errno == error


CAPTURED = """
cangen can0 -g 5 -I 123 -L 8 -D 1122334455667788 & sender=$!
{capture}
status=$?
kill $sender
exit $status
"""


@pytest.mark.conforms("N-50", "N-51")
@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("dumpcap", "-q -i can0 -c 3 -w {file}"),
        ("tcpdump", "-Z root -i can0 -c 3 -w {file} len = 16"),
        ("tcpdump", "-Z root --immediate-mode -i can0 -c 3 -w {file}"),
    ],
    ids=["dumpcap", "tcpdump", "tcpdump, frame by frame"],
)
def test_captures(bench: Bench, tmp_path: Path, program: str, words: str) -> None:
    for name in (program, "cangen"):
        find_program(name)
    file = tmp_path / "captured"
    capture = f"{program} {words.format(file=file)}"
    bench.run("sh", "-c", CAPTURED.format(capture=capture))
    frame = struct.pack(">IB3x", 0x123, 8) + bytes.fromhex(
        "1122334455667788"
    )  # libpcap turns the identifier round
    assert file.read_bytes().count(frame) == 3


@pytest.mark.conforms("N-50", "N-51")
def test_tshark_hears_an_interface(bench: Bench) -> None:
    for name in ("tshark", "cangen"):
        find_program(name)
    shown = bench.run(
        "sh", "-c", CAPTURED.format(capture="tshark -i can0 -c 3 -T fields -e can.id -e can.len")
    )
    assert shown.splitlines() == ["291\t8"] * 3
