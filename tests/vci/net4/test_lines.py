"""Sockets, control units, channels and cyclic lists of Ixxat.Vci4."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from canwire.vci import net4
from canwire.vci.net4 import CanBitrate, CanBitrate2, CanCyclicTXIncMode, CanCyclicTXStatus, CanFdBitrate
from canwire.vci.net4 import CanExtendedOperatingModes as ExModes
from canwire.vci.net4 import CanFilterModes as Filters
from canwire.vci.net4 import CanOperatingModes as Modes
from tests.vci.net4.programs import BOTH, CLASSIC_BOARD, FD, Net4, fill

TICK_S = 100e-6


def test_a_socket_says_what_its_line_can_do(virtual4: Net4) -> None:
    fd, classic = virtual4.open(net4.ICanSocket2), virtual4.open(net4.ICanSocket2, 0, CLASSIC_BOARD)
    assert fd.supports_extended_data_length
    assert fd.supports_iso_can_fd_frames
    assert not classic.supports_fast_data_rate
    assert fd.can_clock_frequency == 80_000_000
    assert fd.minimum_fast_data_bitrate.mode == net4.CanBitrateMode.RAW
    assert fd.maximum_arbitration_bitrate.prescaler > fd.minimum_arbitration_bitrate.prescaler
    assert classic.maximum_fast_data_bitrate == CanBitrate2.EMPTY
    assert virtual4.open(net4.ICanSocket).features == fd.features
    assert fd.time_stamp_counter_divisor / fd.time_stamp_counter_clock_frequency == 1e-6
    assert fd.cyclic_message_timer_divisor / fd.cyclic_message_timer_clock_frequency == TICK_S
    fd.dispose()
    with pytest.raises(net4.ObjectDisposedException):
        fd.delayed_tx_timer_divisor  # noqa: B018


def test_a_lines_status(virtual4: Net4) -> None:
    assert virtual4.open(net4.ICanSocket).line_status.is_mode_undefined
    control = virtual4.start(0)
    status = control.line_status
    assert (status.operating_mode, status.extended_operating_mode) == (BOTH, FD)
    assert (status.bitrate, status.fast_bitrate) == (CanBitrate2.CANFD_500_KBIT, CanBitrate2.CANFD_2000_KBIT)
    assert status.is_std_mode_enabled
    assert status.is_fast_data_enabled
    assert not status.is_non_iso_can_fd_enabled
    assert not status.is_in_init_mode
    assert not status.is_bus_c_err
    classic = virtual4.open(net4.ICanSocket).line_status
    assert (classic.is_mode_standard, classic.is_mode_undefined, classic.is_listen_only) == (
        True,
        False,
        False,
    )


def test_after_a_reset_the_line_is_offline_with_its_settings(virtual4: Net4) -> None:
    control = virtual4.start(0)
    before = control.line_status
    control.reset_line()
    after = control.line_status
    assert after.is_in_init_mode
    assert (after.operating_mode, after.extended_operating_mode) == (BOTH, FD)
    assert (after.bitrate, after.fast_bitrate) == (before.bitrate, before.fast_bitrate)
    control.start_line()


def test_what_the_line_lacks_is_named(virtual4: Net4) -> None:
    control = virtual4.open(net4.ICanControl2, 0, CLASSIC_BOARD)
    with pytest.raises(net4.VciException, match="CAN_FEATURE_EXTDATA"):
        control.init_line(BOTH, FD, 2, 0, 2, 0, CanBitrate2.CANFD_500_KBIT, CanBitrate2.CANFD_2000_KBIT)
    with pytest.raises(net4.VciException):
        control.start_line()


@pytest.mark.parametrize("ex_mode", [ExModes.UNDEFINED, ExModes.FAST_DATA_RATE])
def test_detecting_the_rates_of_a_bus(virtual4: Net4, ex_mode: ExModes) -> None:
    control = virtual4.open(net4.ICanControl2)
    with pytest.raises(net4.ArgumentException):
        control.detect_baud(Modes.STANDARD, ex_mode, 100, [])
    with pytest.raises(net4.VciException):
        control.detect_baud(Modes.STANDARD, ex_mode, 0, CanFdBitrate.CIA_BIT_RATES)
    rates = [
        CanFdBitrate(CanBitrate2.CIA_250_KBIT, CanBitrate2.CANFD_2000_KBIT),
        CanFdBitrate(CanBitrate2.CANFD_500_KBIT, CanBitrate2.CANFD_2000_KBIT),
    ]
    assert control.detect_baud(Modes.STANDARD, ex_mode, 10, rates) == -1
    virtual4.start(1)
    virtual4.start(0, CLASSIC_BOARD, fast=False)
    scheduler = virtual4.open(net4.ICanScheduler2, 1)
    message = scheduler.add_message()
    fill(message, 1, b"1", cycle_ticks=10)
    message.start(0)
    assert control.detect_baud(Modes.STANDARD, ex_mode, 100, rates) == 1


def test_finding_the_rate_when_the_line_is_set_up(virtual4: Net4) -> None:
    control = virtual4.open(net4.ICanControl)
    with pytest.raises(net4.VciException) as raised:
        control.init_line(Modes.STANDARD | Modes.AUTO_BAUDRATE, CanBitrate.EMPTY)
    assert raised.value.code == vci.VCI_E_TIMEOUT


def test_a_channels_own_filter(virtual4: Net4) -> None:
    virtual4.start(0, fast=False)
    virtual4.start(1, fast=False)
    sender, receiver = virtual4.port(0), virtual4.port(1)
    channel = receiver.channel
    channel.deactivate()
    assert channel.set_filter_mode(net4.CanFilter.STD, Filters.INCLUSIVE) == Filters.PASS
    assert channel.get_filter_mode(net4.CanFilter.STD) == Filters.INCLUSIVE
    channel.set_acc_filter(net4.CanFilter.STD, net4.CanAccCode.NONE, net4.CanAccMask.NONE)
    channel.add_filter_ids(net4.CanFilter.STD, 5 << 1, 0xFFF)
    channel.add_filter_ids(net4.CanFilter.STD, 6 << 1, 0xFFF)
    channel.rem_filter_ids(net4.CanFilter.STD, 6 << 1, 0xFFF)
    channel.activate()
    for identifier in (4, 5, 6):
        sender.writer.send_message(virtual4.message(net4.ICanMessage2, identifier))
    virtual4.hub.run_for(0.01)
    heard = [one for one in receiver.reader.read_messages() if one.frame_type == net4.CanMsgFrameType.DATA]
    assert [one.identifier for one in heard] == [5]
    assert channel.channel_status.is_activated


@pytest.mark.finding("vendor 12")
@pytest.mark.parametrize("kind", [net4.ICanChannel, net4.ICanChannel2, net4.ILinMonitor])
def test_before_initialize_a_channel_has_no_status(virtual4: Net4, kind: Any) -> None:
    monitor = kind is net4.ILinMonitor
    channel = virtual4.open(kind, 2 * monitor)
    with pytest.raises(net4.ObjectDisposedException):
        getattr(channel, "monitor_status" if monitor else "channel_status")


@pytest.mark.finding("vendor 5")
@pytest.mark.parametrize("kind", [net4.ICanChannel, net4.ICanChannel2, net4.ILinMonitor])
def test_an_exclusive_channel_is_alone(virtual4: Net4, kind: Any) -> None:
    """Ixxat.Vci4 opens a second one, and refuses its Initialize; V3's manual refuses to open it."""
    sizes: dict[Any, Any] = {
        net4.ICanChannel: (9, 9),
        net4.ICanChannel2: (9, 9, 1, 2),
        net4.ILinMonitor: (9,),
    }
    port, size = 2 * (kind is net4.ILinMonitor), sizes[kind]
    first = virtual4.open(kind, port)
    first.initialize(*size, True)
    second = virtual4.open(kind, port)
    with pytest.raises(net4.ObjectDisposedException):
        second.activate()
    for exclusive in (True, False):
        with pytest.raises(net4.VciException) as raised:
            second.initialize(*size, exclusive)
        assert raised.value.code == vci.VCI_E_ACCESSDENIED
    first.dispose()
    second.initialize(*size, True)
    second.activate()


