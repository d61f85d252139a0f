"""What is said to a serial adapter and what is made of its answers: without I/O, in made-up time."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import BadValue, ErrorState, Frame, format_slcan_frame
from canwire.drivers.outside import DRIFT_PPM, AdapterClock, Trouble
from canwire.drivers.slcan_dongle.acceptance import pushed
from canwire.drivers.slcan_dongle.confinement import state_after
from canwire.drivers.slcan_dongle.conversation import NEVER, Conversation
from canwire.drivers.slcan_dongle.dialects import CANABLE, CANBUS, PLAIN, recognised
from canwire.drivers.slcan_dongle.port import parse_port
from canwire.drivers.slcan_dongle.session import POLL_NS, Session
from canwire.drivers.slcan_dongle.user import Adapter, Setup
from canwire.values.acceptance_orders import sja1000_dual
from tests.cases import each
from tests.effort import examples

MS = 1_000_000
SECOND = 1000 * MS
ANSWER_NS = 500 * MS
SETUP = Setup(500_000, "001C")
OPEN = [b"M00000000", b"mFFFFFFFF"]


def usual(line: bytes) -> bytes:
    """A CANBUS dongle's answer, whatever state it is in."""
    replies = {b"V": b"V1013\r", b"N": b"NA123\r", b"F": b"F00\r"}
    return replies.get(
        line, b"z\r" if line[:1] in (b"t", b"r") else b"Z\r" if line[:1] in (b"T", b"R") else b"\r"
    )


class Desk:
    """An adapter by script, and the session's user; `lines` are the commands that were said."""

    def __init__(self, answer: Any = usual, **options: Any) -> None:
        self.answer = answer
        self.wanted: Setup | None = None
        self.meant = True
        self.now_ns = 0
        self.lines: list[bytes] = []
        self.heard: list[tuple[Frame, int]] = []
        self.told: list[Any] = []
        self.to_send: list[bytes] = []
        self._half = b""
        self._coming: list[bytes] = []
        self.session = Session(self, lambda: self.talk.now_ns, self._rest, **options)
        self.talk = Conversation(self._write, self._received, ANSWER_NS)

    def begin(self, wanted: Setup | None = SETUP) -> Desk:
        self.wanted = wanted
        self.talk.begin(self.session.talk(), self.now_ns)
        return self.run()

    def run(self) -> Desk:
        """Until the adapter has nothing more to answer."""
        while self._coming:
            self.talk.feed(self._coming.pop(0), self.now_ns)
        return self

    def poke(self) -> Desk:
        self.talk.poke(self.now_ns)
        return self.run()

    def pass_time(self, span_ns: int) -> Desk:
        """With whatever is due in it."""
        end_ns = self.now_ns + span_ns
        while self.talk.deadline_ns <= end_ns:
            self.now_ns = max(self.now_ns, self.talk.deadline_ns)
            self.talk.tick(self.now_ns)
            self.run()
        self.now_ns = end_ns
        return self

    def said(self) -> list[bytes]:
        """Since the last time."""
        lines, self.lines = self.lines, []
        return lines

    def _write(self, data: bytes) -> None:
        *lines, self._half = (self._half + data).split(b"\r")
        for line in lines:
            self.lines.append(line)
            if reply := self.answer(line):
                self._coming.append(reply)

    def _received(self, frames: list[Frame], stamps: list[int]) -> None:
        self.heard += zip(frames, stamps, strict=True)

    def _rest(self, until_ns: int) -> None:
        self.talk.rest_until_ns = until_ns

    # session's User

    def met(self, adapter: Adapter) -> bool:
        self.told.append(adapter)
        return self.meant

    def opened(self) -> None:
        self.told.append("opened")

    def closed(self) -> None:
        self.told.append("closed")

    def next_frame(self) -> bytes | None:
        return self.to_send[0] if self.to_send else None

    def sent(self) -> None:
        self.told.append(("sent", self.to_send.pop(0)))

    def given_up(self) -> None:
        self.told.append(("given up", self.to_send.pop(0)))

    def flags(self, value: int) -> None:
        self.told.append(("F", value))

    def trouble(self, what: Trouble, text: str) -> None:
        self.told.append(what)

    def ready(self) -> bool:
        return True

    def hopeless(self, text: str) -> None:
        self.told.append("hopeless")
        self.talk.end()


