"""CanLineStatus and CanChannelStatus: the status of a line or a channel at the time of the call.

Source: VCI V3 .NET manual 4.2.2 and 4.2.3; reference/vci.md section 7a.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from canwire.vci.can import structures as can_structures
from canwire.vci.v3.can.bitrate import CanBitrate, named
from canwire.vci.v3.can.enums import CanCtrlStatus, CanOperatingModes


@dataclass(frozen=True, slots=True)
class CanLineStatus:
    """A line: `operating_mode`, `bitrate` (EMPTY if an SJA1000 cannot make it), `busload` 0 to 100 percent."""

    operating_mode: CanOperatingModes
    bitrate: CanBitrate
    busload: int
    controller_status: CanCtrlStatus

    @classmethod
    def of(cls, status: can_structures.CanLineStatus) -> Self:
        """V3's status for V4's status."""
        return cls(
            operating_mode=CanOperatingModes(status.op_mode),
            bitrate=named(CanBitrate(status.bt_reg0, status.bt_reg1)),
            busload=status.bus_load,
            controller_status=CanCtrlStatus(status.status),
        )

    @property
    def is_mode_undefined(self) -> bool:
        """IsModeUndefined: the line is not initialised."""
        return not self.operating_mode & CanOperatingModes.MODE_MASK

    @property
    def is_mode_standard(self) -> bool:
        """IsModeStandard: 11-bit identifiers are allowed."""
        return bool(self.operating_mode & CanOperatingModes.STANDARD)

    @property
    def is_mode_extended(self) -> bool:
        """IsModeExtended: 29-bit identifiers are allowed."""
        return bool(self.operating_mode & CanOperatingModes.EXTENDED)

    @property
    def is_error_frames_enabled(self) -> bool:
        """IsErrorFramesEnabled: errors are reported as messages."""
        return bool(self.operating_mode & CanOperatingModes.ERR_FRAME)

    @property
    def is_listen_only(self) -> bool:
        """IsListenOnly: the line neither sends nor acknowledges."""
        return bool(self.operating_mode & CanOperatingModes.LISTEN_ONLY)

    @property
    def is_low_speed_enabled(self) -> bool:
        """IsLowSpeedEnabled: the fault-tolerant coupling is used."""
        return bool(self.operating_mode & CanOperatingModes.LOW_SPEED)

    @property
    def is_transmit_pending(self) -> bool:
        """IsTransmitPending: a message waits in the controller or is being sent."""
        return bool(self.controller_status & CanCtrlStatus.TX_PENDING)

    @property
    def has_data_overrun(self) -> bool:
        """HasDataOverrun: the controller lost received messages."""
        return bool(self.controller_status & CanCtrlStatus.OVERRUN)

    @property
    def has_error_overrun(self) -> bool:
        """HasErrorOverrun: an error counter passed the warning limit."""
        return bool(self.controller_status & CanCtrlStatus.ERR_LIMIT)

    @property
    def is_bus_off(self) -> bool:
        """IsBusOff: the controller is in bus-off."""
        return bool(self.controller_status & CanCtrlStatus.BUS_OFF)

    @property
    def is_in_init_mode(self) -> bool:
        """IsInInitMode: the controller is stopped."""
        return bool(self.controller_status & CanCtrlStatus.IN_INIT)

    @property
    def is_bus_coupling_error(self) -> bool:
        """IsBusCErr: a fault of the low-speed coupling."""
        return bool(self.controller_status & CanCtrlStatus.BUS_C_ERR)


@dataclass(frozen=True, slots=True)
class CanChannelStatus:
    """A channel: whether it is active, whether it lost messages since Initialize, the load of its FIFOs in percent."""

    is_activated: bool
    has_fifo_overrun: bool
    receive_fifo_load: int
    transmit_fifo_load: int
