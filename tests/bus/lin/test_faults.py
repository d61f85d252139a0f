"""Each disturbance and what master, slave and listener see of it; the list of the conformance tests."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from canwire import BadValue, Lab, LabLinBus, LabLinNode, LinErrorKind, LinEventKind, LinFrame, LinOutcome
from tests.cases import each

pytestmark = pytest.mark.core

BIT_NS = 50_000
NONE: list[str] = []


class Scene:
    """A master, a slave that answers 0x10 and one that listens, at 20 kbit/s; the slaves may have crystals."""

    def __init__(self, lab: Lab, *, crystals: bool = False) -> None:
        self.lab = lab
        self.bus: LabLinBus = lab.lin_bus(bit_rate=20_000)
        slave: dict[str, Any] = {"responses": {0x10: b"\1\2"}, "subscribes": {0x11: 2}}
        self.slave = self.bus.slave("slave", synchronises=not crystals, **slave)
        self.listener = self.bus.slave("listener", synchronises=not crystals, subscribes={0x10: 2})
        self.master = self.bus.master()
        for node in (self.slave, self.listener, self.master):
            node.events()

    def errors(self, node: LabLinNode) -> list[str]:
        return [event.error.name for event in node.events(LinEventKind.ERROR)]

    def all_errors(self) -> tuple[list[str], list[str], list[str]]:
        return self.errors(self.master), self.errors(self.slave), self.errors(self.listener)


@pytest.fixture
def scene(lab: Lab) -> Scene:
    return Scene(lab)


@pytest.mark.conforms("X4-45")
@pytest.mark.parametrize(
    ("disturb", "master", "slave", "listener"),
    [
        (lambda faults: faults.checksum(0x10), ["CHKSUM"], NONE, ["CHKSUM"]),
        (lambda faults: faults.no_response(0x10), ["SLNORE"], NONE, ["SLNORE"]),
        (lambda faults: faults.cut(1), ["OTHER"], NONE, ["OTHER"]),
        (lambda faults: faults.cut(0), ["SLNORE"], NONE, ["SLNORE"]),
        (lambda faults: faults.stop_bit(1), ["OTHER"], NONE, ["OTHER"]),
        (lambda faults: faults.flip(0, 3), ["OTHER"], ["BIT"], ["OTHER"]),
        (lambda faults: faults.flip(2, 0), ["CHKSUM"], ["BIT"], ["CHKSUM"]),
        (lambda faults: faults.parity(), ["SLNORE"], ["PARITY"], ["PARITY"]),
        (lambda faults: faults.short_break(), ["SLNORE"], NONE, NONE),
        (lambda faults: faults.short_break(3), ["SLNORE"], NONE, NONE),
        (lambda faults: faults.short_break(9), ["SLNORE"], NONE, NONE),
        (lambda faults: faults.sync(0x54), ["SLNORE"], ["SYNC"], ["SYNC"]),
        (lambda faults: faults.sync(0x5D), ["SLNORE"], ["SYNC"], ["SYNC"]),
    ],
)
@pytest.mark.parametrize("crystals", [False, True])
def test_who_sees_what(
    lab: Lab,
    disturb: Callable[[object], object],
    master: list[str],
    slave: list[str],
    listener: list[str],
    crystals: bool,
) -> None:
    scene = Scene(lab, crystals=crystals)
    disturb(scene.bus.faults)
    scene.master.ask(0x10, 2)
    scene.lab.run_until_idle()
    assert scene.all_errors() == (master, slave, listener)
    assert (scene.master.receive(), scene.listener.receive()) == (None, None)
    scene.master.ask(0x10, 2)
    scene.lab.run_until_idle()
    assert scene.all_errors() == ([], [], [])
    assert scene.master.receive() == scene.listener.receive() == LinFrame(0x10, b"\1\2")


@each(
    ("value", "measured", "read"),
    [
        (0x54, 24, 24),  # the identifier's start bit is the fifth fall, and too late for one
        (0xF0, 26, 24),  # the identifier's is the second one, and 12 bits are over
        (0xFF, 26, 24),
    ],
)
@each("crystals", [False, True])
def test_a_wrong_sync_field_is_told_as_soon_as_it_is_one(
    value: int, measured: int, read: int, crystals: bool
) -> None:
    """Whoever measures its falls knows that by the fifth of them, at the latest after 12 bits; else by its last bit."""
    with Lab() as lab:
        scene = Scene(lab, crystals=crystals)
        scene.bus.faults.sync(value)
        scene.master.ask(0x10, 2)
        lab.run_until_idle()
        for node in (scene.slave, scene.listener):
            (error,) = node.events(LinEventKind.ERROR)
            assert (error.error, error.timestamp_ns) == (
                LinErrorKind.SYNC,
                (read if crystals else measured) * BIT_NS,
            )


def test_a_rate_that_a_slave_cannot_follow_is_told_at_the_fifth_fall(lab: Lab) -> None:
    bus = lab.lin_bus(bit_rate=20_000)
    slave = bus.slave("fast", oscillator_ppm=170_000)
    slave.events()
    bus.master().ask(0x10)
    lab.run_until_idle()
    (error,) = slave.events(LinEventKind.ERROR)
    assert (error.error, error.timestamp_ns) == (LinErrorKind.SYNC, (14 + 8) * BIT_NS)


@each(("bits", "headers"), [(9, 0), (10, 0), (11, 1), (12, 1)])
def test_a_fast_slave_measures_a_break_once_more_by_the_master_s_bits(bits: int, headers: int) -> None:
    """By its own clock 10 bits of the master are 11.3, and a break."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave("fast", oscillator_ppm=130_000)
        slave.events()
        master = bus.master()
        bus.faults.short_break(bits)
        master.ask(0x10)
        lab.run_until_idle()
        assert (slave.counters.headers, slave.events(LinEventKind.ERROR)) == (headers, [])
        master.ask(0x10)
        lab.run_until_idle()
        assert slave.counters.headers == headers + 1


