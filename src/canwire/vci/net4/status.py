"""CanLineStatus and CanLineStatus2 of Ixxat.Vci4: the status of a line at the time of the call.

Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 7.3.8 and 7.3.9.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, TypeAlias, overload

from canwire.vci.can import structures
from canwire.vci.net4.bitrate import CanBitrate2
from canwire.vci.net4.enums import CanExtendedOperatingModes, CanOperatingModes
from canwire.vci.v3.can.bitrate import CanBitrate, named
from canwire.vci.v3.can.enums import CanCtrlStatus

_Bits: TypeAlias = "CanOperatingModes | CanExtendedOperatingModes | CanCtrlStatus"


class _Is:
    """Whether a bit of a status is set."""

    __slots__ = ("bit",)

    def __init__(self, bit: _Bits) -> None:
        self.bit = bit

    @overload
    def __get__(self, status: None, owner: type) -> Self: ...
    @overload
    def __get__(self, status: _Line, owner: type) -> bool: ...
    def __get__(self, status: _Line | None, owner: type) -> Self | bool:
        return self if status is None else status.has(self.bit)


class _Line:
    """The common part of both kinds: modes, load in percent and state of a line."""

    operating_mode: CanOperatingModes
    controller_status: CanCtrlStatus
    busload: int

    is_listen_only = _Is(CanOperatingModes.LISTEN_ONLY)
    is_low_speed_enabled = _Is(CanOperatingModes.LOW_SPEED)
    is_automatic_bitrate_detection_enabled = _Is(CanOperatingModes.AUTO_BAUDRATE)
    is_transmit_pending = _Is(CanCtrlStatus.TX_PENDING)
    has_data_overrun = _Is(CanCtrlStatus.OVERRUN)
    has_error_overrun = _Is(CanCtrlStatus.ERR_LIMIT)
    is_bus_off = _Is(CanCtrlStatus.BUS_OFF)
    is_in_init_mode = _Is(CanCtrlStatus.IN_INIT)
    is_bus_c_err = _Is(CanCtrlStatus.BUS_C_ERR)

    def has(self, bit: _Bits) -> bool:
        """Whether the bit of a mode or of the controller's status is set."""
        return bool(
            (self.operating_mode if isinstance(bit, CanOperatingModes) else self.controller_status) & bit
        )


@dataclass(frozen=True)
class CanLineStatus(_Line):
    """A line; `bitrate` is EMPTY if an SJA1000 cannot make it."""

    operating_mode: CanOperatingModes
    bitrate: CanBitrate
    busload: int
    controller_status: CanCtrlStatus

    is_mode_standard = _Is(CanOperatingModes.STANDARD)
    is_mode_extended = _Is(CanOperatingModes.EXTENDED)
    is_error_frames_enabled = _Is(CanOperatingModes.ERR_FRAME)

    @classmethod
    def of(cls, status: structures.CanLineStatus) -> Self:
        """The status for V4's structure."""
        return cls(
            CanOperatingModes(status.op_mode),
            named(CanBitrate(status.bt_reg0, status.bt_reg1)),
            status.bus_load,
            CanCtrlStatus(status.status),
        )

    @property
    def is_mode_undefined(self) -> bool:
        """IsModeUndefined: the line is not initialised."""
        return not self.operating_mode & CanOperatingModes.MODE_MASK


@dataclass(frozen=True)
class CanLineStatus2(_Line):
    """A CAN FD line, with both its bit rates."""

    operating_mode: CanOperatingModes
    extended_operating_mode: CanExtendedOperatingModes
    busload: int
    controller_status: CanCtrlStatus
    bitrate: CanBitrate2
    fast_bitrate: CanBitrate2

    is_std_mode_enabled = _Is(CanOperatingModes.STANDARD)
    is_ext_mode_enabled = _Is(CanOperatingModes.EXTENDED)
    is_err_mode_enabled = _Is(CanOperatingModes.ERR_FRAME)
    is_extended_data_length_enabled = _Is(CanExtendedOperatingModes.EXTENDED_DATA_LENGTH)
    is_fast_data_enabled = _Is(CanExtendedOperatingModes.FAST_DATA_RATE)
    is_non_iso_can_fd_enabled = _Is(CanExtendedOperatingModes.NON_ISO_CAN_FD)

    @classmethod
    def of(cls, status: structures.CanLineStatus2) -> Self:
        """The status for V4's structure."""
        return cls(
            CanOperatingModes(status.op_mode),
            CanExtendedOperatingModes(status.ex_mode),
            status.bus_load,
            CanCtrlStatus(status.status),
            CanBitrate2.of(status.btp_sdr),
            CanBitrate2.of(status.btp_fdr),
        )

    def has(self, bit: _Bits) -> bool:
        if isinstance(bit, CanExtendedOperatingModes):
            return bool(self.extended_operating_mode & bit)
        return super().has(bit)
