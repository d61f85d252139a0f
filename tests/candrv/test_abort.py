"""CANBUS_CMD_ABORT_TRANSMISSION, and messages whose time runs out: each is told of once, under its own name."""

from __future__ import annotations

import pytest

from canwire import CONFIRM, BitTiming, ChannelMode, EventKind, Frame, LineMode
from canwire.candrv import CanbusEvent, Command, Handle, Win32Error
from canwire.candrv.errors import CandrvError
from canwire.candrv.registry.registry import RegistryStore
from tests.candrv.bench import Bench

ABORTED, TRANSMITTED = CanbusEvent.ABORTED, CanbusEvent.TRANSMITTED


def outcomes(handle: Handle) -> list[tuple[CanbusEvent, int]]:
    """What has become of messages, with their identifiers, oldest first."""
    found = [handle.read_event() for _ in range(handle.waiting)]
    return [(event.type, event.identifier) for event in found if event.event & (ABORTED | TRANSMITTED)]


def frames_on(bench: Bench) -> int:
    """How many errors the board's controller has met so far: each attempt without an acknowledge is one."""
    return bench.hub.line_status(bench.board, 0).errors


@pytest.mark.finding("candrv A1")
@pytest.mark.conforms("FS-54")
@pytest.mark.parametrize("after_s", [0.0, 0.00005, 0.0101, 0.0507, 0.0533])
def test_a_frame_that_nobody_acknowledges_is_given_up(bench: Bench, after_s: float) -> None:
    """The one in the register: it is not repeated, wherever in its error loop the command comes."""
    handle = bench.open()
    bench.absent_peer()
    handle.write("66 0 1 1\n")
    bench.run(after_s)
    handle.command(Command.ABORT_TRANSMISSION)
    bench.run(0.001)
    assert outcomes(handle) == [(ABORTED, 0x66)]
    errors = frames_on(bench)
    bench.peer.start()
    bench.run(0.1)
    assert bench.peer.receive(0) is None
    assert frames_on(bench) == errors


@pytest.mark.finding("candrv A1", "candrv A3")
@pytest.mark.conforms("FS-54")
def test_each_of_fifty_is_told_of_once(bench: Bench) -> None:
    """Again and again: nothing is left over from the time before."""
    handle = bench.open()
    bench.absent_peer()
    for trial in range(12):
        for number in range(50):
            handle.write(f"{number:x} 0 1 {trial:x}\n")
        bench.run(0.001 + trial * 0.00031)
        handle.command(Command.ABORT_TRANSMISSION)
        bench.run(0.001)
        found = outcomes(handle)
        assert [event for event, _ in found] == [ABORTED] * 50
        assert sorted(identifier for _, identifier in found) == list(range(50))


@pytest.mark.finding("candrv A4")
@pytest.mark.conforms("FS-63")
@pytest.mark.parametrize("mode", [0, 2])
def test_a_call_that_times_out_leaves_the_message_before_it_alone(
    bench: Bench, registry: RegistryStore, mode: int
) -> None:
    """7.4: a call waits until the previous message is transmitted; 7.8: it may give up waiting."""
    registry.set("CID1", "TxMode", mode)
    handle = bench.open()
    bench.absent_peer()
    timeouts = handle.timeouts
    timeouts.WriteTotalTimeoutConstant = 100
    handle.timeouts = timeouts
    handle.write("66 0 0\n")
    with pytest.raises(CandrvError) as raised:
        handle.write("67 0 0\n")
    assert raised.value.code == Win32Error.ERROR_TIMEOUT
    bench.peer.start()
    bench.run(0.1)
    assert [bench.peer.receive(0).id] == [0x66]  # type: ignore[union-attr]
    assert bench.peer.receive(0) is None
    assert outcomes(handle) == ([(TRANSMITTED, 0x66)] if mode == 2 else [])


@pytest.mark.finding("candrv A1")
def test_an_ideal_controller_does_not_repeat_it_either(bench: Bench) -> None:
    """The hub's own way to take back what is on the wire, on a board without registers."""
    bench.absent_peer()
    board = bench.hub.board("HW000001").id
    with bench.hub.open_control(board, 1) as control, bench.hub.open_channel(board, 1) as channel:
        control.initialise(LineMode(BitTiming.for_bit_rate(1_000_000, clock_hz=8_000_000)))
        channel.set_up(ChannelMode(100, 100, filter_size=0, events=(int(EventKind.ABORTED),), confirms=True))
        channel.activate()
        control.start()
        channel.send(Frame(0x66), CONFIRM)
        bench.run(0.05)
        assert channel.cancel() == 0
        bench.run(0.001)
        status = channel.status()
        assert (status.pending, status.aborted, status.delivered) == (0, 1, 0)
        bench.peer.start()
        bench.run(0.01)
        assert bench.peer.receive(0) is None