@pytest.mark.parametrize("bits", [11, 13, 26, 60])
def test_breaks_that_slaves_take(scene: Scene, bits: int) -> None:
    scene.bus.faults.short_break(bits)
    scene.master.ask(0x10)
    assert scene.master.expect(0x10, within=0.1).timestamp_ns == (bits + 21 + 30) * BIT_NS


def test_a_master_request_with_a_short_break_is_ignored(scene: Scene) -> None:
    """PT-CT 8: and the slave response header behind it goes unanswered."""
    scene.bus.faults.short_break(9, 0x3C)
    scene.master.send(LinFrame(0x3C, b"\1\6\xb2\0\xff\x7f\xff\xff"))
    scene.master.ask(0x3D, 8)
    scene.lab.run_until_idle()
    assert scene.slave.receive() is None
    assert scene.errors(scene.master) == ["SLNORE"]


def test_faults_choose_frames_and_count(scene: Scene) -> None:
    faults = scene.bus.faults
    faults.checksum(0x11, times=1)
    faults.no_response(0x10, times=2)
    for _ in range(3):
        scene.master.ask(0x10, 2)
    scene.lab.run_until_idle()
    assert scene.errors(scene.master) == ["SLNORE", "SLNORE"]
    assert len(scene.master.receive_many(9)) == 1
    scene.master.send(LinFrame(0x11, b"\1\2"))
    scene.lab.run_until_idle()
    assert scene.errors(scene.slave) == ["CHKSUM"]
    faults.checksum(times=None)
    for _ in range(3):
        scene.master.ask(0x10, 2)
    scene.lab.run_until_idle()
    assert scene.errors(scene.listener)[-3:] == ["CHKSUM"] * 3
    faults.clear()
    scene.master.ask(0x10, 2)
    scene.lab.run_until_idle()
    assert scene.errors(scene.listener) == []