def opened(answer: Any = usual, wanted: Setup = SETUP) -> Desk:
    desk = Desk(answer).begin(wanted)
    assert desk.told[1:] == ["opened"]
    desk.told.clear()
    desk.said()
    return desk


@pytest.mark.conforms("CT-02", "CT-14", "CT-15")
def test_a_session_starts_as_the_manual_says() -> None:
    desk = Desk().begin(None)

    assert desk.said() == [b"", b"", b"", b"V", b"N", b"C", b"Z1"]
    assert desk.told == [Adapter(CANBUS, "V1013", "A123")]

    desk.wanted = SETUP
    desk.poke()
    assert desk.said() == [b"S6", b"M00000000", b"mFFFFFFFF", b"O", b"F"]
    desk.wanted = None
    desk.poke()
    assert desk.said() == [b"C"]
    assert desk.told[1:] == ["opened", "closed"]


def test_an_adapter_that_has_been_told_to_stamp_is_not_told_again() -> None:
    """It remembers, in an EEPROM that wears out."""
    desk = Desk().begin()
    desk.talk.end()
    desk.said()
    desk.begin()

    assert b"Z1" not in desk.said()
    assert b"Z1" not in Desk(stamps=False).begin().said()


@pytest.mark.conforms("CT-03", "CT-04", "CT-12")
@each(
    ("setup", "commands"),
    [
        (Setup(125_000, "031C"), [b"S4"]),
        (Setup(800_000, "0016"), [b"S7"]),
        (Setup(125_000, "432F"), [b"s432F"]),
        (Setup(125_000, None), [b"S4"]),
        (Setup(500_000, "001C", enough=(1, 2)), [b"S6", b"M00000001", b"m00000002"]),
        (Setup(500_000, "001C", accept=(0x00006000, 0x00001FF0)), [b"S6", b"M00006000", b"m00001FF0"]),
    ],
)
def test_rates_and_filters(setup: Setup, commands: list[bytes]) -> None:
    assert [line for line in Desk().begin(setup).said()[7:] if line not in OPEN] == [*commands, b"O", b"F"]


@pytest.mark.conforms("PL-19")
def test_listen_only_is_another_command() -> None:
    assert Desk().begin(Setup(500_000, "001C", listen_only=True)).said()[-2:] == [b"L", b"F"]


def test_s7_may_be_told_otherwise() -> None:
    """Ruling 29."""
    desk = Desk(rates={750_000: b"7"})
    assert desk.begin(Setup(750_000, "4015")).said()[7] == b"S7"


def test_what_an_adapter_refuses_is_not_tried_for_ever() -> None:
    desk = Desk(lambda line: b"\a" if line[:1] == b"S" else usual(line)).begin()
    desk.pass_time(10 * SECOND)

    assert desk.told[1:] == [Trouble.REFUSED]
    assert desk.lines.count(b"S6") == 1
    desk.wanted = Setup(500_000, "432F")
    assert desk.poke().told[2:] == ["opened"]


@pytest.mark.conforms("CT-01", "CT-08", "CT-09")
@each("reply", [b"z\r", b"Z\r", b"\r"])
def test_one_frame_after_the_other_whatever_the_reply(reply: bytes) -> None:
    desk = opened(lambda line: None if line[:1] in (b"t", b"T", b"r", b"R") else usual(line))
    desk.to_send += [b"t10021133", b"T0000010021133", b"r1002", b"R000001000"]
    wanted = list(desk.to_send)

    desk.poke()
    for number in range(4):
        desk.poke()
        assert desk.lines == wanted[: number + 1]
        desk.talk.feed(reply, desk.now_ns)
    assert desk.told == [("sent", text) for text in wanted]


def test_frames_that_come_before_the_channel_is_closed_are_heard() -> None:
    """The adapter has acknowledged them, and so nobody sends them again."""
    desk = opened()
    heard: list[bool] = []

    def answer(line: bytes) -> bytes:
        heard.append(desk.session.hears)
        return usual(line)

    desk.answer = answer
    desk.wanted = Setup(250_000, "011C")
    desk.poke()
    assert desk.said()[:2] == [b"C", b"S5"]
    assert heard[:2] == [True, False]


