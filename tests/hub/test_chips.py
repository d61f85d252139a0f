"""Chips behind the hub: registers, sleep, held interrupts, shares, notes, and boards with jumpers."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import (
    BadValue,
    BitTiming,
    ChannelMode,
    ErrorState,
    EventKind,
    Frame,
    Hub,
    InUse,
    LimitReached,
    LineMode,
    NoChannel,
    RateConflict,
    Unsupported,
    WrongState,
    conflicts_on,
)
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from tests.hub.in_memory import bench_of

TIMING = BitTiming.from_btr(0x01, 0x1C)
WORLD = Config(
    bus=(BusConfig(name="can0"),),
    board=(
        BoardConfig(kind="inducan104", serial="HW000001"),
        BoardConfig(kind="netdcu", serial="HW000002"),
        BoardConfig(kind="usb-to-can", serial="HW000003"),
    ),
)
EVENTS = tuple(
    int(kind) for kind in (EventKind.SLEEPING, EventKind.WOKEN, EventKind.OVERRUN, EventKind.CHANGED)
)


bench = bench_of(WORLD)


@pytest.fixture
def hub(bench: Any) -> Hub:
    made: Hub = bench.hub("one")
    return made


@pytest.fixture
def other(bench: Any, hub: Hub) -> Hub:
    made: Hub = bench.hub("other")
    return made


def started(hub: Hub, name: str, **options: Any) -> Any:
    control = hub.open_control(hub.board(name).id, 0)
    control.initialise(LineMode(TIMING, **options))
    control.start()
    return control


def channel_on(hub: Hub, name: str, **options: Any) -> Any:
    channel = hub.open_channel(hub.board(name).id, 0)
    channel.set_up(ChannelMode(256, 64, events=EVENTS, **options))
    channel.activate()
    return channel


def everything(channel: Any) -> list[Any]:
    found = []
    while (one := channel.receive_any(0)) is not None:
        found.append(one)
    return found


def value_of(hub: Hub, name: str, register: str) -> int:
    return next(one.value for one in hub.registers(hub.board(name).id, 0) if one.name == register)


@pytest.mark.conforms("AC-13")
def test_registers_are_shown_without_touching_them(hub: Hub) -> None:
    started(hub, "inducan104", registers=(("OCR", 0x6A), ("IER", 0xAD), ("ACR1", 0x12)))
    assert (value_of(hub, "inducan104", "OCR"), value_of(hub, "inducan104", "IER")) == (0x6A, 0xAD)
    shown = {one.name: one.text for one in hub.registers(hub.board("inducan104").id, 0)}
    assert shown["OCR"] == "TX1=pull-down OCPOL1 TX0=pull-down OCMODE=normal"
    assert hub.registers(hub.board("usb-to-can").id, 0) == ()


@pytest.mark.conforms("FS-58")
def test_registers_are_read_and_written(hub: Hub) -> None:
    control = started(hub, "netdcu")
    control.write_register(4, 0xFD)
    assert control.read_register(4) == 0xFD
    control.write_register(16, 0x55, reset_mode=True)
    assert control.read_register(16, reset_mode=True) == 0x55
    assert control.status().running
    for address, value in ((128, 0), (-1, 0), (4, 256)):
        with pytest.raises(BadValue):
            control.write_register(address, value)
    with pytest.raises(Unsupported):
        started(hub, "usb-to-can").read_register(0)


def test_only_chips_have_registers_to_set(hub: Hub) -> None:
    with pytest.raises(Unsupported):
        started(hub, "usb-to-can", registers=(("OCR", 0x6A),))
    with pytest.raises(BadValue, match="TXERR"):
        started(hub, "netdcu", registers=(("TXERR", 1),))


@pytest.mark.conforms("FS-52")
def test_a_line_sleeps_until_the_bus_or_a_sender_wakes_it(hub: Hub) -> None:
    control, sender = started(hub, "netdcu"), started(hub, "usb-to-can")
    channel, partner = channel_on(hub, "netdcu"), channel_on(hub, "usb-to-can")
    hub.run_for(0.01)
    everything(channel)
    control.sleep()
    hub.run_for(0.01)
    assert [one.kind for one in everything(channel)] == [EventKind.SLEEPING]
    partner.send(Frame(0x123))
    hub.run_for(0.01)
    assert everything(channel)[0].kind is EventKind.WOKEN
    control.sleep()
    hub.run_for(0.01)
    channel.send(Frame(0x321))
    hub.run_for(0.01)
    assert [one.kind for one in everything(channel)] == [EventKind.SLEEPING, EventKind.WOKEN]
    assert Frame(0x321) in [Frame(frame.id) for frame in everything(partner) if isinstance(frame, Frame)]
    sender.stop()
    control.stop()
    with pytest.raises(WrongState):
        control.sleep()


@pytest.mark.conforms("FS-65")
def test_a_chip_that_nobody_serves_overruns(hub: Hub) -> None:
    started(hub, "netdcu")
    started(hub, "usb-to-can")
    channel, partner = channel_on(hub, "netdcu"), channel_on(hub, "usb-to-can")
    board = hub.board("netdcu").id
    hub.run_for(0.001)
    everything(channel)
    hub.hold_interrupts(board, 0)
    for number in range(8):
        partner.send(Frame(number, bytes(8)))
    hub.run_for(0.01)
    hub.hold_interrupts(board, 0, False)
    found = everything(channel)
    assert [one.id for one in found if isinstance(one, Frame)] == [0, 1, 2, 3, 4]
    assert [one.kind for one in found if not isinstance(one, Frame)] == [EventKind.OVERRUN]
    with pytest.raises(Unsupported):
        hub.hold_interrupts(hub.board("usb-to-can").id, 0)


def test_a_line_that_hears_only_itself(hub: Hub) -> None:
    started(hub, "netdcu", loop_back=True)
    channel = channel_on(hub, "netdcu")
    channel.send(Frame(0x123, b"\1"))
    hub.run_for(0.01)
    assert [(frame.id, frame.data) for frame in everything(channel) if isinstance(frame, Frame)] == [
        (0x123, b"\1")
    ]
    with pytest.raises(Unsupported):
        started(hub, "usb-to-can", loop_back=True)


@pytest.mark.conforms("FS-16")
def test_shares_go_with_their_holder(bench: Any, hub: Hub, other: Hub) -> None:
    board = hub.board("netdcu").id
    shares = [other.open_share(board, 0, read=True, write=True) for _ in range(2)]
    with pytest.raises(NoChannel):
        hub.open_share(board, 0, read=True, write=False)
    shares[0].close()
    held = hub.open_share(board, 0, read=True, write=False)
    bench.link(other).die()
    alone = hub.open_share(board, 0, read=False, write=True, share=1)
    with pytest.raises(InUse):
        hub.open_share(board, 0, read=False, write=True)
    alone.close()
    held.close()
    with pytest.raises(BadValue):
        hub.open_share(board, 0, read=True, write=True, share=4)


def test_notes_stay_until_they_are_taken_away(hub: Hub, other: Hub) -> None:
    hub.set_note("acan", b"280:5")
    assert other.note("acan") == b"280:5"
    other.set_note("acan", b"")
    assert hub.note("acan") == b""
    with pytest.raises(BadValue):
        hub.set_note("x" * 65, b"1")
    for number in range(256):
        hub.set_note(str(number), b"1")
    with pytest.raises(LimitReached, match="256 of 256 notes"):
        hub.set_note("one more", b"1")
    other.set_note("others have room", b"1")


def test_a_persistent_line_outlives_its_users(bench: Any, hub: Hub, other: Hub) -> None:
    started(other, "inducan104", persistent=True, note=b"mine").close()
    started(other, "netdcu").close()
    bench.link(other).die()
    status = hub.line_status(hub.board("inducan104").id, 0)
    assert (status.running, status.mode.note if status.mode else b"") == (True, b"mine")
    assert not hub.line_status(hub.board("netdcu").id, 0).initialised


def test_starting_may_give_up_what_waits(hub: Hub) -> None:
    control = started(hub, "netdcu")
    control.stop()
    channel = channel_on(hub, "netdcu")
    channel.send(Frame(1))
    channel.send(Frame(2))
    control.start(abort_pending=True)
    assert (channel.status().aborted, channel.status().pending) == (2, 0)


def test_those_who_ask_are_told_of_their_own_frames(hub: Hub) -> None:
    """CONFIRM, CONFIRM_LOAD: only where the channel says that it knows them."""
    started(hub, "netdcu")
    started(hub, "usb-to-can")
    knowing, ignorant = channel_on(hub, "netdcu", confirms=True), channel_on(hub, "netdcu")
    hub.run_for(0.001)
    for channel in (knowing, ignorant):
        everything(channel)
        channel.send(Frame(0x123), 1 << 13)
        channel.send(Frame(0x124), 1 << 24)
    hub.run_for(0.01)
    assert [frame.id for frame in everything(knowing)] == [0x123, 0x124]
    assert everything(ignorant) == []


@pytest.mark.conforms("AC-04", "AC-03")
def test_boards_at_one_place_are_refused(hub: Hub) -> None:
    with pytest.raises(InUse, match="HW000001"):
        hub.plug("inducan104", irq=7)
    with pytest.raises(InUse, match="HW000001"):
        hub.plug("inducan104", base=0x300)
    second = hub.plug("inducan104", base=0x300, irq=7)
    assert second.resources == (("I/O", "300h-31Fh"), ("IRQ", "7"))
    hub.unplug(second.hardware_id)
    assert hub.plug("inducan104", base=0x300, irq=7).resources == second.resources
    with pytest.raises(BadValue):
        hub.plug("usb-to-can", base=0x320)


def test_two_boards_may_share_an_interrupt_if_both_say_so(hub: Hub) -> None:
    hub.unplug("HW000001")
    names = [hub.plug("inducan104", base=base, irq=5, shared_irq=True).hardware_id for base in (0x280, 0x300)]
    for name in names:
        started(hub, name)
    sender, receiver = (channel_on(hub, name) for name in names)
    hub.run_for(0.001)
    sender.send(Frame(0x123))
    hub.run_for(0.01)
    assert [frame.id for frame in everything(receiver) if isinstance(frame, Frame)] == [0x123]
    hub.unplug(names[0])
    assert hub.line_status(hub.board(names[1]).id, 0).state == ErrorState.ERROR_ACTIVE


def test_a_bit_timing_written_into_registers_is_warned_of(bench: Any, hub: Hub) -> None:
    warned: list[str] = []
    bench.world.warn = warned.append
    control = started(hub, "netdcu")
    started(hub, "usb-to-can")
    assert (conflicts_on(hub), warned) == ([], [])
    control.write_register(6, 0x43, reset_mode=True)  # BTR0: 250 kbit/s become 125
    (found,) = conflicts_on(hub)
    assert isinstance(found, RateConflict)
    assert "HW000002:0 at 125000 bit/s by its chip's registers" in str(found)
    assert warned == [str(found)]
    assert control.status().mode.timing == TIMING  # that is what programs agreed on
    control.write_register(6, 0x01, reset_mode=True)
    assert conflicts_on(hub) == []


def test_a_chip_that_is_no_line_is_warned_of(bench: Any, hub: Hub) -> None:
    warned: list[str] = []
    bench.world.warn = warned.append
    chip = Sja1000(bench.world.buses["can0"])
    for address, value in ((m.BASIC_BTR0, 0x00), (m.BASIC_BTR1, 0x1C), (m.BASIC_CR, 0)):
        chip.write(address, value)
    assert conflicts_on(hub) == []  # nobody else takes part
    control = started(hub, "usb-to-can")
    (found,) = conflicts_on(hub)
    assert isinstance(found, RateConflict)
    assert str(found).endswith("; SJA1000 no. 1 at 500000 bit/s")
    assert warned == [str(found)]
    chip.write(m.BASIC_CR, m.CR_RR)
    assert control.status().neighbours == ()
    assert conflicts_on(hub) == []
    chip.write(m.BASIC_BTR0, 0x01)
    chip.write(m.BASIC_BTR1, 0x16)  # of 10 quanta: another rate again
    chip.write(m.BASIC_CR, 0)
    assert [node.name for node in control.status().neighbours] == ["SJA1000 no. 1"]
    assert len(conflicts_on(hub)) == 1
