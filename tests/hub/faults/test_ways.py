"""Faults through a hub in this process and through one of its own: set, struck, waited for, listed, taken back."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from canwire import BadValue, CanwireError, ErrorKind, Frame, HubFault, NoSuchBoard, Unsupported
from canwire import connect as connect_to
from canwire.hub.handles.bus.can import CanBusFaults
from tests.hub.faults.bench import FRAME, IDEAL, LONG_S, OTHER, Program
from tests.hubs import Connect


@pytest.mark.conforms("N-07")
def test_a_flip_meets_a_program_s_frames_and_says_how_often(connect: Connect) -> None:
    hub = connect("tester")
    sender, receiver = Program(hub, IDEAL), Program(connect("other"), OTHER)
    fault = hub.bus("can0").faults.flip(bit=30, frame_id=0x123, times=3)
    assert (fault.struck, fault.times_left, fault.wait(0)) == (0, 3, False)
    sender.send(Frame(0x122, b"\x11"))
    sender.send()
    assert fault.wait(LONG_S)
    assert (fault.struck, fault.times_left) == (3, 0)
    got: list[int] = []
    while len(got) < 2:
        got += [frame.id for frame in receiver.frames()]
    assert got == [0x122, 0x123]
    assert hub.line_status(sender.place.board.id, 0).tec > 0
    assert receiver.lost() == 0
    assert fault.info().over == "used up"


def test_everybody_sees_whose_fault_it_is(connect: Connect) -> None:
    first, second = connect("first"), connect("second")
    faults = first.bus("can0").faults
    faults.noise(1e-9)
    faults.flip(bit=30, frame_id=0x7FF, extended=False, times=None, seen_by=OTHER)
    seen = second.bus("can0").faults.list()
    assert [fault.setter.partition(" ")[0] for fault in seen] == ["first", "first"]
    assert [(fault.kind, fault.text) for fault in seen] == [
        ("noise", "noise, 1e-09 of all bits"),
        ("flip", "flip bit 30 of standard 7FF, seen by HW000001:1, every time"),
    ]
    assert second.bus("can0").faults.clear() == 0
    assert second.bus("can0").faults.clear(left=True) == 0
    assert second.bus("can0").faults.clear(everybody=True) == 2
    assert faults.list() == ()


def test_faults_end_with_their_program_unless_they_are_persistent(connect: Connect) -> None:
    watching, leaving = connect("watching"), connect("leaving")
    faults = leaving.bus("can0").faults
    faults.noise(1e-9)
    faults.cable(10.0, persistent=True)
    leaving.close()
    there = watching.bus("can0").faults
    assert [(fault.kind, fault.persistent) for fault in there.list()] == [("cable", True)]
    assert there.clear() == 0
    assert there.clear(left=True) == 1
    assert there.list() == ()


def test_a_program_that_is_killed_takes_its_faults_along(hub_process: str) -> None:
    code = (
        "import canwire, sys\n"
        "hub = canwire.connect(sys.argv[1])\n"
        "hub.bus('can0').faults.disconnect('HW000001:0')\n"
        "print('set', flush=True)\n"
        "sys.stdin.read()\n"
    )
    with connect_to(hub_process, name="watching") as hub:
        there = hub.bus("can0").faults
        process = subprocess.Popen(
            [sys.executable, "-c", code, hub_process],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        with process:
            assert process.stdout is not None
            assert process.stdout.readline() == "set\n"
            assert [fault.kind for fault in there.list()] == ["disconnect"]
            process.kill()
        deadline = time.monotonic() + LONG_S
        while there.list():
            assert time.monotonic() < deadline


def test_a_fault_cleared_by_others_says_by_whom(connect: Connect) -> None:
    mine, other = connect("mine"), connect("other")
    fault = mine.bus("can0").faults.short()
    other.bus("can0").faults.clear(everybody=True)
    assert fault.wait(LONG_S)
    assert fault.info().over.startswith("cleared by other (")
    fault.cancel()
    assert (fault.struck, fault.times_left) == (1, 0)


def test_a_fault_that_lasts_so_long(connect: Connect) -> None:
    hub = connect("tester")
    fault = hub.bus("can0").faults.short(lasting=0.01)
    assert fault.wait(LONG_S)
    assert fault.info().over == "its time was over"


def test_cancel_keeps_the_count_and_is_idempotent(connect: Connect) -> None:
    hub = connect("tester")
    fault = hub.bus("can0").faults.hold("dominant", bits=None)
    fault.cancel()
    fault.cancel()
    assert fault.wait(0)
    assert (fault.info().over, fault.times_left) == ("cancelled", 0)
    assert hub.bus("can0").faults.list() == ()


ALL = [
    lambda faults: faults.flip(bit="ack"),
    lambda faults: faults.inject("crc", times=None),
    lambda faults: faults.noise(1e-6),
    lambda faults: faults.hold("recessive", at=faults.place("ack"), seen_by=[IDEAL, OTHER]),
    lambda faults: faults.play("01-", at=faults.place("eof", 2, frame_id=1, node=OTHER), times=2),
    lambda faults: faults.glitch("dominant", at=1 << 60, from_ns=100, width_ns=50),
    lambda faults: faults.move_edge(2, at=faults.place("frame", 13)),
    lambda faults: faults.short(),
    lambda faults: faults.disconnect(IDEAL),
    lambda faults: faults.drift(IDEAL, -300.0),
    lambda faults: faults.cable(40.0, node_delay_ns=75.0),
    lambda faults: faults.babble(0x7FF, b"\x01", gap=0.1),
]


@pytest.mark.conforms("N-07")
@pytest.mark.parametrize("number", range(len(ALL)))
def test_every_kind_can_be_set_and_taken_back(connect: Connect, number: int) -> None:
    faults = connect("tester").bus("can0").faults
    fault: HubFault = ALL[number](faults)
    (listed,) = faults.list()
    assert listed == fault.info()
    assert fault.info().over == ""
    fault.cancel()
    assert faults.list() == ()


WRONG = [
    (lambda faults: faults.flip(bit="nowhere"), BadValue, "bit 'nowhere'"),
    (lambda faults: faults.flip(bit=3, times=0), BadValue, "times 0"),
    (lambda faults: faults.flip(bit=3, seen_by=[IDEAL, OTHER]), BadValue, "one line"),
    (lambda faults: faults.flip(bit=3, seen_by="HW9:0"), NoSuchBoard, "no line 'HW9:0' on can0; there are HW000001:0"),
    (lambda faults: faults.inject("bang"), BadValue, "error 'bang'"),
    (lambda faults: faults.noise(1.5), BadValue, "bit_error_rate"),
    (lambda faults: faults.noise(0.1, lasting=-1.0), BadValue, "lasting"),
    (lambda faults: faults.hold("loud"), BadValue, "level 'loud'"),
    (lambda faults: faults.hold("dominant", at=0, bits=1, seen_by="sender"), BadValue, "already|at a time"),
    (lambda faults: faults.hold("dominant", at=faults.place("tail")), BadValue, "part 'tail'"),
    (lambda faults: faults.drift(IDEAL, 1e9), BadValue, "ppm"),
    (lambda faults: faults.wrong_rate(IDEAL, 250_000), CanwireError, "no bit rate yet"),
    (lambda faults: faults.cable(-1.0), BadValue, "length_m -1.0: from 0 to 10000"),
    (lambda faults: faults.cable(float("nan")), BadValue, "length_m nan"),
    (lambda faults: faults.cable(float("inf")), BadValue, "length_m inf"),
    (lambda faults: faults.cable(1e300), BadValue, "length_m 1e"),
    (lambda faults: faults.cable(1.0, node_delay_ns=float("nan")), BadValue, "node_delay_ns nan"),
    (lambda faults: faults.babble(times=0), BadValue, "times 0"),
]  # fmt: skip


@pytest.mark.finding("faults-2 9")
@pytest.mark.parametrize("number", range(len(WRONG)))
def test_what_no_fault_can_be_is_refused_and_leaves_nothing(connect: Connect, number: int) -> None:
    faults: CanBusFaults = connect("tester").bus("can0").faults
    act, error, text = WRONG[number]
    with pytest.raises(error, match=text):
        act(faults)
    assert faults.list() == ()


def test_buses_by_their_kind_and_name(connect: Connect) -> None:
    hub = connect("tester")
    with pytest.raises(NoSuchBoard, match="no bus 'can7'; there are can0, lin0"):
        hub.bus("can7")
    with pytest.raises(Unsupported, match="lin0 is a LIN bus: `lin_bus` gives it"):
        hub.bus("lin0")
    with pytest.raises(Unsupported, match="can0 is a CAN bus: `bus` gives it"):
        hub.lin_bus("can0")
    assert repr(hub.bus("can0")) == "<CAN bus can0>"
    assert repr(hub.lin_bus("lin0")) == "<LIN bus lin0>"


def test_lin_faults_are_those_of_the_lab(connect: Connect) -> None:
    faults = connect("tester").lin_bus("lin0").faults
    set_ones = [
        faults.checksum(3), faults.no_response(), faults.cut(2), faults.stop_bit(1), faults.flip(0, 3), faults.parity(),
        faults.short_break(9), faults.sync(0x50), faults.short("supply"), faults.disconnect("HW000001:2"),
    ]  # fmt: skip
    assert [fault.info().kind for fault in set_ones] == [
        "checksum", "no_response", "cut", "stop_bit", "flip", "parity", "short_break", "sync", "short", "disconnect",
    ]  # fmt: skip
    with pytest.raises(BadValue, match="octets 9"):
        faults.cut(9)
    assert faults.clear() == 10


def test_an_error_that_a_receiver_alone_sees(connect: Connect) -> None:
    hub = connect("tester")
    sender, receiver = Program(hub, IDEAL), Program(connect("other"), OTHER)
    fault = hub.bus("can0").faults.inject("crc", frame_id=FRAME.id)
    sender.send()
    assert fault.wait(LONG_S)
    events = receiver.received()
    assert ErrorKind.CRC in [item.error for item in events if not isinstance(item, Frame)]
    assert [item.id for item in events if isinstance(item, Frame)] == [0x123]
