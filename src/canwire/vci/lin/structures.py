"""Structures of LIN sockets, controls and monitors.

Source: VCI V4 manual 7.4; lintype.h of VCI 4.1; reference/vci.md section 5.
"""

from __future__ import annotations

from canwire.vci.structures.members import bool32, nested, u8, u16, u32, x32
from canwire.vci.structures.structure import Structure, structure


@structure("LINCAPABILITIES")
class LinCapabilities(Structure):
    """The capabilities of a controller: LIN_FEATURE_, and its clock.

    `clock_freq` is in Hz; a tick of the time stamps lasts tsc_divisor / clock_freq seconds.
    Source: manual 7.4.1, which by mistake has 16 bits of features.
    """

    features: int = x32("dwFeatures")
    clock_freq: int = u32("dwClockFreq")
    tsc_divisor: int = u32("dwTscDivisor")


@structure("LININITLINE")
class LinInitLine(Structure):
    """The configuration for ILinControl.InitLine: LIN_OPMODE_ flags and the bit rate.

    `bitrate` is in bit/s, LIN_BITRATE_MIN to LIN_BITRATE_MAX, or LIN_BITRATE_AUTO for a slave that can detect the bit
    rate. Source: manual 7.4.2.
    """

    op_mode: int = u8("bOpMode")
    reserved: int = u8("bReserved")
    bitrate: int = u16("wBitrate")


@structure("LINLINESTATUS", also=(("bReserved", "bus_load"),))
class LinLineStatus(Structure):
    """State of a line: LIN_OPMODE_, load in percent, bit rate in bit/s, LIN_STATUS_.

    Source: manual 7.4.3, where the load is still a reserved byte.
    """

    op_mode: int = u8("bOpMode")
    bus_load: int = u8("bBusLoad")
    bitrate: int = u16("wBitrate")
    status: int = x32("dwStatus")


@structure("LINMONITORSTATUS")
class LinMonitorStatus(Structure):
    """State of a message monitor and of its line; load of the FIFO in percent. Source: manual 7.4.4."""

    line_status: LinLineStatus = nested("sLineStatus", LinLineStatus)
    activated: bool = bool32("fActivated")
    rx_overrun: bool = bool32("fRxOverrun")
    rx_fifo_load: int = u8("bRxFifoLoad")
