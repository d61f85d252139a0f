"""LinLineStatus and LinMonitorStatus: how a line or a monitor was when somebody asked.

CAN's look alike; what they tell is of other flags.

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
        """V4's as V3's."""
        return cls(
            operating_mode=LinOperatingModes(status.op_mode),
            bitrate=LinBitrate(status.bitrate),
            busload=status.bus_load,
            controller_status=LinCtrlStatus(status.status),
        )

    @property
    def is_in_slave_mode(self) -> bool:
        """IsInSlaveMode: the line answers headers and sends none."""
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
    """A monitor: active or not, messages lost since Initialize or not, and how full its FIFO is in percent."""

    is_activated: bool
    has_fifo_overrun: bool
    receive_fifo_load: int

    @classmethod
    def of(cls, status: lin_structures.LinMonitorStatus) -> Self:
        """V4's as V3's, which leaves out the line."""
        return cls(
            is_activated=status.activated,
            has_fifo_overrun=status.rx_overrun,
            receive_fifo_load=status.rx_fifo_load,
        )