def test_everything_that_waits_on_a_lin_line_is_read_at_once(virtual4: Net4) -> None:
    monitor = virtual4.open(net4.ILinMonitor, 2)
    monitor.initialize(10, False)
    monitor.activate()
    control = virtual4.open(net4.ILinControl, 2)
    control.init_line(net4.LinInitLine(net4.LinOperatingModes.MASTER, net4.LinBitrate.LIN_19200_BIT))
    control.start_line()
    with monitor.get_message_reader() as reader:
        assert reader.read_messages()[0].message_type == net4.LinMessageType.INFO
        assert reader.read_messages() == []
    with pytest.raises(net4.ObjectDisposedException):
        reader.read_messages()


# cyclic lists


class Rig:
    """A cyclic list on a started line, and a channel on another one."""

    def __init__(self, program: Net4, kind: Any) -> None:
        program.start(0)
        program.start(1)
        self.hub = program.hub
        self.port = program.port(1)
        self.scheduler = program.open(kind)

    def heard(self, ticks: int) -> list[Any]:
        self.hub.run_for(ticks * TICK_S)
        data = net4.CanMsgFrameType.DATA
        return [one for one in self.port.reader.read_messages() if one.frame_type == data]


@pytest.fixture(params=[net4.ICanScheduler, net4.ICanScheduler2])
def rig(virtual4: Net4, request: pytest.FixtureRequest) -> Rig:
    return Rig(virtual4, request.param)


