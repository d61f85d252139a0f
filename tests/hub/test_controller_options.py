"""What FD controllers have beside bit timing, on lines of a hub: from canwire.toml, and from programs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

import canwire
from canwire import (
    ChannelMode,
    Control,
    ControllerOptions,
    DelayCompensation,
    Frame,
    Hub,
    HubChannel,
    LineMode,
    TimingConflict,
    Unsupported,
)
from canwire.boards.config.configuration import Config
from tests.hub.in_memory import CLASSIC, FD, Bench

LONG = Frame(0x123, bytes(range(64)), fd=True, bit_rate_switch=True)
SHORT = Frame(0x124, b"\x55\xaa")
LATE = ControllerOptions(450)  # ns; the sample point of the data phase is at 400
COMPENSATING = ControllerOptions(compensation=DelayCompensation())


@contextmanager
def world(settings: str = "", kind: str = "usb-to-can-fd") -> Iterator[Hub]:
    """A board with these settings, a usual one, and an INduCAN104."""
    boards = f'[[board]]\nkind = "{kind}"\n{settings}\n[[board]]\nkind = "usb-to-can-fd"\n'
    bus = '[[bus]]\nname = "can0"\ndata_bit_rate = 2000000\n'
    made = Bench(Config.parse(bus + boards + '[[board]]\nkind = "inducan104"\n'))
    yield made.hub()
    made.close()


def started(hub: Hub, board: int, mode: LineMode = FD, *, line: int = 0) -> tuple[Control, HubChannel]:
    """A line of a board, running, and a channel on it."""
    number = hub.boards()[board].id
    control = hub.open_control(number, line)
    control.initialise(mode)
    control.start()
    channel = hub.open_channel(number, line)
    channel.set_up(ChannelMode(64, 64))
    channel.activate()
    hub.run_for(0.001)
    return control, channel


def arrives(hub: Hub, mode: LineMode) -> bool:
    """A long frame of the first board's gets through to the second."""
    control, channel = started(hub, 0, mode)
    _, partner = started(hub, 1)
    channel.send(LONG)
    hub.run_for(0.002)
    came = len(partner.receive_many(9)) == 1
    assert came == (control.status().errors == 0)
    return came


def test_a_program_says_how_late_it_reads_itself() -> None:
    for options, passes in (
        (None, True),
        (LATE, False),
        (replace(LATE, compensation=DelayCompensation()), True),
    ):
        with world() as hub:
            assert arrives(hub, replace(FD, options=options)) == passes


def test_the_transceiver_is_the_board_s_and_its_compensation_a_program_s() -> None:
    late = "loop_delay_ns = 450"
    for settings, options, passes in (
        (late, None, False),
        (late, ControllerOptions(), False),
        (late, COMPENSATING, True),
        (late + "\ndelay_compensation = true", None, True),
        (late + "\ndelay_compensation = true", ControllerOptions(), False),
    ):
        with world(settings) as hub:
            assert arrives(hub, replace(FD, options=options)) == passes, (settings, options)


@pytest.mark.parametrize("tolerant", [False, True])
def test_a_classic_board_among_fd_boards(tolerant: bool) -> None:
    with world(f"fd_tolerant = {str(tolerant).lower()}", "usb-to-can") as hub:
        control, classic = started(hub, 0, CLASSIC)
        _, sender = started(hub, 1)
        started(hub, 1, line=1)  # acknowledges
        sender.send(LONG)
        sender.send(SHORT)
        hub.run_for(0.002)
        assert (control.status().errors == 0) == tolerant
        assert [frame.id for frame in classic.receive_many(9)] == ([SHORT.id] if tolerant else [])


def test_options_come_back_as_they_were_given() -> None:
    options = ControllerOptions(
        250.5, DelayCompensation(400, 12.5), edge_filter=True, protocol_exception=False, restricted=True
    )
    with world() as hub:
        control, _ = started(hub, 0, replace(FD, options=options))
        mode = control.status().mode
        assert mode is not None
        assert mode.options == options


def test_a_line_in_restricted_operation_sends_nothing() -> None:
    with world() as hub:
        _, channel = started(hub, 0, replace(FD, options=ControllerOptions(restricted=True)))
        _, partner = started(hub, 1)
        partner.send(SHORT)
        channel.send(LONG)
        hub.run_for(0.002)
        assert [frame.id for frame in channel.receive_many(9)] == [SHORT.id]
        assert partner.receive_many(9) == []


def test_chips_have_none_of_it_and_nothing_changes() -> None:
    with world() as hub:
        control = hub.open_control(hub.boards()[2].id, 0)
        with pytest.raises(Unsupported, match="an SJA1000 has no edge_filter: only ideal controllers do"):
            control.initialise(LineMode(CLASSIC.timing, options=ControllerOptions(edge_filter=True)))
        assert not control.status().initialised
        control.initialise(LineMode(CLASSIC.timing, options=ControllerOptions()))
        assert control.status().initialised


@pytest.mark.conforms("N-03")
def test_a_boards_own_loop_delay_is_among_what_could_not_work_on_copper() -> None:
    """No program knows of it: it stands in canwire.toml, and every line's status tells it."""
    for settings, whats in (
        ("", []),
        ("loop_delay_ns = 450", ["delay compensation"]),
        ("loop_delay_ns = 450\ndelay_compensation = true", []),
    ):
        with world(settings) as hub:
            for board in (0, 1):
                started(hub, board)
            conflicts = canwire.conflicts_on(hub)
            assert [found.check.what for found in conflicts if isinstance(found, TimingConflict)] == whats
            assert len(conflicts) == len(whats)
            mode = hub.line_status(hub.boards()[0].id, 0).mode
            assert mode is not None
            assert (mode.options or ControllerOptions()).loop_delay_ns == (450 if settings else 0)
