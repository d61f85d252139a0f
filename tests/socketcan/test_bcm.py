"""The broadcast manager's operations in a time of their own (networking/can.rst 4.2)."""

from __future__ import annotations

import struct
from dataclasses import replace

import pytest

from canwire.socketcan.bcm import message as m
from canwire.socketcan.bcm.message import Message
from canwire.socketcan.bcm.sending import Sending
from canwire.socketcan.bcm.watching import Watching
from tests.cases import each
from tests.socketcan.clock import Clock


def frame(data: str, can_id: int = 0x123) -> bytes:
    body = bytes.fromhex(data)
    return struct.pack("<IB3x", can_id, len(body)) + body.ljust(8, b"\0")


class Scene:
    """Everything that was sent and told, with the time since the beginning in ms."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.sent: list[tuple[int, str]] = []
        self.told: list[tuple[int, int, str]] = []

    def at_ms(self) -> int:
        return round((self.clock.now_s - 100) * 1000)

    def send(self, data: bytes) -> None:
        self.sent.append((self.at_ms(), data[8 : 8 + data[4]].hex()))

    def tell(self, message: Message, _: int = 0) -> None:
        data = message.frames[0][8 : 8 + message.frames[0][4]].hex() if message.frames else ""
        self.told.append((self.at_ms(), message.opcode, data))

    def sending(self, flags: int, count: int, first: float, second: float, *frames: str) -> Sending:
        setup = Message(m.TX_SETUP, flags, count, first, second, 0x123, tuple(map(frame, frames)))
        return Sending(self.clock, self.send, self.tell, setup)

    def watching(self, flags: int, first: float, second: float, *frames: str) -> Watching:
        setup = Message(m.RX_SETUP, flags, 0, first, second, 0x123, tuple(map(frame, frames)))
        return Watching(self.clock, self.send, self.tell, setup)


TIMED = m.SETTIMER | m.STARTTIMER


@pytest.mark.conforms("N-24")
def test_a_count_at_one_interval_and_then_another() -> None:
    scene = Scene()
    scene.sending(TIMED | m.TX_COUNTEVT, 3, 0.010, 0.100, "01", "02")
    scene.clock.run_for(0.230)
    assert scene.sent == [(0, "01"), (10, "02"), (20, "01"), (120, "02"), (220, "01")]
    assert scene.told == [(20, m.TX_EXPIRED, "")]


def test_a_change_of_data_keeps_the_times_and_more_frames_are_refused() -> None:
    scene = Scene()
    sending = scene.sending(TIMED, 0, 0, 0.010, "01")
    scene.clock.run_for(0.015)
    setup = Message(m.TX_SETUP, 0, 0, 0, 0, 0x123, (frame("AA"),))
    sending.change(setup)
    scene.clock.run_for(0.010)
    sending.change(replace(setup, flags=m.TX_ANNOUNCE, frames=(frame("BB"),)))
    scene.clock.run_for(0.010)
    assert scene.sent == [(0, "01"), (10, "01"), (20, "aa"), (25, "bb"), (30, "bb")]
    with pytest.raises(OSError, match="Argument list too long"):
        sending.change(replace(setup, frames=(frame("01"), frame("02"))))
    sending.stop()
    scene.clock.run_for(1)
    assert len(scene.sent) == 5


class Hub:
    """Takes what is repeated without end, or not."""

    def __init__(self, able: bool = True) -> None:
        self.able = able
        self.done: list[str] = []

    def repeat(self, data: bytes, interval_s: float) -> Hub | None:
        self.done.append(f"every {interval_s} s {data[8 : 8 + data[4]].hex()}")
        return self if self.able else None

    def replace(self, data: bytes) -> bool:
        self.done.append(f"now {data[8 : 8 + data[4]].hex()}")
        return True

    def stop(self) -> None:
        self.done.append("stop")


def test_the_hub_repeats_what_has_no_end() -> None:
    scene, hub = Scene(), Hub()
    setup = Message(m.TX_SETUP, TIMED, 2, 0.010, 0.100, 0x123, (frame("01"),))
    sending = Sending(scene.clock, scene.send, scene.tell, setup, hub.repeat)
    scene.clock.run_for(1)
    sending.change(Message(m.TX_SETUP, 0, 0, 0, 0, 0x123, (frame("02"),)))
    sending.stop()
    assert scene.sent == [(0, "01"), (10, "01")]
    assert hub.done == ["every 0.1 s 01", "now 02", "stop"]


def test_where_the_hub_cannot_it_is_asked_once() -> None:
    scene, hub = Scene(), Hub(able=False)
    setup = Message(m.TX_SETUP, TIMED, 0, 0, 0.100, 0x123, (frame("01"),))
    Sending(scene.clock, scene.send, scene.tell, setup, hub.repeat)
    scene.clock.run_for(0.35)
    assert [at_ms for at_ms, _ in scene.sent] == [0, 100, 200, 300]
    assert hub.done == ["every 0.1 s 01"]


def test_an_identifier_copied_into_the_frames() -> None:
    scene = Scene()
    sent: list[bytes] = []
    setup = Message(m.TX_SETUP, m.TX_CP_CAN_ID | m.TX_ANNOUNCE, 0, 0, 0, 0x321, (frame("01"),))
    Sending(scene.clock, sent.append, scene.tell, setup)
    assert m.id_of(sent[0]) == 0x321


@pytest.mark.conforms("N-25")
def test_only_changes_behind_the_mask_are_told() -> None:
    scene = Scene()
    watching = scene.watching(0, 0, 0, "F000")
    for data in ("1100", "1200", "22FF", "22FF", "2300", "3300"):
        watching.take(frame(data), 0)
    assert [told[2] for told in scene.told] == ["1100", "22ff", "3300"]


def test_the_length_counts_where_it_is_asked_for() -> None:
    scene = Scene()
    watching = scene.watching(m.RX_CHECK_DLC, 0, 0, "FF")
    for data in ("11", "1100", "1100"):
        watching.take(frame(data), 0)
    assert [told[2] for told in scene.told] == ["11", "1100"]


def test_multiplexed_frames() -> None:
    scene = Scene()
    watching = scene.watching(0, 0, 0, "FF00000000000000", "01FF000000000000", "02FF000000000000")
    for data in ("0110", "0220", "0110", "0111", "0330", "0220"):
        watching.take(frame(data), 0)
    assert [told[2] for told in scene.told] == ["0110", "0220", "0111"]


@pytest.mark.conforms("N-25")
def test_silence_is_told_and_the_end_of_it() -> None:
    scene = Scene()
    watching = scene.watching(TIMED | m.RX_ANNOUNCE_RESUME, 0.100, 0, "FF")
    scene.clock.run_for(0.050)
    watching.take(frame("11"), 0)
    scene.clock.run_for(0.120)
    watching.take(frame("11"), 0)
    assert scene.told == [
        (50, m.RX_CHANGED, "11"),
        (150, m.RX_TIMEOUT, ""),
        (170, m.RX_CHANGED, "11"),
    ]


@pytest.mark.conforms("N-25")
def test_throttled_changes_come_late_and_once() -> None:
    scene = Scene()
    watching = scene.watching(m.SETTIMER, 0, 0.100, "FF")
    for data in ("01", "02", "03"):
        watching.take(frame(data), 0)
        scene.clock.run_for(0.010)
    scene.clock.run_for(0.300)
    watching.take(frame("04"), 0)
    assert scene.told == [
        (0, m.RX_CHANGED, "01"),
        (100, m.RX_CHANGED, "03"),
        (330, m.RX_CHANGED, "04"),
    ]


def test_a_remote_frame_is_answered() -> None:
    scene = Scene()
    watching = scene.watching(m.RX_RTR_FRAME, 0, 0, "4711")
    watching.take(frame("", 0x4000_0123), 0)
    assert scene.sent == [(0, "4711")]
    assert scene.told == []


def test_messages_as_bytes() -> None:
    message = Message(m.TX_SETUP, TIMED, 5, 0.5, 1.25, 0x123, (frame("01"), frame("02")))
    assert Message.parse(message.pack()) == message
    assert len(message.pack()) == message.size == 56 + 32


@each(
    "data",
    [
        b"",
        bytes(55),
        Message(m.TX_SETUP, 0, 0, 0, 0, 1, (frame("01"),)).pack()[:-1],
        Message(m.TX_SEND, 0, 0, 0, 0, 1, (frame("01"),)).pack() + bytes(16),
        Message(m.TX_SETUP, 0, 0, 0, 0, 1, (frame("01")[:4] + b"\x09" + bytes(11),)).pack(),
        struct.pack("<III4xqqqqII", m.TX_SETUP, 0, 0, -1, 0, 0, 0, 1, 0),
        struct.pack("<III4xqqqqII", m.TX_SETUP, 0, 0, 0, 1_000_000, 0, 0, 1, 0),
    ],
)
def test_broken_messages_are_refused(data: bytes) -> None:
    with pytest.raises(OSError, match="Invalid argument"):
        Message.parse(data)
