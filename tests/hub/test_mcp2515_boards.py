"""Boards with an MCP2515 behind the hub: channels, orders, sleep, loop-back, overruns, registers, bus-off."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from canwire import (
    BadTiming,
    BadValue,
    BitTiming,
    BusEvent,
    ChannelMode,
    ErrorState,
    EventKind,
    Frame,
    Hub,
    InUse,
    LineMode,
    NoChannel,
    Unsupported,
    WrongState,
)
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from canwire.bus.can.faults.faults import Faults
from canwire.chips.mcp2515 import register_map as m
from tests.hub import in_memory

BOARDS = ("picocom1", "picocom2", "picocom4", "picomod3")
TIMING = BitTiming.from_btr(0x01, 0x1C)
EVENTS = tuple(
    int(kind) for kind in (EventKind.SLEEPING, EventKind.WOKEN, EventKind.OVERRUN, EventKind.STATE)
)
LONG = bytes(8)
ROLL_OVER = m.RX_BUKT


class Bench:
    """An MCP2515 board at work on a bus, and a USB-to-CAN beside it that hears and sends."""

    def __init__(self, kind: str, **options: Any) -> None:
        boards = (
            BoardConfig(kind=kind, serial="HW000001"),
            BoardConfig(kind="usb-to-can", serial="HW000002"),
        )
        self.made = in_memory.Bench(Config(bus=(BusConfig(name="can0"),), board=boards))
        self.hub: Hub = self.made.hub("one")
        self.world = self.made.world
        self.board, self.other_board = (self.hub.board(name).id for name in ("HW000001", "HW000002"))
        self.control = self.started(self.board, **options)
        self.started(self.other_board)
        self.partner = self.channel(self.other_board, events=())
        self.run(0.001)

    def started(self, board: int, **options: Any) -> Any:
        control = self.hub.open_control(board, 0)
        control.initialise(LineMode(TIMING, **options))
        control.start()
        return control

    def channel(self, board: int | None = None, *, events: tuple[int, ...] = EVENTS) -> Any:
        channel = self.hub.open_channel(self.board if board is None else board, 0)
        channel.set_up(ChannelMode(256, 64, events=events))
        channel.activate()
        return channel

    def run(self, seconds: float = 0.01) -> None:
        self.hub.run_for(seconds)

    def heard(self) -> list[int]:
        """Identifiers of what the partner has received."""
        return [frame.id for frame in self.partner.receive_many(256)]

    def close(self) -> None:
        self.made.close()


def everything(channel: Any) -> list[Any]:
    found = []
    while (one := channel.receive_any(0)) is not None:
        found.append(one)
    return found


def ids(found: list[Any]) -> list[int]:
    return [one.id for one in found if isinstance(one, Frame)]


def kinds(found: list[Any]) -> list[EventKind]:
    return [one.kind for one in found if isinstance(one, BusEvent)]


@pytest.fixture(params=BOARDS)
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    made = Bench(str(request.param))
    yield made
    made.close()


@pytest.fixture
def picocom() -> Iterator[Bench]:
    made = Bench("picocom1")
    yield made
    made.close()


# channels


@pytest.mark.conforms("FS-16")
def test_three_send_and_two_receive(bench: Bench) -> None:
    hub, board = bench.hub, bench.board
    both = [hub.open_share(board, 0, read=True, write=True) for _ in range(2)]
    with pytest.raises(NoChannel, match="receive"):
        hub.open_share(board, 0, read=True, write=False)
    third = hub.open_share(board, 0, read=False, write=True)
    with pytest.raises(NoChannel, match="send"):
        hub.open_share(board, 0, read=False, write=True)
    third.close()
    both[0].close()
    alone = hub.open_share(board, 0, read=True, write=False)
    with pytest.raises(InUse):
        hub.open_share(board, 0, read=False, write=True, share=0)
    alone.close()


@pytest.mark.conforms("FS-64")
def test_order_within_a_channel_and_identifiers_between_channels(bench: Bench) -> None:
    """Each channel's next frame is in a transmit register: of these the lowest identifier goes first."""
    one, two, three = (bench.channel() for _ in range(3))
    bench.partner.send(Frame(0, LONG))
    bench.run(50e-6)  # the bus is busy while they are loaded
    for channel, queued in (
        (one, (0x300, 0x050, 0x301)),
        (two, (0x200, 0x400, 0x001)),
        (three, (0x250, 0x250, 0x7FF)),
    ):
        for number, id in enumerate(queued):
            channel.send(Frame(id, bytes([number])))
    bench.run()
    assert bench.heard() == [0x200, 0x250, 0x250, 0x300, 0x050, 0x301, 0x400, 0x001, 0x7FF]