@pytest.mark.conforms("CT-10", "CT-11")
def test_flags_are_asked_for_again_and_again() -> None:
    desk = opened(lambda line: b"F84\r" if line == b"F" else usual(line))

    desk.pass_time(10 * POLL_NS)
    assert desk.said() == [b"F"] * 10
    assert desk.told == [("F", 0x84)] * 10
    assert 500 * MS <= POLL_NS <= 1000 * MS


@pytest.mark.conforms("CT-11", "CT-18")
def test_a_full_queue_holds_frames_up() -> None:
    replies = iter([b"\a", b"\a", b"z\r"])
    desk = opened(
        lambda line: next(replies) if line[:1] == b"t" else b"F02\r" if line == b"F" else usual(line)
    )
    desk.to_send.append(b"t1230")
    desk.poke()

    assert desk.told == [("F", 2)]
    desk.pass_time(20 * MS)
    assert desk.said() == [b"t1230", b"F", b"t1230", b"F", b"t1230"]
    assert desk.told[-1] == ("sent", b"t1230")


def test_a_frame_that_is_refused_again_and_again_is_given_up() -> None:
    desk = opened(lambda line: b"\a" if line[:1] == b"t" else usual(line))
    desk.to_send += [b"t1230", b"T000001230"]
    desk.poke()

    assert [told for told in desk.told if told != ("F", 0)] == [
        Trouble.REFUSED,
        ("given up", b"t1230"),
        ("sent", b"T000001230"),
    ]


def test_a_channel_that_turns_out_to_be_closed_is_opened_again() -> None:
    """The adapter lost its power for a moment."""
    desk = opened()
    desk.answer = lambda line: b"\a" if line in (b"F", b"t1230") and b"O" not in desk.lines else usual(line)
    desk.to_send.append(b"t1230")
    desk.poke()

    assert desk.told[:2] == ["closed", "opened"]
    assert desk.said() == [b"t1230", b"F", b"S6", b"O", b"F", b"t1230"]


# answers that come late, that are wrong, that never come


@pytest.mark.conforms("CT-02")
def test_no_answer_one_event_and_it_goes_on() -> None:
    silent = [b"F"]
    desk = opened()
    desk.answer = lambda line: None if line in silent else usual(line)

    desk.pass_time(POLL_NS + ANSWER_NS)
    assert desk.said()[:5] == [b"F", b"", b"", b"", b"V"]
    silent.clear()
    desk.pass_time(3 * SECOND)
    assert [told for told in desk.told if told != ("F", 0)] == [Trouble.NO_ANSWER]
    desk.to_send.append(b"t1230")
    assert desk.poke().told[-1] == ("sent", b"t1230")


def test_a_late_answer_is_not_taken_for_another_one() -> None:
    desk = opened(lambda line: None if line[:1] == b"t" else usual(line))
    desk.to_send += [b"t1230", b"r4560"]
    desk.poke()
    desk.answer = lambda line: b"z\rV1013\r" if line == b"V" else usual(line)  # the late one before V's
    desk.pass_time(ANSWER_NS)

    assert [told for told in desk.told if told != ("F", 0)] == [
        ("given up", b"t1230"),
        Trouble.NO_ANSWER,
        ("sent", b"r4560"),
    ]


@each("reply", [b"V1013\r", b"F0\r", b"FXY\r", b"no sense\r", b"z\r", b"\xff\xfe\r"])
def test_a_wrong_answer_one_event_and_it_goes_on(reply: bytes) -> None:
    wrong = [reply]
    desk = opened()
    desk.answer = lambda line: wrong.pop() if line == b"F" and wrong else usual(line)
    desk.pass_time(3 * POLL_NS)

    assert [told for told in desk.told if told != ("F", 0)] == [Trouble.WRONG_ANSWER]
    assert ("F", 0) in desk.told