@pytest.mark.conforms("X4-45")
@pytest.mark.parametrize("to", ["ground", "supply"])
def test_a_shorted_wire_takes_no_level(scene: Scene, to: str) -> None:
    scene.bus.faults.short(to)
    outcomes: list[LinOutcome] = []
    scene.lab.run_for(0.01)
    scene.master.line.ask(0x10, 0, outcomes.append)
    scene.lab.run_for(0.1)
    assert outcomes == [LinOutcome.FAILED]
    assert scene.errors(scene.master) == ["NOBUS"]
    assert scene.master.counters.status & 0x08  # bus-off
    assert scene.slave.counters.headers == 0
    scene.bus.faults.clear_short()
    scene.lab.run_for(0.01)
    scene.master.ask(0x10, 2)
    assert scene.master.expect(0x10, within=0.1).data == b"\1\2"
    assert scene.master.counters.status == 0


def test_a_short_in_the_middle_of_a_frame(scene: Scene) -> None:
    scene.master.ask(0x10, 2)
    scene.lab.run_until(46 * BIT_NS)
    scene.bus.faults.short()
    scene.lab.run_until(100 * BIT_NS)
    scene.bus.faults.clear_short()
    scene.lab.run_until_idle()
    assert scene.all_errors() == (["OTHER"], ["BIT"], ["OTHER"])
    scene.master.ask(0x10, 2)
    assert scene.master.expect(0x10, within=0.1).data == b"\1\2"


