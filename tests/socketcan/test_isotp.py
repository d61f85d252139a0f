"""ISO-TP between a sender and a receiver on a bus of this file, in a time of its own (ISO 15765-2)."""

from __future__ import annotations

import errno
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.socketcan.isotp import options as o
from canwire.socketcan.isotp.layout import gap_ns
from canwire.socketcan.isotp.options import Options
from canwire.socketcan.isotp.receiver import Receiver
from canwire.socketcan.isotp.sender import Sender, State
from tests.cases import each
from tests.effort import examples
from tests.socketcan.clock import Clock

FRAME_S = 0.0002


class Scene:
    """Each frame is on the bus FRAME_S after it was put there; `lose` swallows the receiver's answers."""

    def __init__(self, sends: Options, receives: Options | None = None) -> None:
        self.clock = Clock()
        self.frames: list[bytes] = []
        self.answers: list[bytes] = []
        self.messages: list[bytes] = []
        self.failed: list[int] = []
        self.over: list[int] = []
        self.lose = False
        self.sender = Sender(self.clock, self.put, self.over.append)
        self.receiver = Receiver(
            self.clock, self.answer, lambda data, _: self.messages.append(data), self.failed.append
        )
        self.sender.options = sends
        self.receiver.options = receives if receives is not None else sends

    def put(self, frame: bytes) -> None:
        self.frames.append(frame)

        def arrive() -> None:
            self.sender.confirm(1)
            self.receiver.take(frame, round(self.clock.now_s * 1e9))

        self.clock.call_in(FRAME_S, arrive)

    def answer(self, frame: bytes) -> None:
        self.answers.append(frame)
        ahead = self.sender.options.extended
        if not self.lose:
            self.clock.call_in(FRAME_S, lambda: self.sender.flow_control(frame[ahead:]))

    def send(self, data: bytes) -> None:
        self.sender.send(data)
        self.clock.run_for(60)


@st.composite
def any_options(draw: st.DrawFn) -> Options:
    flags = draw(st.sampled_from([0, o.TX_PADDING, o.EXTEND_ADDR, o.TX_PADDING | o.EXTEND_ADDR]))
    length = draw(st.sampled_from([8, 12, 20, 64]))
    return Options(
        flags=flags,
        length=length,
        mtu=72 if length > 8 else 16,
        block_size=draw(st.sampled_from([0, 1, 3, 8])),
        stmin=draw(st.sampled_from([0, 1, 0xF5])),
    )


@pytest.mark.conforms("PP-01")
@examples(100)
@given(any_options(), st.integers(1, 5000), st.randoms())
def test_messages_arrive_whole(options: Options, size: int, random: object) -> None:
    scene = Scene(options)
    data = bytes((k * 7 + 3) & 0xFF for k in range(size))
    scene.send(data)
    assert scene.messages == [data]
    assert scene.over == [0]
    assert scene.failed == []
    assert scene.sender.state is State.IDLE
    assert all(len(frame) in (*range(9), *o.LENGTHS) for frame in scene.frames)


@pytest.mark.conforms("PP-01")
def test_the_frames_of_a_message() -> None:
    scene = Scene(Options(block_size=2, stmin=5))
    scene.send(bytes(range(1, 28)))
    assert [frame.hex() for frame in scene.frames] == [
        "101b010203040506",
        "210708090a0b0c0d",
        "220e0f1011121314",
        "2315161718191a1b",
    ]
    assert [frame.hex() for frame in scene.answers] == ["300205", "300205"]


@each(
    ("options", "data", "frame"),
    [
        (Options(), "0102", "020102"),
        (Options(flags=o.TX_PADDING, tx_pad=0xAA), "0102", "020102aaaaaaaaaa"),
        (Options(flags=o.EXTEND_ADDR, address=0xF1), "0102", "f1020102"),
        (Options(mtu=72, length=64), "01020304050607", "0701020304050607"),
        (Options(mtu=72, length=64), "0102030405060708", "00080102030405060708cccc"),
    ],
)
def test_single_frames(options: Options, data: str, frame: str) -> None:
    scene = Scene(options)
    scene.send(bytes.fromhex(data))
    assert [one.hex() for one in scene.frames] == [frame]
    assert scene.messages == [bytes.fromhex(data)]


def test_a_message_longer_than_12_bits_can_tell() -> None:
    scene = Scene(Options())
    scene.send(bytes(5000))
    assert scene.frames[0][:6].hex() == "100000001388"