def test_always_wrong_answers_end_in_hopelessness() -> None:
    desk = opened()
    desk.answer = lambda line: b"N\r" if line == b"F" else usual(line)
    desk.pass_time(60 * SECOND)

    assert desk.told == [Trouble.WRONG_ANSWER, "hopeless"]
    assert len(desk.lines) < 30


def test_an_adapter_that_never_answers() -> None:
    desk = Desk(lambda line: None).begin()
    desk.pass_time(60 * SECOND)

    assert desk.told == [Trouble.NO_ANSWER, "hopeless"]
    desk.begin()  # the port is opened anew
    desk.pass_time(60 * SECOND)
    assert desk.told == [Trouble.NO_ANSWER, "hopeless", "hopeless"]


def test_an_adapter_that_vanishes_in_the_middle_of_a_line() -> None:
    desk = opened(lambda line: None if line[:1] == b"t" else usual(line))
    desk.to_send.append(b"t1230")
    desk.poke()
    desk.talk.feed(b"t12381122", desk.now_ns)
    desk.talk.end()

    assert desk.told == [("given up", b"t1230")]
    assert desk.heard == []
    desk.begin()
    desk.talk.feed(b"t1230\r", desk.now_ns)
    assert [frame for frame, _ in desk.heard] == [Frame(0x123)]


def test_another_adapter_in_its_place_is_left_alone() -> None:
    desk = Desk()
    desk.meant = False
    desk.begin()

    assert desk.told[1:] == ["hopeless"]
    assert b"O" not in desk.lines


# dialects


@pytest.mark.conforms("CT-22")
@each(
    ("version", "dialect"),
    [
        (b"V1013", CANBUS),
        (b"V1A0f", CANBUS),
        (b"canwire canable2", CANABLE),
        (b"CANable2-b158aa7 github.com/normaldotcom/canable2-fw.git", CANABLE),
        (b"V1.2.3-something", PLAIN),
        (b"F00", None),
        (b"NA123", None),
    ],
)
def test_dialects_are_recognised_by_their_version(version: bytes, dialect: Any) -> None:
    assert recognised(version) is dialect


@pytest.mark.conforms("CT-22")
def test_an_adapter_without_replies_is_not_waited_for() -> None:
    desk = Desk(lambda line: b"canable 2\r" if line == b"V" else None)
    desk.to_send += [b"d1009112233445566778899AABBCC", b"t1230"]
    desk.begin(Setup(500_000, None, data_bit_rate=2_000_000))

    assert desk.said()[3:] == [
        b"V",
        b"C",
        b"S6",
        b"Y2",
        b"M0",
        b"O",
        b"d1009112233445566778899AABBCC",
        b"t1230",
    ]
    assert desk.told[1:] == ["opened", ("sent", b"d1009112233445566778899AABBCC"), ("sent", b"t1230")]
    assert desk.talk.deadline_ns >= NEVER
    desk.to_send += [b"t1230"] * 1000
    desk.poke()
    assert 0 < len(desk.to_send) < 1000  # others have their turn
    assert desk.pass_time(MS).to_send == []


# what comes in

FRAMES = st.builds(
    lambda id, data, extended: Frame(id if extended else id & 0x7FF, data, extended=extended),
    st.integers(0, 0x1FFFFFFF),
    st.binary(max_size=8),
    st.booleans(),
)


def received(pieces: list[bytes]) -> Desk:
    desk = opened()
    for piece in pieces:
        desk.talk.feed(piece, desk.now_ns)
    return desk


def pieces_of(data: bytes, cuts: list[int]) -> list[bytes]:
    places = sorted({0, len(data), *(cut % (len(data) + 1) for cut in cuts)})
    return [data[one:other] for one, other in pairwise(places)]


@pytest.mark.conforms("CT-17", "CT-23", "CT-15")
@given(st.lists(st.tuples(FRAMES, st.integers(-1, 59_999)), max_size=20), st.lists(st.integers(0, 1 << 30)))
def test_frames_arrive_whatever_the_pieces(sent: list[tuple[Frame, int]], cuts: list[int]) -> None:
    data = b"".join(format_slcan_frame(frame, stamp) for frame, stamp in sent)

    assert received(pieces_of(data, cuts)).heard == sent
    assert received([bytes([byte]) for byte in data]).heard == sent