@pytest.mark.finding("vendor 7")
def test_a_message_is_started_and_stopped_by_itself(rig: Rig) -> None:
    """The list runs from the beginning, and Status needs no UpdateStatus."""
    message = rig.scheduler.add_message()
    fill(message, 0x10, b"\x01", cycle_ticks=10)
    assert message.status is CanCyclicTXStatus.EMPTY
    message.stop()
    message.start(2)
    assert message.status is CanCyclicTXStatus.BUSY
    assert len(rig.heard(100)) == 2
    rig.scheduler.update_status()
    assert message.status is CanCyclicTXStatus.DONE
    message.start(0)
    assert len(rig.heard(105)) == 10
    message.stop()
    assert message.status is CanCyclicTXStatus.DONE
    assert len(rig.heard(100)) <= 1
    message.reset()
    assert message.status is CanCyclicTXStatus.EMPTY


def test_what_is_changed_counts_from_the_next_start(rig: Rig) -> None:
    message = rig.scheduler.add_message()
    fill(message, 0x10, b"\x01", cycle_ticks=10)
    message.start(0)
    message.identifier, message.cycle_ticks = 0x20, 20
    assert {one.identifier for one in rig.heard(100)} == {0x10}
    message.start(0)
    rig.heard(10)
    assert [one.identifier for one in rig.heard(100)] == [0x20] * 5


def test_sixteen_messages_share_the_ticks(rig: Rig) -> None:
    messages = [rig.scheduler.add_message() for _ in range(16)]
    with pytest.raises(net4.ArgumentOutOfRangeException):
        rig.scheduler.add_message()
    for number, message in enumerate(messages[:2]):
        fill(message, number, cycle_ticks=2)
        message.start(0)
    fill(messages[2], 2, cycle_ticks=2)
    with pytest.raises(net4.ArgumentException):
        messages[2].start(0)
    messages[0].reset()
    messages[2].start(0)
    assert {one.identifier for one in rig.heard(20)} >= {1, 2}
    rig.scheduler.reset()
    with pytest.raises(net4.ArgumentOutOfRangeException, match="was reset"):
        messages[0].start(0)
    for wrong in (-1, 65_536):
        with pytest.raises(net4.ArgumentOutOfRangeException):
            rig.scheduler.add_message().start(wrong)


@pytest.mark.finding("vendor 6")
@pytest.mark.parametrize(
    ("mode", "index", "length", "second"),
    [
        (CanCyclicTXIncMode.INC_16, 0, 0, b""),
        (CanCyclicTXIncMode.INC_16, 0, 1, b"\x01"),
        (CanCyclicTXIncMode.INC_16, 0, 2, b"\x01\x00"),
        (CanCyclicTXIncMode.INC_8, 2, 2, b"\x00\x00"),
        (CanCyclicTXIncMode.INC_8, 1, 2, b"\x00\x01"),
    ],
)
def test_counting_in_bytes_that_are_not_sent(
    rig: Rig, mode: CanCyclicTXIncMode, index: int, length: int, second: bytes
) -> None:
    message = rig.scheduler.add_message()
    fill(message, 1, bytes(length), cycle_ticks=10, auto_increment_mode=mode, auto_increment_index=index)
    message.start(2)
    heard = rig.heard(50)[1]
    assert bytes(heard[k] for k in range(heard.data_length)) == second
    assert (message.auto_increment_mode, message.auto_increment_index) == (mode, index)


def test_a_suspended_list_waits_for_resume(rig: Rig) -> None:
    rig.scheduler.suspend()
    message = rig.scheduler.add_message()
    fill(message, 1, cycle_ticks=10)
    message.start(0)
    assert rig.heard(50) == []
    rig.scheduler.resume()
    assert len(rig.heard(50)) >= 4


@pytest.mark.finding("vendor 9")
def test_a_disposed_list_is_gone(rig: Rig) -> None:
    message = rig.scheduler.add_message()
    fill(message, 1, cycle_ticks=10)
    message.start(0)
    rig.scheduler.dispose()
    rig.heard(1)
    assert rig.heard(50) == []
    assert message.status is CanCyclicTXStatus.EMPTY
    rig.scheduler.update_status()
    for use in (lambda: message.start(0), message.stop, rig.scheduler.add_message, rig.scheduler.resume):
        with pytest.raises(net4.ObjectDisposedException):
            use()


def test_a_long_cyclic_message(virtual4: Net4) -> None:
    rig = Rig(virtual4, net4.ICanScheduler2)
    message = rig.scheduler.add_message()
    data = bytes(range(64))
    fill(message, 1, data, cycle_ticks=50, extended_data_length=True, fast_data_rate=True)
    message.auto_increment_index = 63
    with pytest.raises(net4.ArgumentOutOfRangeException):
        message.auto_increment_index = 64
    message.auto_increment_mode = CanCyclicTXIncMode.INC_8
    message.start(2)
    first, second = rig.heard(200)
    assert [first[k] for k in range(64)] == list(data)
    assert (second[62], second[63], second.fast_data_rate) == (62, 64, True)
