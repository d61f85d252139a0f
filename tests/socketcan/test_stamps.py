"""Times of what was sent, from the error queue: which, in what order, with what beside them."""

from __future__ import annotations

import sys

import pytest

from tests.socketcan.bench import Bench

STAMPED = """
import select, socket, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_LOOPBACK, {loopback})
wire.bind(("can0",))
SOFTWARE, HARDWARE, SCHEDULED, REPORTED, RAW, ID = 1 << 1, 1 << 0, 1 << 8, 1 << 4, 1 << 6, 1 << 7
ERRORS = socket.MSG_ERRQUEUE
wire.setsockopt(socket.SOL_SOCKET, 37, SOFTWARE | HARDWARE | SCHEDULED | REPORTED | RAW | ID)
poll, epoll = select.poll(), select.epoll()
poll.register(wire, 0), epoll.register(wire, 0)
frame = struct.pack("=IB3x8s", 0x123, 8, b"abcdefgh")
for count in range(2):
    assert wire.send(frame) == 16
told = []
while len(told) < 6:
    assert poll.poll(10_000) == [(wire.fileno(), select.POLLERR)]
    data, control, flags, _ = wire.recvmsg(100, 300, ERRORS)
    (level, kind, times), (error_level, error_kind, error) = control
    assert (data, level, kind, error_level, error_kind) == (frame, 1, 37, 101, 1) and flags & ERRORS
    number, origin, _, _, _, what, key = struct.unpack("=IBBBBII", error)
    assert (number, origin) == (42, 4)
    seconds, ns, *_, raw, raw_ns = struct.unpack("=6q", times)
    assert (seconds + ns > 0) != (raw + raw_ns > 0)
    told.append((what, key, "raw" if raw + raw_ns else "software"))
assert sorted(told) == sorted(
    (what, key, clock) for key in (0, 1) for what, clock in ((1, "software"), (0, "software"), (0, "raw"))
), told
assert told[0] == (1, 0, "software")
assert poll.poll(0) == [] == epoll.poll(0)
try:
    wire.recvmsg(100, 300, ERRORS)
except BlockingIOError:
    pass
wire.setsockopt(socket.SOL_SOCKET, 37, REPORTED)  # no more of them
wire.send(frame)
"""


@pytest.mark.conforms("N-52")
@pytest.mark.finding("socketcan 6")
@pytest.mark.parametrize("loopback", [1, 0], ids=["looped back", "not looped back"])
def test_times_of_what_was_sent(bench: Bench, loopback: int) -> None:
    bench.run(sys.executable, "-c", STAMPED.format(loopback=loopback))


DOWN = """
import errno, select, socket, subprocess, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("can0",))
poll, epoll = select.poll(), select.epoll()
poll.register(wire, select.POLLIN), epoll.register(wire, select.EPOLLIN | select.EPOLLET)
print("bound", flush=True)
assert poll.poll() == [(wire.fileno(), select.POLLERR)]
assert epoll.poll() == [(wire.fileno(), select.EPOLLERR)]
assert wire.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == errno.ENETDOWN
assert poll.poll(0) == []
"""


@pytest.mark.conforms("N-21")
def test_an_error_is_told_as_such(bench: Bench) -> None:
    """POLLERR, as the kernel has it, and not as something to read."""
    program = bench.start(sys.executable, "-c", DOWN)
    assert program.stdout is not None
    assert program.stdout.readline() == "bound\n"
    import canwire

    for place in canwire.every_line(bench.hub, "CAN"):
        status = place.status(bench.hub)
        if status.channels:
            with bench.hub.open_control(place.board.id, place.line) as control:
                control.stop()
    output, errors = program.communicate(timeout=30)
    assert program.returncode == 0, (output, errors)
