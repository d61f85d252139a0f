"""LinLineStatus and LinMonitorStatus: the status of a line or a monitor at the time of the call.

Those of CAN are similar, but have other flags.

Source: VCI V3 .NET manual 4.3.2 and 4.3.3; reference/vci.md section 7a.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from canwire.vci.lin import structures as lin_structures
from canwire.vci.v3.lin.bitrate import LinBitrate
from canwire.vci.v3.lin.enums import LinCtrlStatus, LinOperatingModes


@dataclass(frozen=True, slots=True)
class LinLineStatus:
    """A line: `operating_mode`, `bitrate`, `busload` 0 to 100 percent."""

    operating_mode: LinOperatingModes
    bitrate: LinBitrate
    busload: int
    controller_status: LinCtrlStatus

    @classmethod
    def of(cls, status: lin_structures.LinLineStatus) -> Self:
        """V3's status for V4's status."""
        return cls(
            operating_mode=LinOperatingModes(status.op_mode),
            bitrate=LinBitrate(status.bitrate),
            busload=status.bus_load,
            controller_status=LinCtrlStatus(status.status),
        )

    @property
    def is_in_slave_mode(self) -> bool:
        """IsInSlaveMode: the line answers headers and does not send any."""
        return not self.is_in_master_mode

    @property
    def is_in_master_mode(self) -> bool:
        """IsInMasterMode: the line sends headers."""
        return bool(self.operating_mode & LinOperatingModes.MASTER)

    @property
    def is_err_mode_enabled(self) -> bool:
        """IsErrModeEnabled: errors are reported as messages."""
        return bool(self.operating_mode & LinOperatingModes.ERRORS)

    @property
    def has_data_overrun(self) -> bool:
        """HasDataOverrun: the controller lost received messages."""
        return bool(self.controller_status & LinCtrlStatus.OVERRUN)

    @property
    def is_in_init_mode(self) -> bool:
        """IsInInitMode: the controller is stopped."""
        return bool(self.controller_status & LinCtrlStatus.IN_INIT)


@dataclass(frozen=True, slots=True)
class LinMonitorStatus:
    """A monitor: whether it is active, whether messages were lost since Initialize, the load of its FIFO in percent."""

    is_activated: bool
    has_fifo_overrun: bool
    receive_fifo_load: int

    @classmethod
    def of(cls, status: lin_structures.LinMonitorStatus) -> Self:
        """V3's status for V4's status, without the line's status."""
        return cls(
            is_activated=status.activated,
            has_fifo_overrun=status.rx_overrun,
            receive_fifo_load=status.rx_fifo_load,
        )
