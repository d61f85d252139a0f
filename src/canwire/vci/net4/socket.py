"""ICanSocket and ICanSocket2 of Ixxat.Vci4: the capabilities and the status of a line.

Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 5.2.1, 6.6.2 and 7.3.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, overload
from uuid import UUID

from canwire.vci.net4.bitrate import CanBitrate2
from canwire.vci.net4.enums import CanFeatures
from canwire.vci.net4.status import CanLineStatus, CanLineStatus2
from canwire.vci.structures.guids import IID_ICanSocket2
from canwire.vci.v3.bus_socket import BusSocket
from canwire.vci.v3.can import socket as v3
from canwire.vci.v3.can.enums import CanBusCouplings, CanCtrlType
from canwire.vci.v3.disposable import net_call

if TYPE_CHECKING:
    from canwire.vci.can import socket as can_socket
    from canwire.vci.can import structures as can_structures


class _Supports:
    """Whether a controller has a feature."""

    __slots__ = ("feature",)

    def __init__(self, feature: CanFeatures) -> None:
        self.feature = feature

    @overload
    def __get__(self, socket: None, owner: type) -> Self: ...
    @overload
    def __get__(self, socket: _Able, owner: type) -> bool: ...
    def __get__(self, socket: _Able | None, owner: type) -> Self | bool:
        return self if socket is None else self.feature in socket.features


class _Able:
    """The features of the controller, in both kinds of socket."""

    supports_std_or_ext_frames = _Supports(CanFeatures.STD_OR_EXT)
    supports_std_and_ext_frames = _Supports(CanFeatures.STD_AND_EXT)
    supports_remote_frames = _Supports(CanFeatures.REMOTE_FRAME)
    supports_error_frames = _Supports(CanFeatures.ERR_FRAME)
    supports_bus_load_computation = _Supports(CanFeatures.BUSLOAD)
    supports_exact_message_filter = _Supports(CanFeatures.ID_FILTER)
    supports_listen_only_mode = _Supports(CanFeatures.LIST_ONLY)
    supports_cyclic_message_scheduler = _Supports(CanFeatures.SCHEDULER)
    supports_error_frame_generation = _Supports(CanFeatures.GEN_ERR_FRAME)
    supports_delayed_transmission = _Supports(CanFeatures.DELAYED_TX)

    @property
    def features(self) -> CanFeatures:
        raise NotImplementedError


class CanSocket(_Able, v3.CanSocket):
    """ICanSocket: the same as in V3, but with V4's features and modes."""

    @property
    @net_call
    def features(self) -> CanFeatures:  # type: ignore[override]  # V3 has other bits
        """Features."""
        with self._bal.open_socket(self.bus_port, IID_ICanSocket2) as socket:
            return CanFeatures(socket.get_capabilities().features)

    @property
    @net_call
    def line_status(self) -> CanLineStatus:  # type: ignore[override]  # as above
        """LineStatus: settings, load and state of the controller now."""
        return CanLineStatus.of(self._socket.get_line_status())


class CanSocket2(_Able, BusSocket):
    """ICanSocket2: a CAN FD line. Any number of programs may have one; it cannot change the line.

    A tick of a timer lasts its divisor / its clock frequency seconds; both are 0 if the controller lacks the timer.
    """

    _iid: ClassVar[UUID] = IID_ICanSocket2
    _socket: can_socket.CanSocket2

    supports_single_shot_messages = _Supports(CanFeatures.SINGLE_SHOT)
    supports_high_priority_messages = _Supports(CanFeatures.HIGH_PRIORITY_MSG)
    supports_auto_baudrate_detection = _Supports(CanFeatures.AUTO_BAUDRATE)
    supports_extended_data_length = _Supports(CanFeatures.EXTENDED_DATA_LENGTH)
    supports_fast_data_rate = _Supports(CanFeatures.FAST_DATA_RATE)
    supports_iso_can_fd_frames = _Supports(CanFeatures.ISO_CAN_FD)
    supports_non_iso_can_fd_frames = _Supports(CanFeatures.NON_ISO_CAN_FD)
    supports64_bit_time_stamps = _Supports(CanFeatures.LONG_BIT_TIME_STAMP)

    @net_call
    def _able(self) -> can_structures.CanCapabilities2:
        return self._socket.get_capabilities()

    @property
    def controller_type(self) -> CanCtrlType:
        """ControllerType."""
        return CanCtrlType(self._able().ctrl_type)

    @property
    def bus_coupling(self) -> CanBusCouplings:
        """BusCoupling."""
        return CanBusCouplings(self._able().bus_coupling)

    @property
    def features(self) -> CanFeatures:
        """Features."""
        return CanFeatures(self._able().features)

    @property
    def can_clock_frequency(self) -> int:
        """CanClockFrequency in Hz, the clock of raw bit timings."""
        return self._able().can_clk_freq

    @property
    def minimum_arbitration_bitrate(self) -> CanBitrate2:
        """MinimumArbitrationBitrate: the least raw numbers."""
        return CanBitrate2.of(self._able().sdr_range_min)

    @property
    def maximum_arbitration_bitrate(self) -> CanBitrate2:
        """MaximumArbitrationBitrate: the largest raw numbers."""
        return CanBitrate2.of(self._able().sdr_range_max)

    @property
    def minimum_fast_data_bitrate(self) -> CanBitrate2:
        """MinimumFastDataBitrate: the least raw numbers; EMPTY without a fast phase."""
        return CanBitrate2.of(self._able().fdr_range_min)

    @property
    def maximum_fast_data_bitrate(self) -> CanBitrate2:
        """MaximumFastDataBitrate: the largest raw numbers; EMPTY without a fast phase."""
        return CanBitrate2.of(self._able().fdr_range_max)

    @property
    def clock_frequency(self) -> int:
        """The clock of the time stamps in Hz, as in V3's sockets."""
        return self._able().tsc_clk_freq

    time_stamp_counter_clock_frequency = clock_frequency

    @property
    def time_stamp_counter_divisor(self) -> int:
        """TimeStampCounterDivisor."""
        return self._able().tsc_divisor

    @property
    def cyclic_message_timer_clock_frequency(self) -> int:
        """CyclicMessageTimerClockFrequency in Hz."""
        return self._able().cms_clk_freq

    @property
    def cyclic_message_timer_divisor(self) -> int:
        """CyclicMessageTimerDivisor."""
        return self._able().cms_divisor

    @property
    def max_cyclic_message_ticks(self) -> int:
        """MaxCyclicMessageTicks: the longest cycle."""
        return self._able().cms_max_ticks

    @property
    def delayed_tx_timer_clock_frequency(self) -> int:
        """DelayedTXTimerClockFrequency in Hz."""
        return self._able().dtx_clk_freq

    @property
    def delayed_tx_timer_divisor(self) -> int:
        """DelayedTXTimerDivisor."""
        return self._able().dtx_divisor

    @property
    def max_delayed_tx_ticks(self) -> int:
        """MaxDelayedTXTicks: the longest delay."""
        return self._able().dtx_max_ticks

    @property
    @net_call
    def line_status(self) -> CanLineStatus2:
        """LineStatus: settings, load and state of the controller now."""
        return CanLineStatus2.of(self._socket.get_line_status())