@pytest.mark.parametrize("hundredths", [25, 49])
def test_a_glitch_is_no_start_bit(scene: Scene, hundredths: int) -> None:
    scene.master.ask(0x11)
    scene.lab.run_until(36 * BIT_NS)
    scene.bus.faults.short()
    scene.lab.run_until(36 * BIT_NS + hundredths * BIT_NS // 100)
    scene.bus.faults.clear_short()
    scene.lab.run_until_idle()
    assert scene.errors(scene.master) == ["SLNORE"]


def test_a_plug_that_is_pulled(scene: Scene) -> None:
    scene.bus.faults.disconnect(scene.slave)
    scene.master.ask(0x10, 2)
    scene.lab.run_until_idle()
    assert scene.errors(scene.master) == ["SLNORE"]
    scene.bus.faults.reconnect(scene.slave)
    scene.master.ask(0x10, 2)
    scene.master.expect(0x10, within=0.1)


@pytest.mark.parametrize("at", [5, 20, 30, 36, 45, 60])
def test_a_slave_that_leaves_in_the_middle(scene: Scene, at: int) -> None:
    """Its dominant bits end at once; whatever comes of that, nobody hangs."""
    scene.master.ask(0x10, 2)
    scene.lab.run_until(at * BIT_NS)
    scene.slave.stop()
    scene.lab.run_until_idle()
    (error,) = scene.errors(scene.master)
    assert error == ("SLNORE" if at < 34 else "OTHER" if at < 54 else "CHKSUM")
    scene.slave.start()
    scene.master.ask(0x10, 2)
    scene.master.expect(0x10, within=0.1)


@pytest.mark.parametrize("at", [5, 16, 30])
def test_a_master_that_leaves_in_the_middle_of_its_header(scene: Scene, at: int) -> None:
    scene.master.ask(0x10, 2)
    scene.lab.run_until(at * BIT_NS)
    scene.master.stop()
    scene.lab.run_until_idle()
    assert scene.slave.counters.frames_sent == 0
    scene.master.start()
    scene.master.ask(0x10, 2)
    scene.master.expect(0x10, within=0.1)


# the response-error bit (LIN 2.2A 2.7.3)


@pytest.mark.parametrize(
    ("disturb", "frame", "expected"),
    [
        (lambda faults: faults.checksum(), 0x11, True),  # 3, 37, 41
        (lambda faults: faults.stop_bit(0), 0x11, True),  # 40, 48
        (lambda faults: faults.cut(1), 0x11, True),  # 11.4
        (lambda faults: faults.flip(0, 1), 0x10, True),  # 38, 49: its own response
        (lambda faults: faults.no_response(), 0x11, False),  # 11.3
        (lambda faults: faults.checksum(), 0x12, False),  # 12: unknown to this slave
        (lambda faults: faults.stop_bit(0), 0x12, False),
        (lambda faults: faults.parity(), 0x11, False),  # 39
        (lambda faults: faults.checksum(), 0x3E, False),  # 34
        (lambda faults: faults.short_break(), 0x11, False),  # 11.1
        (lambda faults: faults.sync(), 0x11, False),
    ],
)
def test_what_sets_the_response_error(
    scene: Scene, disturb: Callable[[object], object], frame: int, expected: bool
) -> None:
    disturb(scene.bus.faults)
    if frame == 0x10:
        scene.master.ask(frame)
    else:
        scene.master.send(LinFrame(frame, b"\1\2"))
    scene.lab.run_until_idle()
    assert scene.slave.response_error == expected


def test_the_response_error_is_cleared_once_it_was_told(lab: Lab) -> None:
    bus = lab.lin_bus()
    slave = bus.slave(responses={0x10: b"\0\0", 0x11: b"\7"}, subscribes={0x12: 1}, response_error=(0x10, 9))
    master = bus.master()
    master.ask(0x10)
    assert master.expect(0x10, within=1).data == b"\0\0"
    bus.faults.checksum()
    master.send(LinFrame(0x12, b"\1"))
    lab.run_until_idle()
    assert slave.response_error
    master.send(LinFrame(0x12, b"\1"))  # a good one does not clear it
    master.ask(0x11)
    lab.run_until_idle()
    assert slave.response_error
    bus.faults.flip(1, 2, 0x10)
    master.ask(0x10)
    lab.run_until_idle()
    assert slave.response_error  # it did not get through
    master.ask(0x10)
    assert master.expect(0x10, within=1).data == b"\0\2"
    assert not slave.response_error
    master.ask(0x10)
    assert master.expect(0x10, within=1).data == b"\0\0"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda faults: faults.checksum(64), "frame_id 64: from 0 to 63"),
        (lambda faults: faults.parity(times=0), "times 0: at least 1"),
        (lambda faults: faults.short_break(0), "bits 0: from 1 to 60"),
        (lambda faults: faults.sync(256), "value 256"),
        (lambda faults: faults.cut(9), "octets 9"),
        (lambda faults: faults.flip(0, 8), "bit 8: from 0 to 7"),
        (lambda faults: faults.flip(9), "octet 9"),
        (lambda faults: faults.stop_bit(-1), "octet -1"),
        (lambda faults: faults.short("battery"), "to 'battery': 'ground' or 'supply'"),
    ],
)
def test_what_no_fault_can_be(scene: Scene, call: Callable[[object], object], message: str) -> None:
    with pytest.raises(BadValue, match=message):
        call(scene.bus.faults)


def test_faults_in_frames_that_are_too_short_for_them(scene: Scene) -> None:
    scene.bus.faults.flip(8, 0)
    scene.bus.faults.stop_bit(8)
    scene.master.ask(0x10)
    scene.master.ask(0x10)
    scene.lab.run_until_idle()
    assert len(scene.master.receive_many(9)) == 2


def test_errors_add_up_to_the_limit(scene: Scene) -> None:
    scene.bus.faults.checksum(times=None)
    for _ in range(260):
        scene.master.ask(0x10)
    scene.lab.run_until_idle()
    assert scene.master.counters.errors[LinErrorKind.CHKSUM] == 260
    assert scene.master.counters.status == 0x04
    assert len(scene.master.events(LinEventKind.STATE)) == 1
    scene.master.stop()
    scene.master.start()
    assert scene.master.counters.status == 0
