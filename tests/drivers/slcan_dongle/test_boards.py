"""Boards that are serial adapters: a scripted one on a pseudo terminal or TCP; two emulated dongles back to back."""

from __future__ import annotations

import itertools
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import (
    BadConfig,
    BadValue,
    BitTiming,
    ChannelMode,
    ErrorKind,
    ErrorState,
    Event,
    EventKind,
    Frame,
    Hub,
    InUse,
    LineMode,
    NoSuchBoard,
    Unplugged,
    Unsupported,
)
from canwire.boards.config.configuration import Config
from canwire.drivers.outside import Trouble
from canwire.drivers.slcan_dongle import driver, link, session
from canwire.drivers.slcan_dongle.conversation import Conversation
from canwire.drivers.slcan_dongle.driver import SlcanDriver
from canwire.platform import wait_readable
from canwire.values.frame import record_to_send
from tests.cases import each
from tests.drivers.outside_bench import (
    AGES_S,
    TIMING,
    Program,
    a_frame,
    fresh_hub,
    gone,
    is_event,
    on_bus,
    trouble,
)
from tests.drivers.slcan_dongle.fake_dongle import FakeDongle, FakeServer, usual


@pytest.fixture
def hub() -> Iterator[Hub]:
    made = fresh_hub()
    yield made
    made.close()


@pytest.fixture
def dongle(tmp_path: Path) -> Iterator[FakeDongle]:
    made = FakeDongle(tmp_path / "ttyCANBUS0")
    yield made
    made.vanish()


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drivers ask an adapter for its flags, and look for a lost one, twenty times as often as they do otherwise."""
    monkeypatch.setitem(SlcanDriver.__init__.__kwdefaults__, "poll_ns", session.POLL_NS // 20)
    monkeypatch.setattr(driver, "_BACK_OFF_S", 0.05)


def port_of(dongle: FakeDongle, options: str = "?timeout=5") -> str:
    return f"{dongle.link}{options}"


@pytest.mark.realtime
@pytest.mark.conforms("CT-02", "CT-14", "CT-21", "PL-15")
def test_a_board_comes_to_life(hub: Hub, dongle: FakeDongle) -> None:
    program = Program(hub, hub.plug("slcan", port=port_of(dongle)))
    assert program.status().state == ErrorState.STOPPED
    program.start()
    program.send(
        Frame(0x100, b"\x11\x33"), Frame(0x100, b"\x11", extended=True), Frame(0x7, remote=True, dlc=2)
    )
    frames = [program.wait(a_frame)[-1] for _ in range(3)]
    dongle.say(b"t20021133\rT1234567800010\r")
    frames += [program.wait(a_frame)[-1] for _ in range(2)]

    assert dongle.lines[:8] == [b"", b"", b"", b"V", b"N", b"C", b"Z1", b"S6"]
    assert dongle.lines[8:12] == [b"M00000000", b"mFFFFFFFF", b"O", b"F"]
    assert dongle.lines[12:15] == [b"t10021133", b"T00000100111", b"r0072"]
    assert [frame.self_received for frame in frames] == [True] * 3 + [False] * 2
    assert frames[3:] == [Frame(0x200, b"\x11\x33"), Frame(0x12345678, extended=True)]
    assert all(
        one.timestamp_ns <= other.timestamp_ns <= hub.now_ns() for one, other in itertools.pairwise(frames)
    )
    status = program.status()
    assert (status.state, status.frames_sent, status.frames_received) == (ErrorState.ERROR_ACTIVE, 3, 2)
    info = hub.board("slcan")
    assert dict(info.resources)["Version"] == "V1013"
    assert dict(info.resources)["Serial number"] == "A123"
    assert (info.hardware_version, info.firmware_version) == ((1, 0, 0, 0), (1, 3))
    program.control.close()
    program.channel.close()
    dongle.wait_for(b"C", 2)


@pytest.mark.realtime
@pytest.mark.conforms("CT-21")
def test_one_behind_a_tcp_port(hub: Hub) -> None:
    server = FakeServer()
    program = Program(hub, hub.plug("slcan", port=server.port)).start()
    program.send(Frame(0x123))

    assert program.wait(a_frame)[-1] == Frame(0x123)
    assert b"t1230" in server.lines
    server.close()


@pytest.mark.realtime
@pytest.mark.conforms("CT-21")
def test_a_line_stopped_and_started_while_its_adapter_answers_is_on_the_bus_again(
    hub: Hub, dongle: FakeDongle, impatient: None
) -> None:
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    asked, goes_on = threading.Event(), threading.Event()

    def slow(line: bytes) -> bytes:
        if line == b"F":
            asked.set()
            assert goes_on.wait(AGES_S)
        return usual(line)

    dongle.answer = slow
    assert asked.wait(AGES_S)
    program.control.stop()
    program.control.start()
    goes_on.set()
    program.wait(on_bus)
    assert program.status().state == ErrorState.ERROR_ACTIVE


class Opaque:
    """A port of pyserial's without a descriptor, as on Windows."""

    def __init__(self, where: str, baudrate: int) -> None:
        self._descriptor = os.open(where, os.O_RDWR | os.O_NOCTTY)
        self.in_waiting = 4096

    def read(self, count: int) -> bytes:
        if not wait_readable([self._descriptor], 0.05):
            return b""
        data = os.read(self._descriptor, count)
        if not data:
            raise OSError("it ended")
        return data

    def write(self, data: bytes) -> None:
        os.write(self._descriptor, data)

    def close(self) -> None:
        os.close(self._descriptor)


