"""Where the manual is silent, and no other test shows what happens: see docs/porting-candrv.md."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from canwire import ErrorState
from canwire.candrv import CanbusEvent, CandrvError, CanMode, Handle, Win32Error
from canwire.candrv.registry.registry import RegistryStore
from tests.candrv.bench import Bench

OUTCOMES = CanbusEvent.TRANSMITTED | CanbusEvent.ABORTED
EFLG = 0x2D


def same_mode(handle: Handle) -> None:
    handle.can_mode = CanMode.CAN_2_0_B


def same_rate(handle: Handle) -> None:
    handle.baud_rate = 1_000_000


@pytest.mark.parametrize("setting", [same_mode, same_rate, Handle.initialise])
def test_settings_amid_traffic_leave_no_message_without_its_outcome(
    bench: Bench, setting: Callable[[Handle], None]
) -> None:
    handle, query = bench.open(), bench.open(read=False, write=False, hub=bench.program("second"))
    same_mode(handle)
    assert bench.peer
    for number in range(40):
        handle.write(f"{number:x} 0 8 0 0 0 0 0 0 0 0\n")
        if number % 4 == 0:
            bench.run(0.00007)
            setting(query)
    bench.run(0.1)
    found = [handle.read_event() for _ in range(handle.waiting)]
    assert sorted(event.identifier for event in found if event.event & OUTCOMES) == list(range(40))
    sent = [event.identifier for event in found if event.event == CanbusEvent.TRANSMITTED]
    heard = [frame.id for frame in bench.peer.received(len(sent))]
    assert set(sent) <= set(heard) | {frame.id for frame in iter(lambda: bench.peer.receive(0), None)}


def test_can_time_starts_with_the_hub(bench: Bench) -> None:
    bench.run(2)
    assert bench.open().time() == 2000


@pytest.mark.parametrize("bench", ["picocom1"], indirect=True)
def test_an_mcp2515_in_bus_off_reads_0_until_init(bench: Bench) -> None:
    handle = bench.open()
    assert bench.peer
    bench.faults.flip(bit=20, times=None)
    handle.write("1 0 0\n")
    bench.run(0.05)
    assert bench.hub.line_status(bench.board, 0).state is ErrorState.BUS_OFF
    assert handle.read_register(EFLG) == 0
    bench.faults.clear()
    handle.initialise()
    handle.write("2 0 0\n")
    bench.run(0.01)
    assert CanbusEvent.TRANSMITTED in [handle.read_event().type for _ in range(handle.waiting)]


@pytest.mark.parametrize("rate", [57_600, 115_200])
def test_a_registrys_rate_that_the_clock_does_not_make_opens_no_device(
    bench: Bench, registry: RegistryStore, rate: int
) -> None:
    registry.set("CID1", "Baudrate", rate)
    with pytest.raises(CandrvError) as refused:
        bench.open()
    assert refused.value.code == Win32Error.ERROR_INVALID_PARAMETER
