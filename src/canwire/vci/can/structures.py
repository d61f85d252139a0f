"""Structures of CAN sockets, controls, channels and schedulers.

Source: VCI V4 manual 7.3; cantype.h of VCI 4.1; reference/vci.md section 5. Classes
ending in 2 belong to the extended interfaces (ICanControl2 and so on).
"""

from __future__ import annotations

from canwire.vci.structures.members import bool8, bool32, nested, nested_array, octets, u8, u16, u32, x32
from canwire.vci.structures.structure import Structure, structure


@structure("CANBTP")
class CanBtp(Structure):
    """One bit timing.

    Without CAN_BTMODE_RAW in `mode`, `bps` is in bit/s and the others are ratios; ts1 / (ts1 + ts2) is the sample
    point. With it, `bps` is the prescaler and the others are quanta; a bit has 1 + ts1 + ts2 quanta. `tdo` is the
    offset of the second sample point, 0 for no transmitter delay compensation.
    Source: manual 7.3.4, 5.2.3.
    """

    mode: int = u32("dwMode")
    bps: int = u32("dwBPS")
    ts1: int = u16("wTS1")
    ts2: int = u16("wTS2")
    sjw: int = u16("wSJW")
    tdo: int = u16("wTDO")


@structure("CANBTRTABLE")
class CanBtrTable(Structure):
    """Timings for ICanControl.DetectBaud: the first `count` of 64 register pairs are tried.

    Registers are those of the SJA1000 at 16 MHz; `index` is the pair that was found.
    Source: manual 7.3.3.
    """

    count: int = u8("bCount")
    index: int = u8("bIndex")
    btr0: bytes = octets("abBtr0", 64)
    btr1: bytes = octets("abBtr1", 64)


@structure("CANBTPTABLE.asBTP")
class CanBtpPair(Structure):
    """One entry of CanBtpTable: timing of the arbitration (`sdr`) and of fast data (`fdr`)."""

    sdr: CanBtp = nested("sSdr", CanBtp)
    fdr: CanBtp = nested("sFdr", CanBtp)


@structure("CANBTPTABLE")
class CanBtpTable(Structure):
    """Timings for ICanControl2.DetectBaud: the first `count` of 64 pairs are tried.

    `index` is the pair that was found. Source: manual 7.3.5.
    """

    count: int = u8("bCount")
    index: int = u8("bIndex")
    btp: list[CanBtpPair] = nested_array("asBTP", CanBtpPair, 64)


@structure("CANCAPABILITIES", also=(("dwMaxCmsTicks", "cms_max_ticks"), ("dwMaxDtxTicks", "dtx_max_ticks")))
class CanCapabilities(Structure):
    """The capabilities of a controller: CAN_CTRL_, CAN_BUSC_, CAN_FEATURE_, and its clocks.

    `clock_freq` is in Hz. A tick of the time stamps (tsc), the cyclic list (cms) and delayed sending (dtx) lasts
    divisor / clock_freq seconds; the divisor is 0 if the controller lacks that counter. Source: manual 7.3.1.
    """

    ctrl_type: int = u16("wCtrlType")
    bus_coupling: int = u16("wBusCoupling")
    features: int = x32("dwFeatures")
    clock_freq: int = u32("dwClockFreq")
    tsc_divisor: int = u32("dwTscDivisor")
    cms_divisor: int = u32("dwCmsDivisor")
    cms_max_ticks: int = u32("dwCmsMaxTicks")
    dtx_divisor: int = u32("dwDtxDivisor")
    dtx_max_ticks: int = u32("dwDtxMaxTicks")


_MANUAL_CLOCKS = tuple(
    (f"dw{one.title()}ClockFreq", f"{one}_clk_freq") for one in ("can", "tsc", "cms", "dtx")
)


@structure("CANCAPABILITIES2", also=(("CtrlType", "ctrl_type"), *_MANUAL_CLOCKS))
class CanCapabilities2(Structure):
    """The capabilities of a controller: CAN_CTRL_, CAN_BUSC_, CAN_FEATURE_, the limits of its timing, its clocks.

    Limits are raw values, frequencies are in Hz. Each counter has its own clock and divisor; a tick lasts divisor /
    clk_freq seconds. Both are 0 if the controller lacks that counter. Source: manual 7.3.2.
    """

    ctrl_type: int = u16("wCtrlType")
    bus_coupling: int = u16("wBusCoupling")
    features: int = x32("dwFeatures")
    can_clk_freq: int = u32("dwCanClkFreq")
    sdr_range_min: CanBtp = nested("sSdrRangeMin", CanBtp)
    sdr_range_max: CanBtp = nested("sSdrRangeMax", CanBtp)
    fdr_range_min: CanBtp = nested("sFdrRangeMin", CanBtp)
    fdr_range_max: CanBtp = nested("sFdrRangeMax", CanBtp)
    tsc_clk_freq: int = u32("dwTscClkFreq")
    tsc_divisor: int = u32("dwTscDivisor")
    cms_clk_freq: int = u32("dwCmsClkFreq")
    cms_divisor: int = u32("dwCmsDivisor")
    cms_max_ticks: int = u32("dwCmsMaxTicks")
    dtx_clk_freq: int = u32("dwDtxClkFreq")
    dtx_divisor: int = u32("dwDtxDivisor")
    dtx_max_ticks: int = u32("dwDtxMaxTicks")