@pytest.mark.realtime
@pytest.mark.conforms("CT-21", "PL-14")
def test_a_port_without_a_descriptor_has_threads(
    hub: Hub, dongle: FakeDongle, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link, "open_port", Opaque)
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    program.send(*[Frame(k) for k in range(50)])
    assert [program.wait(a_frame)[-1].id for _ in range(50)] == list(range(50))
    dongle.say(b"t1230\r" * 1000)
    assert [program.wait(a_frame)[-1].id for _ in range(1000)] == [0x123] * 1000
    dongle.vanish()
    program.wait(gone)
    dongle.appear()
    program.wait(on_bus)


@pytest.mark.realtime
@pytest.mark.conforms("CT-14")
def test_one_is_found_by_its_own_number(
    hub: Hub, dongle: FakeDongle, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = FakeDongle(tmp_path / "other", lambda line: b"NB777\r" if line == b"N" else usual(line))
    mute = FakeDongle(tmp_path / "mute", lambda line: None)
    listed = [(str(one.link), "") for one in (dongle, other, mute)]
    monkeypatch.setattr(link, "listed_ports", lambda: listed)
    program = Program(hub, hub.plug("slcan", port="?serial=A123&timeout=1"))
    program.control.start()

    assert not [one for one in program.wait(on_bus) if is_event(one, EventKind.ERROR)]
    assert b"O" not in other.lines + mute.lines
    assert dict(hub.board("slcan").resources)["Port"] == str(dongle.link)
    other.vanish()
    mute.vanish()


@pytest.mark.realtime
@pytest.mark.conforms("PL-14")
def test_one_is_found_again_by_its_usb_number(
    hub: Hub, dongle: FakeDongle, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = [(str(dongle.link), "FT123")]
    monkeypatch.setattr(link, "listed_ports", lambda: list(listed))
    monkeypatch.setattr(link, "usb_serial_of", lambda where: dict(listed).get(where, ""))
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    dongle.vanish()
    program.wait(gone)
    listed[:] = [(str(dongle.link), "FT999"), (str(tmp_path / "elsewhere"), "FT123")]
    dongle.link = tmp_path / "elsewhere"
    dongle.appear()

    program.wait(on_bus)
    assert dict(hub.board("slcan").resources)["Port"] == str(tmp_path / "elsewhere")


@pytest.mark.realtime
@pytest.mark.usefixtures("impatient")
@pytest.mark.conforms("CT-10", "CT-11", "PL-17", "PL-18")
def test_flags_become_events_and_counters(hub: Hub, dongle: FakeDongle) -> None:
    flags = [b"F24\r", b"FCB\r"]
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    dongle.answer = lambda line: flags.pop() if line == b"F" and flags else usual(line)
    found = program.wait(lambda one: is_event(one, EventKind.STATE))

    assert [(one.kind, one.code, one.state) for one in found] == [
        (EventKind.ERROR, 0xCB, ErrorState.ERROR_ACTIVE),
        (EventKind.ARBITRATION_LOST, 0, ErrorState.ERROR_ACTIVE),
        (EventKind.OVERRUN, 0, ErrorState.ERROR_ACTIVE),
        (EventKind.STATE, 0, ErrorState.ERROR_PASSIVE),
    ]
    status = program.status()
    assert (status.errors, status.arbitration_losses, status.state) == (1, 1, ErrorState.ERROR_PASSIVE)
    assert status.last_error == ErrorKind.OTHER
    assert (
        hub.read_registers(program.board.id, 0)[0].value == 0x24 if hasattr(hub, "read_registers") else True
    )


@pytest.mark.realtime
@pytest.mark.conforms("PL-14")
def test_an_adapter_that_is_pulled_out_is_waited_for(hub: Hub, dongle: FakeDongle) -> None:
    mode = LineMode(
        BitTiming.from_btr(0x03, 0x1C),
        error_frames=True,
        registers=(("ACR2", 0x60), ("AMR2", 0x1F), ("AMR3", 0xF0), ("AMR0", 0), ("AMR1", 0)),
    )
    program = Program(hub, hub.plug("slcan", port=port_of(dongle)), mode).start()
    dongle.answer = lambda line: None if line[:1] == b"t" else usual(line)
    program.send(Frame(0x1), Frame(0x2), Frame(0x3))
    dongle.wait_for(b"t0010")
    dongle.say(b"t12381122")
    dongle.vanish()
    lost = program.wait(gone)
    assert [one.kind for one in lost] == [EventKind.STATE]
    assert program.status().running
    assert program.status().state == ErrorState.STOPPED

    dongle.answer = usual
    dongle.lines.clear()
    dongle.appear()
    back = program.wait(on_bus)
    assert [one.kind for one in back if not isinstance(one, Frame)] == [
        EventKind.ABORTED,  # nobody knows whether it went out
        EventKind.CHANGED,
        EventKind.STATE,
    ]
    assert [program.wait(a_frame)[-1] for _ in range(2)] == [Frame(0x2), Frame(0x3)]
    assert dongle.lines[5:11] == [b"C", b"S4", b"M00006000", b"m00001FF0", b"O", b"F"]


@pytest.mark.realtime
@pytest.mark.usefixtures("impatient")
@pytest.mark.conforms("PL-14", "CT-14")
def test_another_adapter_in_its_place_is_left_alone(hub: Hub, dongle: FakeDongle) -> None:
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    dongle.vanish()
    program.wait(gone)
    dongle.answer = lambda line: b"NB777\r" if line == b"N" else usual(line)
    dongle.lines.clear()
    dongle.appear()

    program.wait(trouble(Trouble.STRANGER))
    assert b"O" not in dongle.lines
    dongle.answer = usual
    program.wait(on_bus)


@pytest.mark.realtime
@pytest.mark.conforms("CT-02")
@pytest.mark.parametrize("answer", [None, b"V1013\r", b"no sense\r"])
def test_late_wrong_and_missing_answers_are_one_event_each(
    hub: Hub, dongle: FakeDongle, answer: bytes | None
) -> None:
    program = Program(hub, hub.plug("slcan", port=port_of(dongle, "?timeout=1"))).start()
    bad = [answer]
    dongle.answer = lambda line: bad.pop() if line[:1] == b"t" and bad else usual(line)
    program.send(Frame(0x1), Frame(0x2))

    found = program.wait(a_frame)
    assert found[-1] == Frame(0x2)
    kinds = [(one.kind, one.code) for one in found[:-1]]
    what = Trouble.NO_ANSWER if answer is None else Trouble.WRONG_ANSWER
    assert sorted(kinds) == [(EventKind.ERROR, what), (EventKind.ABORTED, 0)]


@pytest.mark.realtime
@pytest.mark.usefixtures("impatient")
def test_an_adapter_that_never_answers_hangs_nothing(
    hub: Hub, dongle: FakeDongle, monkeypatch: pytest.MonkeyPatch
) -> None:
    conversations: list[Conversation] = []

    def made(*arguments: Any) -> Conversation:
        conversations.append(Conversation(*arguments))
        return conversations[-1]

    monkeypatch.setattr(driver, "Conversation", made)
    dongle.answer = lambda line: None
    program = Program(hub, hub.plug("slcan", port=port_of(dongle, "?timeout=0.1")))
    program.control.start()
    program.send(Frame(0x1))

    program.wait(trouble(Trouble.NO_ANSWER))
    dongle.wait_for(b"V", 6)  # it is asked again, by a port opened anew
    conversations[-1]._answer_ns = 5 * 10**9  # from here on answers may be late
    dongle.answer = usual
    found = program.wait(on_bus)
    assert not [one for one in found if is_event(one, EventKind.ERROR)]
    assert program.wait(a_frame)[-1] == Frame(0x1)


@pytest.mark.realtime
@pytest.mark.conforms("CT-01", "CT-17")
def test_acknowledgements_never_hold_frames_up(hub: Hub, dongle: FakeDongle) -> None:
    """Both directions at once, as long as both sides' buffers are many times full."""
    count = 3000
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    saying = threading.Thread(target=dongle.say, args=(b"t12381122334455667788\r" * count,), daemon=True)
    saying.start()
    program.send(*[Frame(0x321, b"12345678")] * count)
    sent = heard = 0
    while sent + heard < 2 * count:
        frame = program.wait(a_frame)[-1]
        sent += frame.self_received
        heard += not frame.self_received

    assert (sent, heard) == (count, count)


@pytest.mark.realtime
@pytest.mark.conforms("PL-21")
def test_the_lines_filter_goes_to_the_adapter(hub: Hub, dongle: FakeDongle) -> None:
    mode = LineMode(TIMING, extended=False)
    program = Program(hub, hub.plug("slcan", port=port_of(dongle)), mode)
    program.control.set_acceptance(0x123 << 1, 0xFFE, extended=False)
    program.start()
    assert dongle.lines[8:10] == [b"M24602460", b"m001F001F"]
    dongle.say(b"t1240\rt1230\r")  # the line filters as well
    assert program.wait(a_frame)[-1] == Frame(0x123)


@pytest.mark.realtime
@pytest.mark.conforms("PL-13")
def test_several_programs_share_one(hub: Hub, dongle: FakeDongle) -> None:
    program = Program(hub, hub.plug("slcan", port=port_of(dongle))).start()
    others = [hub.open_channel(program.board.id, 0) for _ in range(3)]
    for other in others:
        other.set_up(ChannelMode(64, 64))
        other.activate()
    dongle.say(b"t1231AB\r")

    for channel in (program.channel, *others):
        assert channel.receive(AGES_S) == Frame(0x123, b"\xab")


def test_what_cannot_be_is_refused(hub: Hub, tmp_path: Path, dongle: FakeDongle) -> None:
    with pytest.raises(NoSuchBoard, match="no port"):
        hub.plug("slcan", port=str(tmp_path / "nothing"))
    with pytest.raises(BadValue, match="its port is missing"):
        hub.plug("slcan")
    with pytest.raises(BadValue, match="usb-to-can has no port"):
        hub.plug("usb-to-can", port="/dev/ttyUSB0")
    with fresh_hub("virtual") as virtual, pytest.raises(Unsupported, match="virtual time"):
        virtual.plug("slcan", port=port_of(dongle))
    board = hub.plug("slcan", port=port_of(dongle))
    with pytest.raises(InUse, match=board.hardware_id):
        hub.plug("slcan", port=port_of(dongle))
    with hub.open_control(board.id, 0) as control:
        with pytest.raises(Unsupported):
            control.initialise(LineMode(TIMING, loop_back=True))
        with pytest.raises(Unsupported):
            control.initialise(LineMode(TIMING, registers=(("EWLR", 5),)))
        with pytest.raises(Unsupported):
            control.initialise(LineMode(TIMING, TIMING, long_data=True))


def test_boards_of_a_configuration_may_come_later(tmp_path: Path) -> None:
    port = tmp_path / "later"
    config = Config.parse(f'[[board]]\nkind = "slcan"\nport = "{port}"')
    with canwire.connect(time="real", config=config) as hub:
        program = Program(hub, hub.board("slcan"))
        program.control.start()
        dongle = FakeDongle(port)
        program.wait(on_bus)
        dongle.vanish()


@each(
    ("board", "message"),
    [
        ('kind = "slcan"', "board[0].port: slcan: its port is missing"),
        ('kind = "python-can"\nport = "/"', "board[0].port: port '/'"),
        ('kind = "usb-to-can"\nport = "x"', "board[0].port: usb-to-can has no port"),
        ('kind = "slcan"\nport = "COM3"\n[[board]]\nkind = "slcan"\nport = "COM3"', "'COM3' twice"),
        (
            'kind = "slcan"\nport = "COM3"\nbuses = ["can0"]',
            "board[0].buses: slcan: an adapter is on a private bus",
        ),
    ],
)
def test_configurations_are_checked(board: str, message: str) -> None:
    with pytest.raises(BadConfig) as raised:
        Config.parse(f"[[board]]\n{board}")
    assert message in str(raised.value)


# two emulated dongles, back to back


class BackToBack:
    """Two boards of one hub that are emulated dongles of another one, whose boards sit on one bus."""

    def __init__(self, hub: Hub, tmp_path: Path) -> None:
        slcan = pytest.importorskip("canwire.slcan")
        self.copper = fresh_hub()
        self._stop = Event(manual_reset=True)
        self._service = slcan.Service()
        self._dongles = []
        for number in range(2):
            plugged = slcan.PluggedDongle(self.copper, slcan.Settings(serial_number=f"A12{number}"))
            wire = slcan.PtyWire(tmp_path / f"tty{number}")
            self._service.add(plugged.dongle, plugged.event, wire)
            self._dongles.append((plugged, wire))
        self._thread = threading.Thread(target=self._service.run, args=(self._stop,), daemon=True)
        self._thread.start()
        ports = [f"{tmp_path / f'tty{number}'}?timeout={AGES_S}" for number in range(2)]
        boards = [hub.plug("slcan", port=port) for port in ports]
        self.one, self.other = (Program(hub, board, queue=8192) for board in boards)

    def dongle(self, number: int) -> Any:
        return self._dongles[number][0].dongle

    def close(self) -> None:
        self._stop.set()
        self._thread.join(AGES_S)
        for plugged, wire in self._dongles:
            wire.close()
            plugged.close()
        self.copper.close()
        self._stop.close()


@pytest.fixture
def pair(hub: Hub, tmp_path: Path) -> Iterator[BackToBack]:
    made = BackToBack(hub, tmp_path)
    yield made
    made.close()


FRAMES = [
    Frame(0x000),
    Frame(0x7FF, bytes(range(8))),
    Frame(0x123, b"\xff"),
    Frame(0x123, remote=True, dlc=8),
    Frame(0, extended=True),
    Frame(0x1FFFFFFF, b"\x00\x0d\x07\x0d", extended=True),
    Frame(0x12345, extended=True, remote=True),
]


@pytest.mark.realtime
@pytest.mark.conforms("CT-02", "CT-08", "CT-09", "CT-15")
def test_back_to_back_frames_of_every_kind(pair: BackToBack) -> None:
    programs = pair.one.start(), pair.other.start()
    for sender, receiver in (programs, programs[::-1]):
        sender.send(*FRAMES)
        assert [receiver.wait(a_frame)[-1] for _ in FRAMES] == FRAMES
        confirmed = [sender.wait(a_frame)[-1] for _ in FRAMES]
        assert confirmed == FRAMES
        assert all(frame.self_received for frame in confirmed)


@pytest.mark.realtime
@pytest.mark.conforms("CT-20")
def test_back_to_back_a_thousand_frames_at_125_kbit(pair: BackToBack) -> None:
    mode = LineMode(BitTiming.from_btr(0x03, 0x1C), error_frames=True)
    for program in (pair.one, pair.other):
        program.control.initialise(mode)
        program.start()
    sent = [Frame(number & 0x7FF, number.to_bytes(8, "big")) for number in range(1000)]
    sending = threading.Thread(target=pair.one.send, args=sent, daemon=True)
    sending.start()

    assert [pair.other.wait(a_frame)[-1] for _ in sent] == sent
    assert pair.other.status().lost == 0


@pytest.mark.realtime
@pytest.mark.usefixtures("impatient")
@pytest.mark.conforms("CT-11", "PL-18")
def test_back_to_back_nobody_acknowledges(pair: BackToBack) -> None:
    pair.one.start().send(Frame(0x1))
    found = pair.one.wait(
        lambda one: is_event(one, EventKind.STATE) and one.state is ErrorState.ERROR_PASSIVE
    )

    assert any(is_event(one, EventKind.ERROR) and one.code & 0x80 for one in found)
    pair.other.control.start()
    assert pair.other.wait(a_frame)[-1] == Frame(0x1)


@pytest.mark.realtime
@pytest.mark.usefixtures("impatient")
@pytest.mark.conforms("PL-19")
def test_back_to_back_only_listening(pair: BackToBack) -> None:
    pair.other.control.initialise(LineMode(TIMING, error_frames=True, listen_only=True))
    pair.other.start()
    pair.one.start().send(Frame(0x1))
    pair.one.wait(lambda one: is_event(one, EventKind.ERROR))  # nobody acknowledges

    assert pair.dongle(1).state.name == "LISTENING"
    assert pair.dongle(0).counters.sent == 0


@pytest.mark.realtime
def test_fast_time_gives_an_adapter_its_own(tmp_path: Path, dongle: FakeDongle) -> None:
    """Other buses of the hub run ahead of the clock; the adapter has ten seconds of the clock all the same."""

    def slow(line: bytes) -> bytes | None:
        time.sleep(0.02)
        return usual(line)

    config = Config.parse(
        '[[bus]]\nname = "can0"\n[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can0", "can0"]'
    )
    with canwire.connect(time="fast", config=config) as hub:
        board = hub.boards()[0]
        channels = []
        for number in range(2):
            control = hub.open_control(board.id, number)
            channels.append(hub.open_channel(board.id, number))
            channels[number].set_up(ChannelMode(4096, 4096))
            channels[number].activate()
            control.initialise(LineMode(BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)))
            control.start()
        dongle.answer = slow
        program = Program(hub, hub.plug("slcan", port=port_of(dongle, "?timeout=10")))
        program.control.start()
        began_ns, began = hub.now_ns(), time.monotonic_ns()
        stop = threading.Event()

        def work() -> None:
            while not stop.is_set():
                for _ in range(1000):
                    channels[0].send(Frame(0x1, bytes(8)), 0, AGES_S)
                channels[1].receive_many(4096, 0)

        working = threading.Thread(target=work, daemon=True)
        working.start()
        found = program.wait(on_bus)
        stop.set()
        working.join(AGES_S)

        assert not [one for one in found if is_event(one, EventKind.ERROR)]
        assert hub.now_ns() - began_ns > time.monotonic_ns() - began


# what tests/contracts/test_line.py asks of every line, as far as it needs no time of its own


def books(program: Any) -> tuple[int, int, int, int, int]:
    status = program.channel.status()
    assert status.sent == status.delivered + status.aborted + status.refused + status.pending
    return status.sent, status.delivered, status.aborted, status.refused, status.pending


@pytest.mark.realtime
def test_back_to_back_states_and_what_is_told_of_them(pair: BackToBack) -> None:
    program = pair.one
    program.wait(lambda one: is_event(one, EventKind.CHANGED))  # it was initialised
    active, stopped = (EventKind.STATE, ErrorState.ERROR_ACTIVE), (EventKind.STATE, ErrorState.STOPPED)
    told: list[Any] = []
    for end in (program.control.stop, program.control.reset):
        program.control.start()
        program.control.start()
        told += program.wait(on_bus)
        assert program.status().running
        end()
        told += program.wait(lambda one: is_event(one, EventKind.STATE) and one.state is ErrorState.STOPPED)
        assert not program.status().running
    told = [
        one for one in told if one.kind is not EventKind.CHANGED
    ]  # which programs of other interfaces go by
    assert [(one.kind, one.code if one.kind is EventKind.INFO else one.state) for one in told] == [
        (EventKind.INFO, 1), active, (EventKind.INFO, 2), stopped,
        (EventKind.INFO, 1), active, (EventKind.INFO, 3), stopped,
    ]  # fmt: skip


@pytest.mark.realtime
def test_back_to_back_what_is_queued_before_the_start_goes_out_then(pair: BackToBack) -> None:
    pair.other.start()
    pair.one.send(*[Frame(id) for id in (3, 1, 2)])
    assert pair.one.channel.status().pending == 3
    pair.one.start()

    assert [pair.other.wait(a_frame)[-1].id for _ in range(3)] == [3, 1, 2]
    for _ in range(3):
        pair.one.wait(a_frame)
    assert books(pair.one) == (3, 3, 0, 0, 0)


@pytest.mark.realtime
@pytest.mark.parametrize("extended", [False, True])
def test_back_to_back_the_lines_filter(pair: BackToBack, extended: bool) -> None:
    control = pair.other.control
    everything = 0x1FFFFFFF << 1 if extended else 0x7FF << 1
    control.set_acceptance(0x100 << 1, everything, extended=extended)
    control.add_ids(0x200 << 1, everything & ~2, extended=extended)
    pair.other.start()
    pair.one.start().send(*[Frame(id, extended=extended) for id in (0xFF, 0x100, 0x101, 0x200, 0x201, 0x202)])
    pair.one.send(Frame(0x100, b"end", extended=extended))

    assert [pair.other.wait(a_frame)[-1].id for _ in range(4)] == [0x100, 0x200, 0x201, 0x100]


@pytest.mark.realtime
def test_back_to_back_a_format_that_is_not_wanted(pair: BackToBack) -> None:
    pair.one.control.initialise(LineMode(TIMING, error_frames=True, extended=False))
    pair.one.start()
    pair.other.start().send(Frame(1, extended=True), Frame(2))
    assert pair.one.wait(a_frame)[-1] == Frame(2)
    pair.one.send(Frame(3, extended=True), Frame(4))
    pair.one.wait(a_frame)
    assert books(pair.one) == (2, 1, 0, 1, 0)


@pytest.mark.realtime
def test_back_to_back_cancel(pair: BackToBack) -> None:
    """What the adapter was given is on its way; the rest is given up."""
    pair.one.send(*[Frame(id) for id in range(6)])
    assert pair.one.channel.cancel() == 6
    pair.other.start()
    pair.one.start().send(Frame(9))

    assert pair.other.wait(a_frame)[-1] == Frame(9)
    pair.one.wait(a_frame)
    assert books(pair.one) == (7, 1, 6, 0, 0)


@pytest.mark.realtime
def test_back_to_back_a_cyclic_list(pair: BackToBack, hub: Hub) -> None:
    pair.other.start()
    pair.one.start()
    with hub.open_scheduler(pair.one.board.id, 0) as scheduler:
        index = scheduler.add(record_to_send(Frame(0x10, b"\0")), 20, increment=2, byte_index=0)
        scheduler.start(index, 20)
        scheduler.resume()
        assert [pair.other.wait(a_frame)[-1].data[0] for _ in range(20)] == list(range(20))


@pytest.mark.realtime
def test_back_to_back_pulled_out_and_plugged_in_again(pair: BackToBack, hub: Hub, tmp_path: Path) -> None:
    pair.other.start()
    pair.one.start()
    hub.unplug(pair.one.board.hardware_id)
    for use in (pair.one.channel.status, pair.one.control.start, pair.one.control.status):
        with pytest.raises(Unplugged):
            use()
    again = Program(hub, hub.plug("slcan", port=f"{tmp_path / 'tty0'}?timeout={AGES_S}")).start()
    again.send(Frame(4))
    assert pair.other.wait(a_frame)[-1] == Frame(4)