@pytest.mark.conforms("FS-64")
def test_equal_identifiers_of_several_channels(picocom: Bench) -> None:
    """None of them is lost, and each channel's own stay in order."""
    channels = [picocom.channel() for _ in range(3)]
    for number in range(20):
        for place, channel in enumerate(channels):
            channel.send(Frame(0x123, bytes([place, number])))
    picocom.run(0.1)
    heard = [tuple(frame.data) for frame in picocom.partner.receive_many(256)]
    for place in range(3):
        assert [number for of, number in heard if of == place] == list(range(20))


@pytest.mark.conforms("FS-64")
def test_standard_goes_before_extended_of_the_same_first_bits(picocom: Bench) -> None:
    one, two = picocom.channel(), picocom.channel()
    picocom.partner.send(Frame(0, LONG))
    picocom.run(50e-6)
    one.send(Frame(0x123 << 18, extended=True))
    two.send(Frame(0x123, remote=True))
    picocom.run()
    assert [frame.extended for frame in picocom.partner.receive_many(9)] == [False, True]


def test_a_fourth_sender_waits_for_a_register(picocom: Bench) -> None:
    """Beyond CANDRV's limits a line has any number of channels; three of them have a frame in the chip.

    Whose turn is last, that of the channel which was there first, waits even with the lowest identifier.
    """
    channels = [picocom.channel() for _ in range(4)]
    picocom.partner.send(Frame(0, LONG))
    picocom.run(50e-6)
    for id, channel in zip((1, 4, 3, 2), channels, strict=True):
        channel.send(Frame(id, LONG))
    picocom.run()
    assert picocom.heard() == [2, 1, 3, 4]


# registers that are not emptied


@pytest.mark.conforms("FS-65")
def test_two_receive_registers_not_emptied_in_time(bench: Bench) -> None:
    """RXB0 rolls over into RXB1; what comes then is lost, which is told once, and counted by the chip's model."""
    one, two = bench.channel(), bench.channel()
    bench.hub.hold_interrupts(bench.board, 0)
    for number in range(5):
        bench.partner.send(Frame(number, LONG))
    bench.run()
    assert (everything(one), everything(two)) == ([], [])
    bench.hub.hold_interrupts(bench.board, 0, False)
    for channel in (one, two):
        found = everything(channel)
        assert (ids(found), kinds(found)) == ([0, 1], [EventKind.OVERRUN])
    chip = bench.world.boards[bench.board].lines[0].line.controller
    assert chip.overflows == 3
    bench.partner.send(Frame(9))
    bench.run()
    assert (ids(everything(one)), kinds(everything(two))) == ([9], [])


@pytest.mark.conforms("FS-65")
def test_two_frames_are_no_overrun(bench: Bench) -> None:
    channel = bench.channel()
    bench.hub.hold_interrupts(bench.board, 0)
    for number in range(2):
        bench.partner.send(Frame(number, LONG))
    bench.run()
    bench.hub.hold_interrupts(bench.board, 0, False)
    found = everything(channel)
    assert (ids(found), kinds(found)) == ([0, 1], [])


@pytest.mark.conforms("FS-65")
def test_without_roll_over_one_register_is_all(picocom: Bench) -> None:
    picocom.control.write_register(m.RXBCTRL[0], m.RXM_ALL << m.RX_RXM_SHIFT)
    assert not picocom.control.read_register(m.RXBCTRL[0]) & ROLL_OVER
    channel = picocom.channel()
    picocom.hub.hold_interrupts(picocom.board, 0)
    for number in range(3):
        picocom.partner.send(Frame(number, LONG))
    picocom.run()
    picocom.hub.hold_interrupts(picocom.board, 0, False)
    found = everything(channel)
    assert (ids(found), kinds(found)) == ([0], [EventKind.OVERRUN])


def test_what_nobody_serves_is_sent_all_the_same(picocom: Bench) -> None:
    """A frame that is in the chip goes out; the next one, and the news, wait for the driver."""
    channel = picocom.channel()
    picocom.hub.hold_interrupts(picocom.board, 0)
    for id in (1, 2):
        channel.send(Frame(id))
    picocom.run()
    assert picocom.heard() == [1]
    assert (channel.status().delivered, channel.status().pending) == (0, 2)
    picocom.hub.hold_interrupts(picocom.board, 0, False)
    picocom.run()
    assert picocom.heard() == [2]
    assert channel.status().delivered == 2


# sleep