@structure("CANINITLINE")
class CanInitLine(Structure):
    """The configuration for ICanControl.InitLine: CAN_OPMODE_ flags and the SJA1000's timing at 16 MHz.

    Source: manual 7.3.6.
    """

    op_mode: int = u8("bOpMode")
    reserved: int = u8("bReserved")
    bt_reg0: int = u8("bBtReg0")
    bt_reg1: int = u8("bBtReg1")


@structure("CANINITLINE2")
class CanInitLine2(Structure):
    """The configuration for ICanControl2.InitLine: modes, filters of the line, both timings.

    `op_mode` has CAN_OPMODE_ flags, `ex_mode` CAN_EXMODE_ flags; `sf_mode` (11 bits) and `ef_mode` (29 bits) are
    CAN_FILTER_ modes; `sf_ids` and `ef_ids` are the numbers of identifiers in those filters, 0 for no filter.
    Source: manual 7.3.7.
    """

    op_mode: int = u8("bOpMode")
    ex_mode: int = u8("bExMode")
    sf_mode: int = u8("bSFMode")
    ef_mode: int = u8("bEFMode")
    sf_ids: int = u32("dwSFIds")
    ef_ids: int = u32("dwEFIds")
    btp_sdr: CanBtp = nested("sBtpSdr", CanBtp)
    btp_fdr: CanBtp = nested("sBtpFdr", CanBtp)


@structure("CANLINESTATUS")
class CanLineStatus(Structure):
    """State of a line: CAN_OPMODE_, timing registers, load in percent, CAN_STATUS_.

    Source: manual 7.3.8.
    """

    op_mode: int = u8("bOpMode")
    bt_reg0: int = u8("bBtReg0")
    bt_reg1: int = u8("bBtReg1")
    bus_load: int = u8("bBusLoad")
    status: int = x32("dwStatus")


@structure("CANLINESTATUS2")
class CanLineStatus2(Structure):
    """State of a line: CAN_OPMODE_, CAN_EXMODE_, load in percent, both timings, CAN_STATUS_.

    Source: manual 7.3.9.
    """

    op_mode: int = u8("bOpMode")
    ex_mode: int = u8("bExMode")
    bus_load: int = u8("bBusLoad")
    reserved: int = u8("bReserved")
    btp_sdr: CanBtp = nested("sBtpSdr", CanBtp)
    btp_fdr: CanBtp = nested("sBtpFdr", CanBtp)
    status: int = x32("dwStatus")


@structure("CANCHANSTATUS")
class CanChanStatus(Structure):
    """State of a message channel and of its line; loads of the FIFOs in percent.

    Source: manual 7.3.10.
    """

    line_status: CanLineStatus = nested("sLineStatus", CanLineStatus)
    activated: bool = bool32("fActivated")
    rx_overrun: bool = bool32("fRxOverrun")
    rx_fifo_load: int = u8("bRxFifoLoad")
    tx_fifo_load: int = u8("bTxFifoLoad")


@structure("CANCHANSTATUS2")
class CanChanStatus2(Structure):
    """State of a message channel and of its line; loads of the FIFOs in percent.

    Source: manual 7.3.11, which by mistake nests CANLINESTATUS.
    """

    line_status: CanLineStatus2 = nested("sLineStatus", CanLineStatus2)
    activated: bool = bool8("fActivated")
    rx_overrun: bool = bool8("fRxOverrun")
    rx_fifo_load: int = u8("bRxFifoLoad")
    tx_fifo_load: int = u8("bTxFifoLoad")


@structure("CANSCHEDULERSTATUS")
class CanSchedulerStatus(Structure):
    """State of a cyclic transmit list: CAN_CTXTSK_STAT_, and CAN_CTXMSG_STAT_ of its 16 entries.

    Source: manual 7.3.12.
    """

    task_stat: int = u8("bTaskStat")
    msg_stat: bytes = octets("abMsgStat", 16)


@structure("CANSCHEDULERSTATUS2")
class CanSchedulerStatus2(Structure):
    """State of a cyclic transmit list and of its line. Source: manual 7.3.13."""

    line_status: CanLineStatus2 = nested("sLineStatus", CanLineStatus2)
    task_stat: int = u8("bTaskStat")
    msg_stat: bytes = octets("abMsgStat", 16)


@structure("CANRTINFO")
class CanRtInfo(Structure):
    """The use of a controller: open and active channels, CAN_RTI_LOCKSTAT_, the load of the device's FIFOs in percent.

    Source: cantype.h of VCI 4.0 (ICanStatus); the manual does not describe it.
    """

    num_channels: int = u32("dwNumChannels")
    act_channels: int = u32("dwActChannels")
    lock_status: int = x32("dwLockStatus")
    rx_fifo_load: int = u16("wRxFifoLoad")
    tx_fifo_load: int = u16("wTxFifoLoad")
