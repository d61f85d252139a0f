"""A dongle on a board of the hub, in virtual time; the other node is a board's line of its own."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from canwire import (
    BitTiming,
    ChannelMode,
    Control,
    ErrorState,
    Frame,
    Hub,
    HubChannel,
    InUse,
    LineMode,
    NoSuchBoard,
    Unplugged,
    connect,
)
from canwire.boards.config.configuration import Config
from canwire.slcan import CANABLE, CANBUS, Dialect, Dongle, HubPort, Red, Settings, plug_dongle

AT_125K = LineMode(BitTiming.for_bit_rate(125_000))


class Node:
    """Line 0 of the default world's first board, at 125 kbit/s unless told otherwise."""

    def __init__(self, hub: Hub, mode: LineMode = AT_125K) -> None:
        self.board = hub.board("usb-to-can-fd")
        self.control: Control = hub.open_control(self.board.id, 0)
        self.control.initialise(mode)
        self.control.start()
        self.channel: HubChannel = hub.open_channel(self.board.id, 0)
        self.channel.set_up(ChannelMode(1024, 1024))
        self.channel.activate()


class Plugged:
    """A dongle, and a host that reads everything."""

    def __init__(self, hub: Hub, settings: Settings | None = None, dialect: Dialect = CANBUS) -> None:
        self.hub = hub
        self.board = plug_dongle(hub, dialect, "can0")
        self.port = HubPort(hub, self.board)
        self.dongle = Dongle(self.port, self.port.now_ns, settings)

    def ask(self, data: bytes, seconds: float = 0.0) -> bytes:
        self.dongle.feed(data)
        return self.after(seconds)

    def after(self, seconds: float) -> bytes:
        if seconds:
            self.hub.run_for(seconds)
        self.dongle.pump()
        text = bytes(self.dongle.output)
        self.dongle.written(len(text))
        return text


@pytest.fixture
def hub() -> Iterator[Hub]:
    with connect(time="virtual", config=Config.default()) as hub:
        yield hub


def test_without_its_boards_the_first_one_s_reason_is_given() -> None:
    class Bare:
        """A hub that has none of the boards."""

        def plug(self, kind: str, **others: object) -> None:
            raise NoSuchBoard(f"{kind}: not here")

    with pytest.raises(NoSuchBoard, match=f"^{CANBUS.kinds[0]}: not here$"):
        plug_dongle(Bare(), CANBUS, "can0")  # type: ignore[arg-type]


@pytest.mark.conforms("CT-05", "CT-06", "CT-07", "CT-17")
def test_frames_cross_the_bus(hub: Hub) -> None:
    node, plugged = Node(hub), Plugged(hub)
    assert plugged.ask(b"S4\rO\rt10021133\rT000001001AA\rr1002\r", 0.01) == b"\r\rz\rZ\rz\r"
    assert node.channel.receive_many(10) == [
        Frame(0x100, b"\x11\x33"), Frame(0x100, b"\xaa", extended=True), Frame(0x100, remote=True, dlc=2),
    ]  # fmt: skip
    assert (plugged.dongle.counters.sent, plugged.dongle.waiting) == (3, 0)
    for frame in (Frame(0x7FF, bytes(8)), Frame(1, remote=True, dlc=3), Frame(5, b"\x01", extended=True)):
        node.channel.send(frame)
    assert plugged.after(0.01) == b"t7FF8" + b"00" * 8 + b"\rr0013\rT00000005101\r"
    assert plugged.ask(b"F\r") == b"F00\r"


@pytest.mark.conforms("CT-18")
def test_eight_frames_wait_for_a_bus_that_nobody_else_is_on(hub: Hub) -> None:
    plugged = Plugged(hub)
    assert plugged.ask(b"S4\rO\r" + b"t1000\r" * 9, 0.1) == b"\r\r" + b"z\r" * 8 + b"\a"
    flags = int(plugged.ask(b"F\r")[1:3], 16)
    assert flags & 0b1010_0110 == 0b1010_0110  # bus errors on the way to error passive, and a full queue
    node = Node(hub)
    plugged.after(0.1)
    assert plugged.dongle.waiting == 0
    assert len(node.channel.receive_many(10)) == 8


def test_closing_goes_off_the_bus_at_once(hub: Hub) -> None:
    plugged = Plugged(hub)
    plugged.ask(b"S4\rO\r" + b"t1000\r" * 3, 0.01)
    assert plugged.ask(b"C\r") == b"\r"
    node = Node(hub)
    assert plugged.ask(b"O\rt2000\r", 0.1) == b"\rz\r"
    assert node.channel.receive_many(10) == [Frame(0x200)]
    assert plugged.dongle.counters.sent == 1


@pytest.mark.conforms("CT-09")
def test_listening_neither_acknowledges_nor_sends(hub: Hub) -> None:
    node, plugged = Node(hub), Plugged(hub)
    plugged.ask(b"S4\rL\r")
    node.channel.send(Frame(1))
    assert plugged.ask(b"t1000\r", 0.1)[:1] == b"\a"
    assert node.control.status().state == ErrorState.ERROR_PASSIVE


@pytest.mark.conforms("CT-13", "CT-12")
@pytest.mark.parametrize(
    ("mask", "frame", "passes"),
    [
        ("00001FF0", Frame(0x300, b"\0"), True),  # F28
        ("00001FF0", Frame(0x3FF, remote=True), True),  # F29
        ("00001FF0", Frame(0x400), False),  # F30
        ("00001FF0", Frame(0x000, b"\0"), True),  # F31
        ("00001FF0", Frame(0x000, b"\1"), False),  # F32
        ("00001FE0", Frame(0x345, remote=True), False),  # F33
        ("00001FF0", Frame(0x1ABC, extended=True), True),  # F34
        ("00001FF0", Frame(0x0C001234, extended=True), True),  # F35
        ("00001FF0", Frame(0x0C002000, extended=True), False),  # F36
        ("FFFFFFFF", Frame(0x400), True),
    ],
)
def test_the_documents_filter(hub: Hub, mask: str, frame: Frame, passes: bool) -> None:
    node, plugged = Node(hub), Plugged(hub)
    assert plugged.ask(b"S4\rM00006000\rm%s\rO\r" % mask.encode()) == b"\r\r\r\r"
    node.channel.send(frame)
    assert bool(plugged.after(0.01)) == passes


