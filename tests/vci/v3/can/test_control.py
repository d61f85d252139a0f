"""ICanControl: one holder, its states, bit rates, starting and stopping."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from canwire.vci import v3
from tests.vci.programs import Program
from tests.vci.v3.programs import NetProgram

STANDARD, EXTENDED = v3.CanOperatingModes.STANDARD, v3.CanOperatingModes.EXTENDED
ERR_FRAME, LISTEN_ONLY = v3.CanOperatingModes.ERR_FRAME, v3.CanOperatingModes.LISTEN_ONLY
RATE = v3.CanBitrate.CIA_500_KBIT
ERROR, INFO = v3.CanMsgFrameType.ERROR, v3.CanMsgFrameType.INFO
MID_FRAME_S = 60e-6  # a message of 8 bytes takes some 220 us at 500 kbit/s


@pytest.mark.conforms("X3-08")
def test_one_program_at_a_time_controls_a_line(net: NetProgram, other_net: NetProgram) -> None:
    control = net.control()
    for program in (net, other_net):
        with pytest.raises(v3.VciException) as raised:
            program.open(v3.CanControl)
        assert raised.value.code == vci.VCI_E_ACCESSDENIED
    control.dispose()
    other_net.open(v3.CanControl)


@pytest.mark.conforms("X3-08")
def test_settings_stay_while_anything_is_open_on_the_line(net: NetProgram, other_net: NetProgram) -> None:
    port = other_net.port()
    net.start().dispose()
    status = port.channel.line_status
    assert (status.bitrate, status.is_in_init_mode) == (RATE, False)
    port.close()
    assert net.open(v3.CanSocket).line_status.is_mode_undefined


@pytest.mark.conforms("X3-08")
@pytest.mark.finding("vci F4")
@pytest.mark.parametrize("kind", [v3.CanSocket, v3.CanChannel, v3.CanScheduler])
def test_settings_stay_whatever_interface_is_open(net: NetProgram, kind: Any) -> None:
    control = net.control()
    other = net.open(kind)
    control.init_line(STANDARD, RATE)
    control.start_line()
    control.dispose()
    assert (other.line_status.bitrate, other.line_status.is_in_init_mode) == (RATE, False)
    other.dispose()
    assert net.open(v3.CanSocket).line_status.is_mode_undefined


@pytest.mark.conforms("X3-09")
def test_states(net: NetProgram) -> None:
    control = net.open(v3.CanControl)
    assert control.line_status.is_mode_undefined
    with pytest.raises(v3.VciException) as raised:
        control.start_line()
    assert raised.value.code == vci.VCI_E_NOT_INITIALIZED
    control.stop_line()
    control.reset_line()
    assert control.line_status.is_mode_undefined
    control.init_line(STANDARD, RATE)
    assert control.line_status.is_in_init_mode
    for leave in (control.stop_line, control.reset_line):
        control.start_line()
        assert not control.line_status.is_in_init_mode
        leave()
        assert control.line_status.is_in_init_mode
        assert control.line_status.is_mode_standard


@pytest.mark.conforms("X3-09")
def test_after_a_reset_the_line_starts_with_its_last_settings(net: NetProgram) -> None:
    mode = EXTENDED | ERR_FRAME
    control = net.start(mode=mode, bitrate=v3.CanBitrate.CIA_125_KBIT)
    control.reset_line()
    control.start_line()
    status = control.line_status
    assert (status.operating_mode, status.bitrate) == (mode, v3.CanBitrate.CIA_125_KBIT)


@pytest.mark.conforms("X3-09")
def test_a_reset_by_the_next_holder_knows_the_settings_too(net: NetProgram, other_net: NetProgram) -> None:
    other_net.open(v3.CanChannel)
    net.start().dispose()
    control = net.open(v3.CanControl)
    control.reset_line()
    control.start_line()
    assert control.line_status.bitrate == RATE


def test_a_line_that_v4_set_up_is_reset_to_what_v3_knows(net: NetProgram, program: Program) -> None:
    net.open(v3.CanChannel)
    program.start(0, ex_mode=vci.CAN_EXMODE_EXTDATA).release()
    heir = net.open(v3.CanControl)
    heir.reset_line()
    heir.start_line()
    assert heir.line_status.bitrate.name == "CiA 500 kbit/s"


@pytest.mark.conforms("X3-10")
@pytest.mark.parametrize(
    "mode", [STANDARD, EXTENDED, STANDARD | EXTENDED, STANDARD | ERR_FRAME, EXTENDED | LISTEN_ONLY]
)
def test_modes(net: NetProgram, mode: v3.CanOperatingModes) -> None:
    status = net.control(mode=mode).line_status
    assert status.operating_mode == mode
    assert status.is_mode_standard is bool(mode & STANDARD)
    assert status.is_mode_extended is bool(mode & EXTENDED)
    assert status.is_error_frames_enabled is bool(mode & ERR_FRAME)
    assert status.is_listen_only is bool(mode & LISTEN_ONLY)
    assert not status.is_low_speed_enabled


@pytest.mark.conforms("X3-10")
def test_low_speed_coupling(net: NetProgram) -> None:
    low = STANDARD | v3.CanOperatingModes.LOW_SPEED
    slow = v3.CanBitrate.CIA_125_KBIT
    assert net.control(board="HW000002", mode=low, bitrate=slow).line_status.is_low_speed_enabled
    with pytest.raises(v3.VciException) as raised:
        net.control(mode=low, bitrate=slow)
    assert raised.value.code == vci.VCI_E_NOT_SUPPORTED


@pytest.mark.conforms("X3-10")
@pytest.mark.parametrize("mode", [0, ERR_FRAME, STANDARD | 0x20, 0x100])
def test_modes_that_are_none(net: NetProgram, mode: int) -> None:
    control = net.open(v3.CanControl)
    with pytest.raises(v3.ArgumentException):
        control.init_line(mode, RATE)


@pytest.mark.conforms("X3-11")
@pytest.mark.parametrize("rate", [*v3.CanBitrate.CIA_BIT_RATES, v3.CanBitrate.KBIT_100], ids=str)
def test_lines_run_at_the_predefined_rates(net: NetProgram, message: Any, rate: v3.CanBitrate) -> None:
    net.start(1, bitrate=rate)
    control = net.control(0, bitrate=rate)
    sender, receiver = net.port(0), net.port(1, tx=0)
    sender.send(message(0x555), message(0x555))  # alternating bits: nothing is stuffed, CRC apart
    control.start_line()
    first, second = receiver.receive(2)
    timing = net.status().mode.timing
    assert timing.exact_bit_rate * rate.bittime == 16_000_000
    bit_times = (second.time_stamp - first.time_stamp) * 16 / rate.bittime
    assert bit_times == pytest.approx(48, abs=3)


# finding the bit rate


@pytest.fixture
def talk(net: NetProgram, cyclic: Any) -> Any:
    """Makes the lines of HW000001 1 and HW000002 0 talk at a bit rate."""

    def begin(rate: v3.CanBitrate) -> None:
        net.start(0, "HW000002", bitrate=rate)
        net.start(1, bitrate=rate)
        scheduler = net.open(v3.CanScheduler, 1)
        busy = cyclic(0x123, b"\x55\x55", cycle_ticks=20)
        scheduler.add_message(busy)
        scheduler.start_message(busy)
        scheduler.resume()

    return begin


@pytest.mark.conforms("X3-12")
@pytest.mark.parametrize("kbit", [125, 500, 1000])
def test_the_bit_rate_of_a_running_bus_is_found(net: NetProgram, talk: Any, kbit: int) -> None:
    rate = next(one for one in v3.CanBitrate.CIA_BIT_RATES if one.name == f"CiA {kbit} kbit/s")
    talk(rate)
    control = net.open(v3.CanControl)
    lines = [(0, "HW000001"), (1, "HW000001"), (0, "HW000002")]
    sent = net.status(0).frames_sent
    errors = [net.status(*line).errors for line in lines]
    index = control.detect_baud(1000, v3.CanBitrate.CIA_BIT_RATES)
    assert v3.CanBitrate.CIA_BIT_RATES[index] == rate
    assert net.status(0).frames_sent == sent
    assert [net.status(*line).errors for line in lines] == errors


@pytest.mark.conforms("X3-09")
def test_a_line_whose_bit_rate_was_found_is_offline(net: NetProgram, talk: Any) -> None:
    talk(RATE)
    control = net.open(v3.CanControl)
    assert control.detect_baud(1000, [v3.CanBitrate.CIA_125_KBIT, RATE]) == 1
    status = control.line_status
    assert (status.is_in_init_mode, status.is_mode_undefined, status.bitrate) == (True, False, RATE)
    control.start_line()
    assert not control.line_status.is_in_init_mode


@pytest.mark.conforms("X3-12")
def test_settings_that_a_line_has_are_not_touched(net: NetProgram, talk: Any) -> None:
    talk(RATE)
    control = net.control(mode=STANDARD, bitrate=v3.CanBitrate.CIA_20_KBIT)
    assert control.detect_baud(1000, [RATE]) == 0
    status = control.line_status
    assert (status.operating_mode, status.bitrate) == (STANDARD, v3.CanBitrate.CIA_20_KBIT)


@pytest.mark.conforms("X3-12")
def test_nothing_is_found_on_a_silent_bus(net: NetProgram) -> None:
    control = net.open(v3.CanControl)
    assert control.detect_baud(10, v3.CanBitrate.CIA_BIT_RATES) == -1
    assert control.line_status.is_mode_undefined


@pytest.mark.conforms("X3-12")
def test_indices_count_on_in_tables_of_more_than_64_rates(net: NetProgram, talk: Any) -> None:
    talk(RATE)
    rates = [v3.CanBitrate.CIA_10_KBIT] * 66 + [RATE]
    assert net.open(v3.CanControl).detect_baud(50, rates) == 66


def test_what_detect_baud_refuses(net: NetProgram) -> None:
    control = net.control()
    with pytest.raises(v3.ArgumentException):
        control.detect_baud(100, [])
    with pytest.raises(v3.VciException) as raised:
        control.detect_baud(0, [RATE])
    assert raised.value.code == vci.VCI_E_TIMEOUT
    with pytest.raises(v3.ArgumentOutOfRangeException):
        control.detect_baud(65_536, [RATE])
    control.start_line()
    with pytest.raises(v3.VciException):
        control.detect_baud(100, [RATE])


# leaving the bus


@pytest.fixture
def half_sent(virtual_net: NetProgram, message: Any) -> Any:
    """A line in the middle of a message, its control unit, and a channel on another line that reports errors."""
    control = virtual_net.start(0)
    virtual_net.start(1, mode=STANDARD | ERR_FRAME)
    sender, receiver = virtual_net.port(0), virtual_net.port(1)
    sender.send(message(0x100, b"\x55" * 8))
    virtual_net.hub.run_for(MID_FRAME_S)
    assert control.line_status.is_transmit_pending
    assert receiver.waiting() == []
    return virtual_net, control, receiver


@pytest.mark.conforms("X3-13")
def test_stop_waits_for_the_message_being_sent(half_sent: Any) -> None:
    program, control, receiver = half_sent
    control.stop_line()
    assert control.line_status.is_in_init_mode
    program.hub.run_for(1)
    kinds = [one.frame_type for one in receiver.waiting(None)]
    assert v3.CanMsgFrameType.DATA in kinds
    assert ERROR not in kinds


@pytest.mark.conforms("X3-14")
def test_reset_breaks_the_message_being_sent(half_sent: Any) -> None:
    program, control, receiver = half_sent
    control.reset_line()
    assert control.line_status.is_in_init_mode
    program.hub.run_for(1)
    heard = receiver.waiting(None)
    kinds = [one.frame_type for one in heard]
    assert v3.CanMsgFrameType.DATA not in kinds
    assert ERROR in kinds
    error = next(one for one in heard if one.frame_type == ERROR)
    assert v3.CanMsgError(error[0]) is v3.CanMsgError.STUFF


@pytest.mark.conforms("X3-13", "X3-14")
def test_stop_keeps_filters_and_reset_drops_them(net: NetProgram, message: Any) -> None:
    net.start(0)
    control = net.control(1)
    control.set_acc_filter(v3.CanFilter.STD, v3.CanAccCode.NONE, v3.CanAccMask.NONE)
    sender, receiver = net.port(0), net.port(1)
    control.start_line()
    control.stop_line()
    control.start_line()
    sender.send(message(0x100), message(0x101, extended_frame_format=True))
    assert [one.identifier for one in receiver.receive()] == [0x101]
    control.reset_line()
    control.start_line()
    sender.send(message(0x102))
    assert [one.identifier for one in receiver.receive()] == [0x102]


@pytest.mark.conforms("X3-09")
def test_channels_are_told_what_happens_to_the_controller(net: NetProgram) -> None:
    port = net.port()
    control = net.start()
    control.stop_line()
    control.reset_line()
    told = [v3.CanMsgInfoValue(one[0]) for one in port.receive(3, INFO)]
    assert told == [v3.CanMsgInfoValue.START, v3.CanMsgInfoValue.STOP, v3.CanMsgInfoValue.RESET]


def test_a_disposed_control_unit_does_nothing(net: NetProgram) -> None:
    control = net.control()
    control.dispose()
    for call in (control.start_line, control.stop_line, control.reset_line):
        with pytest.raises(v3.ObjectDisposedException):
            call()