@pytest.mark.conforms("FS-52")
def test_asleep_until_the_bus_or_a_sender_wakes_it(bench: Bench) -> None:
    channel, sibling = bench.channel(), bench.channel()
    bench.control.sleep()
    bench.run()
    for one in (channel, sibling):
        assert kinds(everything(one)) == [EventKind.SLEEPING]
    bench.partner.send(Frame(0x123))
    bench.run()
    for one in (channel, sibling):
        assert kinds(everything(one)) == [EventKind.WOKEN]
    bench.control.sleep()
    bench.run()
    bench.heard()
    channel.send(Frame(0x321))
    bench.run()
    assert kinds(everything(channel)) == [EventKind.SLEEPING, EventKind.WOKEN]
    assert bench.heard() == [0x321]
    bench.control.sleep()
    bench.run()
    bench.control.wake()
    bench.control.wake()
    bench.run()
    assert kinds(everything(channel)) == [EventKind.SLEEPING, EventKind.WOKEN]
    bench.control.stop()
    with pytest.raises(WrongState):
        bench.control.sleep()


# settings


def test_a_line_that_hears_only_itself() -> None:
    bench = Bench("picomod3", loop_back=True)
    channel = bench.channel()
    channel.send(Frame(0x123, b"\1"))
    bench.partner.send(Frame(0x321))
    bench.run()
    assert [(frame.id, frame.data) for frame in everything(channel) if isinstance(frame, Frame)] == [
        (0x123, b"\1")
    ]
    assert bench.heard() == []
    with pytest.raises(BadValue, match="loop_back"):
        bench.control.initialise(LineMode(TIMING, loop_back=True, listen_only=True))
    bench.close()


def test_what_the_chip_cannot_do_is_refused(picocom: Bench) -> None:
    for mode, error in (
        (LineMode(TIMING, TIMING), Unsupported),
        (LineMode(BitTiming(1, 16, 8, 1, 8_000_000), registers=(("TEC", 1),)), BadValue),
        (LineMode(BitTiming(1, 1, 2, 1, 8_000_000)), BadTiming),
    ):
        with pytest.raises(error):
            picocom.control.initialise(mode)


def test_filters_are_settings() -> None:
    """RXF0 and RXM0 let 200h to 20Fh into RXB0; nothing goes to RXB1, whose mask compares all with 0."""
    registers = (
        ("RXB0CTRL", ROLL_OVER), ("RXB1CTRL", 0),
        ("RXM0SIDH", 0xFE), ("RXM1SIDH", 0xFF), ("RXM1SIDL", 0xE0),
        ("RXF0SIDH", 0x40), ("RXF1SIDH", 0x40),
    )  # fmt: skip
    bench = Bench("picocom4", registers=registers)
    channel = bench.channel()
    for id in (0x1FF, 0x200, 0x20F, 0x210):
        bench.partner.send(Frame(id))
    bench.run()
    assert ids(everything(channel)) == [0x200, 0x20F]
    bench.close()


# registers


def test_registers_are_shown_read_and_written(bench: Bench) -> None:
    shown = {one.name: one for one in bench.hub.registers(bench.board, 0)}
    assert shown["CANSTAT"].text.startswith("OPMOD=normal")
    assert "RXF0SIDH" not in shown  # reads as 0 but in configuration mode
    bench.control.write_register(m.BFPCTRL, 0x0F)
    assert bench.control.read_register(m.BFPCTRL) == 0x0F
    bench.control.write_register(m.RXF[0], 0x55)  # only in configuration mode
    assert bench.control.read_register(m.RXF[0], reset_mode=True) == 0
    bench.control.write_register(m.RXF[0], 0x55, reset_mode=True)
    assert bench.control.read_register(m.RXF[0]) == 0
    assert bench.control.read_register(m.RXF[0], reset_mode=True) == 0x55
    assert bench.control.status().running
    channel = bench.channel()
    bench.run()
    channel.send(Frame(1))
    bench.run()
    assert bench.heard() == [1]
    for address, value in ((128, 0), (-1, 0), (4, 256)):
        with pytest.raises(BadValue):
            bench.control.write_register(address, value)


# bus-off


@pytest.mark.conforms("FS-59", "FS-66")
def test_bus_off_until_it_is_set_up_again(bench: Bench) -> None:
    """What IOCTL_CAN_INIT does; each state was told once."""
    channel = bench.channel()
    faults = Faults(bench.world.buses["can0"], seed=0)
    faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    channel.send(Frame(1))
    bench.run(0.1)
    assert [one.state for one in everything(channel) if isinstance(one, BusEvent)] == [
        ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF,
    ]  # fmt: skip
    faults.clear()
    bench.heard()
    bench.run(1.0)
    assert (bench.control.status().state, bench.heard()) == (ErrorState.BUS_OFF, [])
    mode = bench.control.status().mode
    bench.control.initialise(mode)
    bench.control.start()
    bench.run()
    status = bench.control.status()
    assert (status.tec, status.rec, status.state) == (0, 0, ErrorState.ERROR_ACTIVE)
    channel.send(Frame(2))
    bench.run()
    assert bench.heard() == [2]