RUBBISH = st.lists(
    st.one_of(
        st.binary(max_size=40),
        st.sampled_from(
            [b"\r", b"\a", b"z\r", b"F00\r", b"V1013\r", b"t1230\r", b"NA123\r", b"T123\r", b"F"]
        ),
    ),
    max_size=30,
)


@pytest.mark.conforms("CT-02")
@given(RUBBISH, st.booleans(), st.lists(st.integers(0, SECOND), max_size=30))
@settings(deadline=None, max_examples=300)
def test_nothing_that_an_adapter_says_can_fail(pieces: list[bytes], is_open: bool, spans: list[int]) -> None:
    desk = opened() if is_open else Desk(lambda line: None).begin()
    desk.to_send += [b"t1230"] * 5
    for number, piece in enumerate(pieces):
        desk.talk.feed(piece, desk.now_ns)
        desk.run()
        if desk.talk.over:
            desk.begin()
        if number < len(spans):
            desk.pass_time(spans[number])
    for _ in range(100):
        desk.pass_time(SECOND)
        if desk.talk.over:
            desk.begin()
    desk.answer = usual
    desk.talk.end()
    desk.told.clear()
    desk.begin()
    assert "opened" in desk.told  # whatever has been


def test_a_line_without_end_takes_no_memory() -> None:
    desk = opened()
    for _ in range(100):
        desk.talk.feed(b"t" * 10_000, desk.now_ns)
    desk.talk.feed(b"\rt1230\r", desk.now_ns)

    assert desk.talk.malformed == 1
    assert len(desk.heard) == 1


# time stamps


