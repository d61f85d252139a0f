"""CAN_J1939 sockets of programs: can-utils' tools, CPython's own tests, what each call is answered."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.hubs import LONG_S
from tests.socketcan.bench import Bench, finished, frames, need

BOUND = """
import errno, os, select, socket, struct
NO_PGN, SOL, MANY = socket.J1939_NO_PGN, 107, 300
def bound(address, *, to_all=False, errors=False):
    made = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_J1939)
    if to_all:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
    if errors:
        made.setsockopt(SOL, socket.SO_J1939_ERRQUEUE, 1)
        made.setsockopt(socket.SOL_SOCKET, 37, 1 << 4 | 1 << 7 | 1 << 8 | 1 << 9)
    made.bind(("can0", 0, NO_PGN, address))
    made.settimeout(200)
    return made
def refused(error, call, *words):
    try:
        call(*words)
    except OSError as problem:
        assert problem.errno == error, problem
    else:
        raise AssertionError(f"{call} was not refused")
one, other = bound(0x20), bound(0x30, to_all=True)
"""
MESSAGES = """
def at(address, pgn=0x12300):
    return "can0", 0, pgn, address
for size in (0, 5, 8, 9, 1785, 1786, 70_000):
    data = bytes(k * 7 & 255 for k in range(size))
    assert one.sendto(data, at(0x30)) == size
    got, control, flags, name = other.recvmsg(1 << 17, 200)
    assert (got, flags & ~socket.MSG_DONTROUTE, name) == (data, 0, ("can0", 0, 0x12300, 0x20)), (size, flags, name)
    assert control == [(SOL, socket.SCM_J1939_DEST_ADDR, b"\\x30"), (SOL, socket.SCM_J1939_PRIO, b"\\6")], control
one.setsockopt(SOL, socket.SO_J1939_SEND_PRIO, 3)
one.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
one.sendto(bytes(20), at(255, 0xFEEC))
got, control, flags, name = other.recvmsg(4, 200)
assert (len(got), flags & socket.MSG_TRUNC, name) == (4, socket.MSG_TRUNC, ("can0", 0, 0xFEEC, 0x20))
assert control == [(SOL, socket.SCM_J1939_PRIO, b"\\3")], control
one.connect(at(0x30))
assert one.getpeername() == at(0x30)
one.send(b"connected")
assert other.recv(20) == b"connected"
for number in range(MANY):
    one.send(b"%d" % number)
assert [int(other.recv(20)) for _ in range(MANY)] == list(range(MANY))
"""
MISTAKES = """
fresh = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_J1939)
refused(77, fresh.send, b"1")  # EBADFD
refused(errno.EINVAL, fresh.connect, ("can0", 0, NO_PGN, 0x30))
refused(errno.EINVAL, fresh.bind, ("can0", 0, 0x1230, 0x30))
refused(errno.ENODEV, fresh.bind, ("", 0, NO_PGN, 0x30))
fresh.bind(("can0", 0, NO_PGN, 255))
assert fresh.getsockname() == ("can0", 0, NO_PGN, 255)
refused(77, fresh.sendto, b"1", ("can0", 0, 0x12300, 0x30))
refused(errno.EADDRNOTAVAIL, fresh.getpeername)
refused(errno.EACCES, one.sendto, b"1", ("can0", 0, 0xFEEC, 255))
refused(errno.EACCES, one.connect, ("can0", 0, 0xFEEC, 255))
refused(errno.EINVAL, one.sendto, b"1", ("can0", 0, 0x1230, 0x30))
refused(errno.EDOM, one.sendto, b"1", ("can0", 0, 0xEC00, 0x30))
refused(errno.EADDRNOTAVAIL, one.sendto, b"1", ("can0", 0x1234, 0x12300, 255))
refused(errno.EDESTADDRREQ, other.sendto, bytes(2000), ("can0", 0, 0xFEEC, 255))
refused(errno.EMSGSIZE, other.sendto, bytes(117_440_506), ("can0", 0, 0x12300, 0x20))
refused(errno.EDOM, one.setsockopt, SOL, socket.SO_J1939_SEND_PRIO, 8)
refused(errno.ENOPROTOOPT, one.setsockopt, SOL, 9, 1)
refused(errno.EINVAL, one.setsockopt, 101, 1, 1)
refused(errno.EINVAL, one.setsockopt, SOL, socket.SO_J1939_FILTER, bytes(31))
one.setblocking(True)
refused(errno.EINVAL, one.recv, 8, socket.MSG_PEEK)
assert [one.getsockopt(SOL, name) for name in (2, 3, 4)] == [0, 6, 0]
"""
ERRORS = """
sender = bound(0x40, errors=True)
poll, epoll = select.poll(), select.epoll()
poll.register(sender, select.POLLERR)
epoll.register(sender, select.EPOLLERR)
def told():
    data, control, flags, _ = sender.recvmsg(100, 200, socket.MSG_ERRQUEUE)
    assert flags == socket.MSG_ERRQUEUE and [part[:2] for part in control] == [(1, 37), (1, 54), (SOL, 4)], control
    return struct.unpack_from("=IBBBBII", control[2][2]), struct.unpack("=HHI", data)[2]
