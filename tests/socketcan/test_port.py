"""An interface is up while its line runs, and the program that sends on it notices both."""

from __future__ import annotations

import errno
import sys
from pathlib import Path

import pytest

import canwire
from canwire import WantedMode
from canwire.socketcan.interfaces import Interface, Interfaces
from canwire.socketcan.loop import Loop
from canwire.socketcan.port import Port
from canwire.socketcan.setting import Setting
from canwire.socketcan.table import Table
from canwire.socketcan.wire import Batch
from tests.hubs import LONG_S, stopped_meanwhile
from tests.socketcan.bench import Bench, finished

MANY = """
import socket, struct, sys
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("HW000001_0",))
count = 0
try:
    while True:
        wire.send(struct.pack("=IB3x8s", count % 2048, 0, b""))
        count += 1
except OSError:
    print(count, flush=True)
sys.stdin.readline()
"""
MANY_BY_BCM = """
import socket, struct, sys
manager = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_BCM)
manager.connect(("HW000001_0",))
TX_SEND = 4
for count in range(4200):
    head = struct.pack("@3I4l2I0q", TX_SEND, 0, 0, 0, 0, 0, 0, count % 2048, 1)
    manager.send(head + struct.pack("=IB3x8s", count % 2048, 0, b""))
print(count + 1, flush=True)
sys.stdin.readline()
"""
SENDER = """
import errno, socket, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("HW000001_0",))
wire.settimeout(30)
print("bound", flush=True)
while True:
    try:
        id, = struct.unpack_from("=I", wire.recv(16))
    except TimeoutError:
        break
    except OSError as error:
        print(errno.errorcode[error.errno], flush=True)
        continue
    try:
        wire.send(struct.pack("=IB3x8s", id + 1, 0, b""))
    except OSError as error:
        print(errno.errorcode[error.errno], flush=True)
    else:
        print(f"{id + 1:03X}", flush=True)
    if id == 0x7F0:
        break
"""


AGAIN = """
import errno, socket
BOUND = {"raw": (socket.SOCK_RAW, socket.CAN_RAW, ()), "isotp": (socket.SOCK_DGRAM, socket.CAN_ISOTP, (0x11, 0x12))}
def bound(kind):
    type, protocol, ids = BOUND[kind]
    wire = socket.socket(socket.AF_CAN, type, protocol)
    wire.settimeout(30)
    wire.bind(("HW000001_0", *ids))
    return wire
def read(wire):
    try:
        wire.recv(16)
    except OSError as error:
        print(errno.errorcode[error.errno], flush=True)
first = bound("raw")
print("bound", flush=True)
read(first)
read(bound("raw"))
read(bound("isotp"))
everything = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
everything.bind(("",))
everything.setblocking(False)
read(everything)
"""


class Told:
    """A listener that keeps what it hears of the interface itself."""

    def __init__(self) -> None:
        self.errors: list[int] = []

    def take(self, batch: Batch) -> None:
        del batch

    def congested(self) -> bool:
        return False

    def interface_lost(self, interface: Interface, error: int) -> None:
        del interface
        self.errors.append(error)


@pytest.mark.finding("socketcan 1")
def test_a_line_that_is_stopped_while_its_interface_is_opened_is_down(tmp_path: Path) -> None:
    """The hub counts a channel that hears nothing yet: candump was killed by its test's patience, one run in two."""
    pytest.importorskip("numpy")
    with canwire.connect(time="virtual") as hub:
        loop, table = Loop(), Table(str(tmp_path / "table"), b"test")
        interfaces = Interfaces(hub, table, {})
        setting = Setting(hub, loop, table, interfaces, WantedMode(), 0, lambda said: None)
        (interface,) = (one for one in interfaces.by_index.values() if one.name == "HW000001_0")
        with stopped_meanwhile(hub):
            port = Port(setting, interface, lambda lost: None)
        listener = Told()
        port.listeners.append(listener)
        port.tell_if_down(listener)
        assert listener.errors == [errno.ENETDOWN]
        port.close()
        table.close()
        loop.close()


@pytest.mark.finding("socketcan 1")
def test_a_bind_to_an_interface_that_is_down_is_told_by_the_next_read(bench: Bench) -> None:
    """As Linux has it; a socket bound to all of them just waits."""
    program = bench.start(sys.executable, "-c", AGAIN, stdout=-1)
    assert program.stdout is not None
    assert program.stdout.readline() == "bound\n"
    with bench.hub.open_control(bench.hub.board("HW000001").id, 0) as control:
        control.stop()
        assert finished(program).split() == ["ENETDOWN", "ENETDOWN", "ENETDOWN", "EAGAIN"]


def test_a_line_that_was_stopped_and_started_again_sends(bench: Bench) -> None:
    """In the soak one ENETDOWN was followed by ENETDOWN for every send until the end."""
    program = bench.start(sys.executable, "-c", SENDER, stdout=-1)
    assert program.stdout is not None
    assert program.stdout.readline() == "bound\n"
    hub = bench.hub
    own, other = hub.board("HW000001").id, hub.board("HW000002").id
    channel = hub.open_channel(other, 0)
    channel.set_up(canwire.ChannelMode(64, 64))
    channel.activate()
    with hub.open_control(other, 0) as control:
        control.initialise(canwire.LineMode(hub.boards()[1].lines[0].capabilities.timing(500_000)))
        control.start()
    for id in (0x100, 0x200, 0x7F0):
        with hub.open_control(own, 0) as control:
            control.stop()
            assert program.stdout.readline() == "ENETDOWN\n"
            control.start()
        channel.send(canwire.Frame(id))
        assert program.stdout.readline() == f"{id + 1:03X}\n"
    assert finished(program) == ""


@pytest.mark.parametrize("words", [MANY, MANY_BY_BCM], ids=["CAN_RAW", "CAN_BCM"])
def test_frames_that_an_interface_takes_with_it_are_counted(bench: Bench, words: str) -> None:
    """Those on the line that nobody acknowledges, and those that the server had no room for yet."""
    program = bench.start(sys.executable, "-c", words, stdin=-1)
    assert program.stdout is not None
    sent = int(program.stdout.readline())
    assert sent >= 4096
    bench.hub.unplug("HW000001")
    output, errors = program.communicate("\n", timeout=LONG_S)
    assert f"HW000001_0: {sent} frames were dropped, sent when the interface went (tx_dropped)\n" in errors
    assert (program.returncode, output) == (0, "")


CARRIER = """
import fcntl, socket, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.settimeout(20)
wire.setsockopt(socket.SOL_CAN_RAW, 2, 0x1FFFFFFF)
wire.bind(("HW000001_0",))
def up_and_running():
    flags, = struct.unpack_from("=H", fcntl.ioctl(wire, 0x8913, b"HW000001_0".ljust(40, b"\\0")), 16)
    return bool(flags & 0x1), bool(flags & 0x40)
print(*up_and_running(), flush=True)
wire.send(struct.pack("=IB3x8s", 0x123, 0, b""))
while struct.unpack_from("=I", wire.recv(16))[0] & 0x20000040 != 0x20000040:
    pass
print(*up_and_running(), flush=True)
"""


@pytest.mark.conforms("N-50")
@pytest.mark.finding("socketcan 16")
def test_an_interface_in_bus_off_is_up_and_does_not_run(bench: Bench) -> None:
    with bench.hub.bus("can0").faults.flip(frame_id=0x123, bit="crc delimiter", times=None, seen_by="sender"):
        program = bench.start(sys.executable, "-c", CARRIER)
        output = finished(program)
    assert output.split("\n")[:2] == ["True True", "True False"]