@pytest.mark.conforms("CT-04")
def test_rates_of_registers_are_the_bus_s(hub: Hub) -> None:
    node, plugged = Node(hub, LineMode(BitTiming.for_bit_rate(250_000))), Plugged(hub)
    assert plugged.ask(b"s011C\rO\rt1000\r", 0.01) == b"\r\rz\r"
    assert node.channel.receive() == Frame(0x100)


@pytest.mark.conforms("CT-15")
def test_stamps_count_from_power_up(hub: Hub) -> None:
    node = Node(hub)
    hub.run_for(7.0)
    plugged = Plugged(hub)
    plugged.ask(b"Z1\rS4\rO\r", 59.9)
    node.channel.send(Frame(0x100))
    assert plugged.after(0.01) == b"t1000E9FC\r"  # 59900 ms; the frame took less than one
    hub.run_for(0.1)
    node.channel.send(Frame(0x100))
    stamp = int(plugged.after(0.01)[5:9], 16)
    assert 9 <= stamp <= 11


@pytest.mark.conforms("CT-10", "CT-19")
def test_lost_arbitration_is_a_flag_and_no_light(hub: Hub) -> None:
    node, plugged = Node(hub), Plugged(hub)
    plugged.ask(b"S4\rO\r", 1.0)
    for _ in range(5):
        node.channel.send(Frame(0, bytes(8)))
    plugged.ask(b"t7FF0\r", 0.05)
    assert node.channel.receive() == Frame(0x7FF)
    assert plugged.dongle.leds.red is Red.OFF
    assert plugged.ask(b"F\rF\r") == b"F40\rF00\r"


@pytest.mark.conforms("N-13")
def test_injected_faults_show_in_flags_and_on_the_red_led(hub: Hub) -> None:
    node, plugged = Node(hub), Plugged(hub)
    plugged.ask(b"S4\rO\r", 1.0)
    faults = hub.bus("can0").faults
    faults.flip(bit=20, frame_id=0x100, times=1, seen_by="sender")
    assert plugged.ask(b"t1000\r", 0.05) == b"z\r"
    assert plugged.dongle.leds.red is Red.CONSTANT
    assert plugged.ask(b"F\rF\r") == b"F80\rF00\r"
    assert plugged.dongle.leds.red is Red.OFF

    faults.flip(bit=20, frame_id=0x100, times=16, seen_by="sender")
    plugged.ask(b"t1000\r", 0.05)
    assert (
        plugged.ask(b"F\r") == b"FA4\r"
    )  # bus errors, on the way through the warning limit to error passive
    faults.flip(bit=20, frame_id=0x100, times=None, seen_by="sender")
    plugged.ask(b"t1000\r", 0.05)
    assert node.channel.receive_many(10) == [Frame(0x100)] * 2
    assert hub.line_status(plugged.board.id, 0).state == ErrorState.BUS_OFF


def test_several_dongles_on_one_bus(hub: Hub) -> None:
    dongles = [Plugged(hub) for _ in range(3)]
    for one in dongles:
        assert one.ask(b"S8\rO\r") == b"\r\r"
    dongles[0].ask(b"t1000\r", 0.01)
    assert [one.after(0) for one in dongles] == [b"", b"t1000\r", b"t1000\r"]


def test_canable_speaks_fd(hub: Hub) -> None:
    assert CANABLE.data_rates is not None
    node = Node(hub, LineMode(CANABLE.rates[b"6"], CANABLE.data_rates[b"5"], long_data=True))
    plugged = Plugged(hub, Settings(dialect=CANABLE), CANABLE)
    assert plugged.ask(b"S6\rY5\rO\rb1009" + b"5A" * 12 + b"\rt1000\r", 0.01) == b""
    assert node.channel.receive_many(9) == [
        Frame(0x100, b"\x5a" * 12, fd=True, bit_rate_switch=True), Frame(0x100),
    ]  # fmt: skip
    node.channel.send(Frame(0x200, bytes(64), fd=True, bit_rate_switch=True))
    assert plugged.after(0.01) == b"b200F" + b"00" * 64 + b"\r"


def test_a_canable_s_single_shot_makes_room(hub: Hub) -> None:
    plugged = Plugged(hub, Settings(dialect=CANABLE), CANABLE)
    plugged.ask(b"A0\rO\r" + b"t1000\r" * 8, 0.1)
    assert (plugged.dongle.waiting, plugged.dongle.counters.sent) == (0, 0)


def test_nobody_else_sets_its_line_up(hub: Hub) -> None:
    plugged = Plugged(hub)
    with pytest.raises(InUse):
        hub.open_control(plugged.board.id, 0)
    plugged.port.end()
    plugged.port.end()
    hub.open_control(plugged.board.id, 0).close()


def test_no_such_bus(hub: Hub) -> None:
    with pytest.raises(NoSuchBoard, match="no bus 'can7'"):
        plug_dongle(hub, CANBUS, "can7")


def test_a_board_that_is_pulled_out(hub: Hub) -> None:
    plugged = Plugged(hub)
    plugged.ask(b"S4\rO\r")
    hub.unplug(plugged.board.hardware_id)
    with pytest.raises(Unplugged):
        plugged.after(0)