@pytest.mark.conforms("CT-16", "PL-15")
@given(
    st.lists(
        st.tuples(
            st.integers(0, 200_000), st.integers(0, 20)
        ),  # ms since the one before; ms that it took to arrive
        min_size=1,
        max_size=60,
    ),
    st.integers(-100, 100),
    st.integers(0, 59_999),
)
def test_stamps_are_unwrapped_with_a_bounded_error(
    arrivals: list[tuple[int, int]], ppm: int, start_ms: int
) -> None:
    clock = AdapterClock(60_000 * MS)
    true_ns = arrived_ns = last_ns = 0
    for gap_ms, delay_ms in arrivals:
        true_ns += gap_ms * MS
        arrived_ns = max(arrived_ns, true_ns + delay_ms * MS)
        stamp_ms = (start_ms + round(true_ns * (1 + ppm * 1e-6)) // MS) % 60_000
        at_ns = clock.host_ns(stamp_ms * MS, arrived_ns)

        drift_ns = 2 * DRIFT_PPM * (arrived_ns + 60_000 * MS) // 1_000_000
        assert -2 * MS - drift_ns <= at_ns - true_ns <= 22 * MS + drift_ns
        assert last_ns <= at_ns <= max(arrived_ns, last_ns)
        last_ns = at_ns


@pytest.mark.conforms("CT-16")
def test_a_stamp_that_came_quickly_puts_later_ones_right() -> None:
    clock = AdapterClock(60_000 * MS)
    assert clock.host_ns(1000 * MS, 5 * SECOND + 30 * MS) == 5 * SECOND + 30 * MS
    assert clock.host_ns(1100 * MS, 5 * SECOND + 101 * MS) == 5 * SECOND + 101 * MS
    late = clock.host_ns(1200 * MS, 5 * SECOND + 290 * MS)
    assert 0 <= late - (5 * SECOND + 201 * MS) <= 1 * MS
    for minutes in (1, 2, 60):  # pauses longer than the counter
        arrived_ns = (5 + 60 * minutes) * SECOND + 301 * MS
        assert abs(clock.host_ns(1300 * MS, arrived_ns) - arrived_ns) <= DRIFT_PPM * 3600 * 1000


def test_a_clock_that_is_set_is_followed() -> None:
    clock = AdapterClock()
    assert clock.host_ns(1_700_000_000 * SECOND, 7 * SECOND) == 7 * SECOND
    assert clock.host_ns(1_600_000_000 * SECOND, 8 * SECOND) == 8 * SECOND
    assert clock.host_ns(1_700_000_000 * SECOND, 9 * SECOND) == 9 * SECOND


# F's bits, and where adapters are

A, W, P, OFF, _ = ErrorState


@pytest.mark.conforms("CT-10", "CT-11", "PL-18")
@each(
    ("flags", "states"),
    [
        ([0x04, 0x20, 0x20, 0x04], [W, P, W, A]),
        ([0x24, 0x24], [P, A]),
        ([0x24, 0x04, 0x04], [P, OFF, A]),
        ([0x80, 0x40, 0x0B], [A, A, A]),
    ],
)
def test_interrupts_tell_of_changes(flags: list[int], states: list[ErrorState]) -> None:
    state = A
    for value, wanted in zip(flags, states, strict=True):
        state = state_after(state, value)
        assert state is wanted


@pytest.mark.conforms("CT-21")
def test_ports_are_text() -> None:
    assert parse_port("/dev/ttyUSB0").url == "/dev/ttyUSB0"
    port = parse_port("COM3?baudrate=3000000&stamps=0&s7=750000&timeout=0.1&serial=A123")
    assert (port.url, port.baudrate, port.stamps, port.s7, port.answer_s, port.serial) == (
        "COM3",
        3_000_000,
        False,
        750_000,
        0.1,
        "A123",
    )
    assert parse_port("?serial=A123").url == ""


@pytest.mark.parametrize(
    "text",
    [
        "",
        "?",
        "/dev/x?speed=5",
        "/dev/x?baudrate=quick",
        "/dev/x?timeout=0",
        "socket://here",
        "socket://here:x",
    ],
)
def test_bad_ports(text: str) -> None:
    with pytest.raises(BadValue):
        parse_port(text)


@pytest.mark.conforms("PL-21")
@examples(100)
@given(
    st.lists(st.tuples(st.integers(0, 0xFFF), st.sampled_from([0, 0xFFF, 0xFF0, 0xF00])), max_size=4),
    st.lists(st.tuples(st.integers(0, 0x3FFFFFFF), st.sampled_from([0, 0x3FFFFFFF, 0x3FFF0000])), max_size=4),
    st.booleans(),
    st.binary(max_size=8),
    st.data(),
)
def test_the_adapters_filter_holds_up_nothing_that_should_pass(
    standard: list[tuple[int, int]],
    extended: list[tuple[int, int]],
    is_extended: bool,
    data: bytes,
    more: st.DataObject,
) -> None:
    """Held against the chip's own filter."""
    patterns = extended if is_extended else standard
    if not patterns:
        return
    value, mask = more.draw(st.sampled_from(patterns))
    value = value & mask | more.draw(st.integers(0, 0x3FFFFFFF if is_extended else 0xFFF)) & ~mask
    code, ignored = pushed(one_pattern(standard), one_pattern(extended))
    frame = Frame(
        value >> 1,
        b"" if value & 1 else data,
        extended=is_extended,
        remote=bool(value & 1),
        dlc=0 if value & 1 else None,
    )

    assert sja1000_dual(code.to_bytes(4, "big"), ignored.to_bytes(4, "big")).accepts(frame)


def one_pattern(patterns: list[tuple[int, int]]) -> tuple[int, int] | None:
    if not patterns:
        return None
    code, mask = patterns[0]
    for other, compared in patterns[1:]:
        mask &= compared & ~(code ^ other)
    return code & mask, mask


@pytest.mark.conforms("CT-13", "PL-21")
def test_one_identifier_is_held_by_both_filters() -> None:
    """0x123, data and remote: 00100100 011x."""
    assert pushed((0x246, 0xFFE), None) == (0x2460_2460, 0x001F_001F)
    assert pushed(None, None) == (0, 0xFFFFFFFF)
    assert pushed((0, 0), (0, 0)) == (0, 0xFFFFFFFF)


def test_fd_frames_are_heard_without_a_stamp() -> None:
    desk = Desk()
    desk.talk.feed(b"b12391122334455667788AABBCCDD\r", 0)
    frame = Frame(0x123, bytes.fromhex("1122334455667788AABBCCDD"), fd=True, bit_rate_switch=True)
    assert (desk.heard, desk.talk.malformed) == ([(frame, -1)], 0)
