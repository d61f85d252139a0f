"""The main window: the port, its settings and commands, and windows until the channels run out."""

from __future__ import annotations

import pytest

from canwire import BadValue
from canwire.candrv import CanbusEvent, CandrvError, CanMode, Command, FrameFormat
from tests.candrv.bench import Bench
from tests.web.cancheck.conftest import Program

pytestmark = pytest.mark.conforms("FT-06")


def test_it_shows_the_port_and_its_settings(program: Program) -> None:
    shown = program.port.shown()
    assert (shown.port, shown.rate, shown.mode, shown.format) == ("CID1:", 1_000_000, 0, 0)
    assert 500_000 in shown.rates
    assert shown.commands[0] == (1, "ENTER_STANDBY")
    assert len(shown.commands) == len(Command)


def test_settings_reach_the_device(program: Program) -> None:
    program.port.set_rate(125_000)
    program.port.set_mode(CanMode.CAN_2_0_B)
    program.port.set_format(FrameFormat.STD)
    shown = program.port.shown()
    assert (shown.rate, shown.mode, shown.format) == (125_000, 1, 1)


def test_a_typed_rate_need_not_be_in_the_list(program: Program) -> None:
    program.port.set_rate(40_000)
    assert program.port.shown().rate == 40_000


def test_a_refused_rate_leaves_what_is_shown(program: Program) -> None:
    with pytest.raises(CandrvError, match="ERROR_INVALID_PARAMETER"):
        program.port.set_rate(999_999_999)
    assert program.port.shown().rate == 1_000_000


def test_a_change_by_another_program_is_seen(program: Program, bench: Bench) -> None:
    with bench.open(read=False, write=False, hub=bench.program("another")) as other:
        other.can_mode = CanMode.CAN_2_0_B
        other.baud_rate = 250_000
    shown = program.port.shown()
    assert (shown.rate, shown.mode) == (250_000, 1)
    assert program.port.extended


def test_a_command_reaches_the_controller(program: Program) -> None:
    window = program.receive()
    program.port.command(Command.ENTER_STANDBY)
    program.run(0.01)
    program.port.command(Command.LEAVE_STANDBY)
    program.run(0.01)
    assert [row[0] for row in window.list.rows()] == ["ENTERING_STANDBY", "LEAVING_STANDBY"]


def test_an_unknown_command_is_refused(program: Program) -> None:
    with pytest.raises(CandrvError, match="command 99"):
        program.port.command(99)


def test_send_windows_open_until_the_channels_run_out(program: Program) -> None:
    numbers = [program.send().number for _ in range(3)]
    with pytest.raises(CandrvError, match=r"1450.*all 3 send channels are taken") as caught:
        program.send()
    assert caught.value.code == 1450
    assert len(set(numbers)) == len(program.windows) == 3
    program.close(numbers[0])
    program.send()


def test_receive_windows_open_until_the_channels_run_out(program: Program) -> None:
    program.receive()
    program.receive()
    with pytest.raises(CandrvError, match=r"1450.*all 2 receive channels"):
        program.pair()
    assert len(program.windows) == 2
    program.send()  # the refused pair has kept nothing


def test_the_main_window_and_the_page_s_listening_take_no_channel(program: Program) -> None:
    program.send()
    program.receive()
    program.receive()
    assert len(program.windows) == 3


def test_a_pair_shares_its_handle_and_others_do_not(program: Program) -> None:
    send, receive = program.pair()
    other = program.send()
    assert send.number == receive.number
    assert send.handle is receive.handle
    assert other.number != send.number


def test_transmitted_comes_to_a_pair_alone(program: Program) -> None:
    from tests.web.cancheck.test_send import recipe

    alone, (send, together) = program.receive(), program.pair()
    send.generators.add(recipe(0x123, delay_ms=1000), active=True)
    program.run(0.1)
    assert [row[0] for row in together.list.rows()] == [CanbusEvent.TRANSMITTED.name]
    assert alone.list.rows() == []


def test_another_port_leaves_open_windows_alone(program: Program, bench: Bench) -> None:
    window = program.receive()
    program.start(bench.hub, "CID1:")
    bench.peer.send()
    assert program.windows == [window]
    with pytest.raises(CandrvError, match="ERROR_FILE_NOT_FOUND"):
        program.start(bench.hub, "CID7:")
    assert program.port.name == "CID1:"


def test_leaving_closes_everything(program: Program) -> None:
    program.pair()
    program.leave()
    program.leave()
    assert (program.running, program.windows) == (False, [])
    with pytest.raises(BadValue, match="not running"):
        program.send()


def test_a_window_that_was_closed_is_named(program: Program) -> None:
    window = program.send()
    program.close(window.number)
    with pytest.raises(BadValue, match=f"handle {window.number:X}"):
        program.window(window.number, "send")