def waits(expected):
    assert poll.poll(30_000) == epoll.poll(30) == [(sender.fileno(), expected)]
assert poll.poll(0) == epoll.poll(0) == []
sender.sendto(b"12345", ("can0", 0, 0x12300, 0x30))
waits(select.POLLERR)
assert told() == ((errno.ENOMSG, 4, 0, 0, 0, 1, 0), 5)  # scheduled
waits(select.POLLERR)
assert told() == ((errno.ENOMSG, 4, 0, 0, 0, 2, 0), 5)  # acknowledged
assert poll.poll(0) == epoll.poll(0) == []
sender.setblocking(False)
refused(errno.EAGAIN, sender.recvmsg, 1, 200, socket.MSG_ERRQUEUE)
refused(errno.EAGAIN, sender.recv, 1)
one.sendto(b"unread", ("can0", 0, 0x12300, 0x40))
sender.sendto(bytes(20), ("can0", 0, 0x12300, 0x77))
waits(select.POLLERR)
assert told() == ((errno.EHOSTUNREACH, 1, 0, 0, 0, 1, 1), 0)
assert sender.recv(10) == b"unread"
one.sendto(bytes(20), ("can0", 0, 0x12300, 0x77))  # without such a queue the next read fails
refused(errno.EHOSTUNREACH, one.recv, 10)
one.settimeout(0)
refused(errno.EAGAIN, one.recv, 10)
"""


@pytest.mark.conforms("N-49")
@pytest.mark.parametrize("program", [MESSAGES, MISTAKES, ERRORS], ids=["messages", "mistakes", "errors"])
def test_sockets(bench: Bench, program: str) -> None:
    bench.run(sys.executable, "-c", BOUND + program)


@pytest.mark.conforms("N-49")
def test_python_s_own_tests(bench: Bench) -> None:
    pytest.importorskip("test.test_socket")
    process = bench.start(
        sys.executable,
        "-m",
        "unittest",
        "-v",
        "test.test_socket.J1939Test",
        options=("--interface", "vcan0=can0"),
    )
    _, said = process.communicate(timeout=LONG_S)
    assert process.returncode == 0, said
    assert "Ran 3 tests" in said
    assert "skipped" not in said


@pytest.mark.conforms("N-49")
def test_testj1939(bench: Bench) -> None:
    need("testj1939")
    receiver = bench.listening("stdbuf", "-oL", "testj1939", "-r", "can0:0x90")
    bench.run("testj1939", "-s20", "can0:0x80", "can0:0x90,0x12300")
    assert receiver.stdout is not None
    assert receiver.stdout.readline().split()[0] == "80"
    receiver.send_signal(signal.SIGTERM)


@pytest.mark.conforms("N-49")
def test_j1939cat(bench: Bench, tmp_path: Path) -> None:
    """Debian 12's has too little room for an error's control messages on 64 bits, and ends so (as on a kernel)."""
    need("j1939cat")
    data = bytes(k * 7 & 255 for k in range(5000))
    (tmp_path / "sent").write_bytes(data)
    with (tmp_path / "received").open("wb") as file:
        receiver = bench.listening("j1939cat", "can0:0x90", "-r", stdout=file)
        bench.start("j1939cat", "-i", str(tmp_path / "sent"), "can0:0x80", ":0x90,0x12300").wait(LONG_S)
        bench.until(lambda: (tmp_path / "received").read_bytes() == data)
    receiver.send_signal(signal.SIGTERM)


@pytest.mark.conforms("N-49")
def test_j1939spy_shows_what_is_on_the_bus(bench: Bench) -> None:
    need("j1939spy")
    spy = bench.listening("stdbuf", "-oL", "j1939spy", "-P", "can0")
    bench.run("cansend", "can0", "19233020#0102")
    assert spy.stdout is not None
    assert spy.stdout.readline() == " can0:20,12300 30 !6 [2] 0102\n"
    spy.send_signal(signal.SIGTERM)


@pytest.mark.conforms("N-49")
def test_j1939sr_carries_lines(bench: Bench) -> None:
    need("j1939sr")
    receiver = bench.listening("stdbuf", "-oL", "j1939sr", "can0:90", stdin=subprocess.PIPE)
    sender = bench.start("j1939sr", "can0:80", "can0:90,12300", stdin=subprocess.PIPE)
    assert sender.stdin is not None
    sender.stdin.write("a line of text\n")
    sender.stdin.flush()
    assert receiver.stdout is not None
    assert receiver.stdout.readline() == "a line of text\n"


@pytest.mark.conforms("N-49")
def test_j1939acd_claims_an_address(bench: Bench, tmp_path: Path) -> None:
    need("j1939acd")
    dump = bench.dump("can0", "-l", "-n", "2")
    daemon = bench.start("j1939acd", "-r", "100,80-120", "-c", str(tmp_path / "claims"), "11223344", "can0")
    assert frames(finished(dump)) == ["18EAFFFE#00EE00", "18EEFF50#4433221100000000"]
    daemon.send_signal(signal.SIGTERM)
    daemon.communicate(timeout=LONG_S)