def test_nobody_answers() -> None:
    scene = Scene(Options())
    scene.lose = True
    scene.send(bytes(20))
    assert scene.over == [errno.ECOMM]
    assert scene.failed == [errno.ETIMEDOUT]


def test_the_sender_goes_silent() -> None:
    scene = Scene(Options())
    scene.receiver.take(bytes.fromhex("1014010203040506"), 0)
    scene.clock.run_for(0.9)
    assert scene.failed == []
    scene.clock.run_for(0.2)
    assert scene.failed == [errno.ETIMEDOUT]


@each(("answer", "error"), [("320000", errno.EMSGSIZE), ("3F0000", errno.EBADMSG), ("30", errno.EBADMSG)])
def test_answers_that_end_it(answer: str, error: int) -> None:
    scene = Scene(Options())
    scene.lose = True
    scene.sender.send(bytes(20))
    scene.clock.run_for(0.1)
    scene.sender.flow_control(bytes.fromhex(answer))
    assert scene.over == [error]


def test_wait_gives_another_second() -> None:
    scene = Scene(Options())
    scene.lose = True
    scene.sender.send(bytes(20))
    for _ in range(3):
        scene.clock.run_for(0.8)
        scene.sender.flow_control(bytes.fromhex("310000"))
    assert scene.over == []
    scene.sender.flow_control(bytes.fromhex("300000"))
    scene.clock.run_for(0.1)
    assert scene.over == [0]


@each(("frame_ms", "gap_s"), [(0, 0.020), (10, 0.030)])
def test_the_separation_time_is_kept_and_a_frame_s_own_added(frame_ms: int, gap_s: float) -> None:
    scene = Scene(Options(frame_time_ns=frame_ms * 1_000_000), Options(stmin=20))
    begun_s = scene.clock.now_s
    scene.sender.send(bytes(6 + 3 * 7))
    while not scene.over:
        scene.clock.run_for(0.001)
    assert 3 * gap_s <= scene.clock.now_s - begun_s < 3 * gap_s + 0.005


@each(
    ("stmin", "ns"),
    [(0, 0), (127, 127_000_000), (0x80, 127_000_000), (0xF1, 100_000), (0xF9, 900_000), (0xFA, 127_000_000)],
)
def test_separation_times(stmin: int, ns: int) -> None:
    assert gap_ns(stmin) == ns


def test_a_number_out_of_turn() -> None:
    scene = Scene(Options())
    scene.receiver.take(bytes.fromhex("1014010203040506"), 0)
    scene.receiver.take(bytes.fromhex("2207080910111213"), 0)
    assert scene.failed == [errno.EILSEQ]


def test_padding_is_checked_where_it_is_asked_for() -> None:
    options = Options(flags=o.RX_PADDING | o.CHK_PAD_LEN | o.CHK_PAD_DATA, rx_pad=0xAA)
    scene = Scene(Options(), options)
    scene.receiver.take(bytes.fromhex("020102aaaaaaaaaa"), 0)
    scene.receiver.take(bytes.fromhex("020102"), 0)
    scene.receiver.take(bytes.fromhex("020102aaaaaaaabb"), 0)
    assert scene.messages == [b"\x01\x02"]
    assert scene.failed == [errno.EBADMSG] * 2


def test_a_message_too_long_to_take_is_answered_so() -> None:
    scene = Scene(Options())
    scene.receiver.take(bytes.fromhex("1000000101d10102"), 0)
    assert [frame.hex() for frame in scene.answers] == ["320000"]


@given(st.binary(max_size=64), st.booleans())
def test_rubbish_delivers_nothing_wrong(frame: bytes, extended: bool) -> None:
    scene = Scene(Options(flags=o.EXTEND_ADDR if extended else 0))
    scene.receiver.take(frame, 0)
    assert all(len(message) < len(frame) for message in scene.messages)


def test_options_come_back_as_they_were_set() -> None:
    for name, value in (
        (o.OPTS, bytes(range(1, 13))),
        (o.RECV_FC, b"\x08\x05\x01"),
        (o.LL_OPTS, b"\x48\x40\x01"),
    ):
        assert Options().changed(name, value).value(name) == value
    assert replace(Options(), tx_stmin_ns=5).value(o.TX_STMIN) == b"\x05\0\0\0"
    for name, value in ((o.OPTS, bytes(11)), (o.LL_OPTS, b"\x10\x40\0"), (o.LL_OPTS, b"\x48\x09\0")):
        with pytest.raises(OSError, match="Invalid argument"):
            Options().changed(name, value)
