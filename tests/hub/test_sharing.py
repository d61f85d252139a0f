"""Who may configure a line: docs/sharing.md's rules at the hub, whatever the interface."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace

import pytest

import canwire
from canwire import BitTiming, BoardInfo, Hub, InUse, LineMode, Unsupported, WrongState
from canwire.hub.owner.engine import Engine
from tests.hubs import connected, embedded

CONFIG = """
[[bus]]
name = "can0"
[[board]]
kind = "usb-to-can"
serial = "HW000001"
"""
SLOW = LineMode(BitTiming.for_bit_rate(250_000, clock_hz=8_000_000))
QUICK = LineMode(BitTiming.for_bit_rate(500_000, clock_hz=8_000_000))

Program = Callable[[str], Hub]


@pytest.fixture
def engine() -> Iterator[Engine]:
    with embedded(CONFIG, time="virtual") as made:
        yield made


@pytest.fixture
def program(engine: Engine) -> Iterator[Program]:
    with ExitStack() as stack:
        yield lambda name: stack.enter_context(connected(engine, name))


def board(hub: Hub) -> BoardInfo:
    return hub.board("HW000001")


def on_line(hub: Hub, mode: LineMode, line: int = 0) -> canwire.HubChannel:
    """A program with a channel there that has set the line up and started it, and holds nothing."""
    channel = hub.open_channel(board(hub).id, line)
    set_up(hub, mode, line)
    return channel


def set_up(hub: Hub, mode: LineMode, line: int = 0) -> None:
    with hub.open_control(board(hub).id, line) as control:
        control.initialise(mode)
        control.start()


@pytest.mark.conforms("N-03")
def test_a_rate_that_others_run_at_stays(program: Program) -> None:
    first, second = program("first"), program("second")
    on_line(first, SLOW)
    with pytest.raises(
        InUse, match=r"runs at 250000 bit/s, set by first \(\d+\); it cannot be set to 500000 bit/s"
    ):
        set_up(second, QUICK)
    status = first.line_status(board(first).id, 0)
    assert status.running
    assert status.mode == SLOW
    set_up(second, replace(SLOW, listen_only=True))  # another setting at the same rate is no other rate


def test_whoever_set_it_up_may_change_the_rate(program: Program) -> None:
    first, second = program("first"), program("second")
    on_line(first, SLOW)
    with second.open_channel(board(second).id, 0):
        set_up(first, QUICK)
    assert first.line_status(board(first).id, 0).mode == QUICK


def test_programs_of_one_kin_may_change_each_others(program: Program) -> None:
    first, second = program("first"), program("second")
    on_line(first, replace(SLOW, kin="x"))
    for kin in ("", "y"):
        with pytest.raises(InUse):
            set_up(second, replace(QUICK, kin=kin))
    set_up(second, replace(QUICK, kin="x"))


def test_a_program_alone_on_the_line_may_do_as_it_likes(program: Program) -> None:
    first, second = program("first"), program("second")
    on_line(first, SLOW)
    with second.open_channel(board(second).id, 0):
        first.close()
        status = second.line_status(board(second).id, 0)
        assert status.set_by.startswith("first (")
        assert status.set_by_left
        set_up(second, QUICK)
        assert second.line_status(board(second).id, 0).set_by.startswith("second (")


@pytest.mark.conforms("N-02")
def test_a_refused_setting_leaves_the_line_at_work(program: Program) -> None:
    hub = program("first")
    on_line(hub, SLOW)
    for impossible in (replace(SLOW, registers=(("OCR", 0),)), replace(SLOW, loop_back=True)):
        with pytest.raises(Unsupported):
            set_up(hub, impossible)
        status = hub.line_status(board(hub).id, 0)
        assert status.running
        assert status.mode == SLOW


@pytest.mark.conforms("N-05")
def test_recovery_is_for_those_on_the_line(program: Program) -> None:
    first, second = program("first"), program("second")
    on_line(first, SLOW)
    with pytest.raises(WrongState, match="open a channel first"):
        second.recover(board(second).id, 0)
    with second.open_channel(board(second).id, 0):
        second.recover(board(second).id, 0)  # a line that is not bus-off goes on
    assert first.line_status(board(first).id, 0).running


@pytest.mark.conforms("N-04")
@pytest.mark.parametrize(
    ("mode", "left"),
    [
        (SLOW, (False, False)),
        (replace(SLOW, keeps=True), (False, True)),
        (replace(SLOW, persistent=True), (True, True)),
    ],
)
def test_a_line_whose_last_program_went(program: Program, mode: LineMode, left: tuple[bool, bool]) -> None:
    first, bench = program("first"), program("bench")
    on_line(first, mode)
    first.close()
    status = bench.line_status(board(bench).id, 0)
    assert (status.running, status.initialised) == left


def test_a_line_made_persistent_stays_so_until_it_is_reset(program: Program) -> None:
    first, second = program("first"), program("second")
    set_up(first, replace(SLOW, persistent=True))
    set_up(second, QUICK)
    second.close()
    assert first.line_status(board(first).id, 0).running
    with first.open_control(board(first).id, 0) as control:
        control.reset()
    assert not first.line_status(board(first).id, 0).initialised


@pytest.mark.conforms("N-03")
def test_lines_of_one_bus_at_different_rates_are_pointed_out(program: Program, engine: Engine) -> None:
    warned: list[str] = []
    engine.world.warn = warned.append
    first, second = program("first"), program("second")
    on_line(first, SLOW)
    assert canwire.conflicts_on(first) == []
    on_line(second, QUICK, 1)
    (found,) = canwire.conflicts_on(first, "can0")
    assert str(found).startswith(
        "can0: different bit rates on one bus: HW000001:0 at 250000 bit/s, set by first ("
    )
    assert "HW000001:1 at 500000 bit/s, set by second (" in str(found)
    assert warned == [str(found)]
    assert canwire.conflicts_on(first, "can1") == []
    second.close()
    assert canwire.conflicts_on(first) == []


@pytest.mark.conforms("N-03")
@pytest.mark.finding("wire-2 1")
def test_timings_of_one_rate_that_could_not_work_on_copper_are_pointed_out() -> None:
    """500k/4M sampled at 87.5 % and at 75 %; said once, whoever starts the line again."""
    early, late = (
        LineMode(BitTiming.for_bit_rate(500_000, point), BitTiming.for_bit_rate(4_000_000, 0.8))
        for point in (0.75, 0.875)
    )
    with ExitStack() as stack:
        engine = stack.enter_context(embedded(CONFIG.replace("usb-to-can", "usb-to-can-fd"), time="virtual"))
        warned: list[str] = []
        engine.world.warn = warned.append
        first, second = (stack.enter_context(connected(engine, name)) for name in ("first", "second"))
        on_line(first, late)
        assert canwire.conflicts_on(first) == []
        on_line(second, early, 1)
        (found,) = canwire.conflicts_on(first, "can0")
        assert isinstance(found, canwire.TimingConflict)
        assert (found.check.what, found.check.figure) == ("sample points", 250.0)
        assert {line.address for line in found.lines} == {"HW000001:0", "HW000001:1"}
        assert str(found).startswith(
            "can0: this could not work on copper: HW000001:1 (75 % and 80 % after BRS) and HW"
        )
        assert warned == [str(found)]
        set_up(second, early, 1)
        assert warned == [str(found)]
        set_up(second, late, 1)
        assert canwire.conflicts_on(first) == []


@pytest.mark.conforms("N-03")
def test_a_cable_that_is_too_long_for_the_rate_is_pointed_out() -> None:
    config = CONFIG.replace('name = "can0"', 'name = "can0"\nlength_m = 300')
    with ExitStack() as stack:
        engine = stack.enter_context(embedded(config, time="virtual"))
        first, second = (stack.enter_context(connected(engine, name)) for name in ("first", "second"))
        on_line(first, QUICK)
        assert canwire.conflicts_on(first) == []
        on_line(second, QUICK, 1)
        (found,) = canwire.conflicts_on(first)
        assert "a shorter cable" in str(found)


@pytest.mark.conforms("N-03")
def test_an_oscillator_that_drifts_too_far_later_is_pointed_out_then() -> None:
    with ExitStack() as stack:
        engine = stack.enter_context(embedded(CONFIG, time="virtual"))
        warned: list[str] = []
        engine.world.warn = warned.append
        first, second = (stack.enter_context(connected(engine, name)) for name in ("first", "second"))
        on_line(first, QUICK)
        on_line(second, QUICK, 1)
        faults = first.bus("can0").faults
        faults.drift("HW000001:1", 100)
        assert (warned, canwire.conflicts_on(first)) == ([], [])
        drift = faults.drift("HW000001:1", 30_000)
        (found,) = canwire.conflicts_on(second)
        assert "drift apart" in str(found)
        assert warned == [str(found)]
        drift.cancel()
        assert canwire.conflicts_on(first) == []
