"""The configuration and the status of a line: conversion between VCI's structures and canwire's.

A line stores the structure with which it was initialised, so that each program reads the same values.
Source: VCI V4 manual 5.2.3 and 7.3.6 to 7.3.9; reference/vci.md sections 3 and 7a.
"""

from __future__ import annotations

from canwire import BitTiming, Capabilities, ErrorState, FilterMode, FilterSetup, LineMode, LineStatus
from canwire.vci.bus_line import KIN
from canwire.vci.can.structures import CanInitLine, CanInitLine2, CanLineStatus, CanLineStatus2
from canwire.vci.can.timing import btp_of_timing, registers_of_timing, timing_of_btp, timing_of_registers
from canwire.vci.structures.constants import (
    CAN_BUSC_LOWSPEED,
    CAN_EXMODE_EXTDATA,
    CAN_EXMODE_FASTDATA,
    CAN_EXMODE_NONISO,
    CAN_FEATURE_AUTOBAUD,
    CAN_FEATURE_ERRFRAME,
    CAN_FEATURE_EXTDATA,
    CAN_FEATURE_FASTDATA,
    CAN_FEATURE_ISOFRAME,
    CAN_FEATURE_LISTONLY,
    CAN_FEATURE_NONISOFRM,
    CAN_FEATURE_STDANDEXT,
    CAN_FEATURE_STDOREXT,
    CAN_FILTER_EXCL,
    CAN_FILTER_LOCK,
    CAN_OPMODE_AUTOBAUD,
    CAN_OPMODE_ERRFRAME,
    CAN_OPMODE_EXTENDED,
    CAN_OPMODE_LISTONLY,
    CAN_OPMODE_LOWSPEED,
    CAN_OPMODE_STANDARD,
    CAN_STATUS_BUSCERR,
    CAN_STATUS_BUSOFF,
    CAN_STATUS_ERRLIM,
    CAN_STATUS_ININIT,
    CAN_STATUS_TXPEND,
)
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VCI_E_NOT_SUPPORTED, VciError

_BOTH = CAN_OPMODE_STANDARD | CAN_OPMODE_EXTENDED
_OPMODES = _BOTH | CAN_OPMODE_ERRFRAME | CAN_OPMODE_LISTONLY | CAN_OPMODE_LOWSPEED | CAN_OPMODE_AUTOBAUD
_FD = CAN_EXMODE_EXTDATA | CAN_EXMODE_FASTDATA
_EXMODES = _FD | CAN_EXMODE_NONISO
_OPMODE_NEEDS = (
    (CAN_OPMODE_ERRFRAME, CAN_FEATURE_ERRFRAME, "CAN_OPMODE_ERRFRAME needs CAN_FEATURE_ERRFRAME"),
    (CAN_OPMODE_LISTONLY, CAN_FEATURE_LISTONLY, "CAN_OPMODE_LISTONLY needs CAN_FEATURE_LISTONLY"),
    (CAN_OPMODE_AUTOBAUD, CAN_FEATURE_AUTOBAUD, "CAN_OPMODE_AUTOBAUD needs CAN_FEATURE_AUTOBAUD"),
)
_EXMODE_NEEDS = (
    (CAN_EXMODE_EXTDATA, CAN_FEATURE_EXTDATA, "CAN_EXMODE_EXTDATA needs CAN_FEATURE_EXTDATA"),
    (CAN_EXMODE_FASTDATA, CAN_FEATURE_FASTDATA, "CAN_EXMODE_FASTDATA needs CAN_FEATURE_FASTDATA"),
    (CAN_EXMODE_NONISO, CAN_FEATURE_NONISOFRM, "CAN_EXMODE_NONISO needs CAN_FEATURE_NONISOFRM"),
)
_INCLUSIVE = FilterSetup()
_NOTE, _NOTE2 = b"CANINITLINE ", b"CANINITLINE2 "
_ERROR_STATES = (ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF)


def mode_of_init(init: CanInitLine, capabilities: Capabilities) -> LineMode:
    """The mode for ICanControl.InitLine; both filters are inclusive, with lists of 2048 identifiers.

    Raises VciNotSupported, which names the missing feature, and VciInvalidArgument for an invalid mode.
    """
    note = _NOTE + init.to_bytes()
    check_op_mode(init.op_mode, capabilities)
    timing = None
    if not init.op_mode & CAN_OPMODE_AUTOBAUD:
        timing = timing_of_registers(init.bt_reg0, init.bt_reg1)
    return _line_mode(init.op_mode, timing, note=note)


def mode_of_init2(init: CanInitLine2, capabilities: Capabilities) -> LineMode:
    """The mode for ICanControl2.InitLine.

    Raises what `mode_of_init` raises, BadTiming for timings that the line cannot make, and VciNotSupported for
    CAN_OPMODE_AUTOBAUD with CAN_EXMODE_FASTDATA, since only the nominal rate can be detected.
    """
    note = _NOTE2 + init.to_bytes()
    check_op_mode(init.op_mode, capabilities)
    check_ex_mode(init.ex_mode, capabilities)
    timing = data_timing = None
    if not init.op_mode & CAN_OPMODE_AUTOBAUD:
        timing = timing_of_btp(init.btp_sdr, capabilities, data=False)
    elif init.ex_mode & CAN_EXMODE_FASTDATA:
        raise VciError.of(VCI_E_NOT_SUPPORTED, "CAN_OPMODE_AUTOBAUD cannot detect the fast data bit rate")
    if init.ex_mode & CAN_EXMODE_FASTDATA:
        data_timing = timing_of_btp(init.btp_fdr, capabilities, data=True)
    standard_filter, extended_filter = _filter_setups(init)
    return _line_mode(
        init.op_mode, timing, data_timing, init.ex_mode, standard_filter, extended_filter, note=note
    )


def check_op_mode(op_mode: int, capabilities: Capabilities) -> None:
    """Raises VciInvalidArgument or VciNotSupported if the line cannot have this bOpMode."""
    if op_mode & ~_OPMODES or not op_mode & _BOTH:
        what = "it needs CAN_OPMODE_ flags with STANDARD, EXTENDED or both"
        raise VciError.of(VCI_E_INVALIDARG, f"operating mode {op_mode:#04x}: {what}")
    if op_mode & _BOTH == _BOTH:
        _need(capabilities, CAN_FEATURE_STDANDEXT, "both frame formats need CAN_FEATURE_STDANDEXT")
    elif not capabilities.features & (CAN_FEATURE_STDOREXT | CAN_FEATURE_STDANDEXT):
        _need(capabilities, CAN_FEATURE_STDOREXT, "one frame format needs CAN_FEATURE_STDOREXT")
    for flag, feature, what in _OPMODE_NEEDS:
        if op_mode & flag:
            _need(capabilities, feature, what)
    check_coupling(op_mode, capabilities)


def check_coupling(op_mode: int, capabilities: Capabilities) -> None:
    """Raises VciNotSupported for CAN_OPMODE_LOWSPEED on a line without that coupling."""
    if op_mode & CAN_OPMODE_LOWSPEED and not capabilities.bus_coupling & CAN_BUSC_LOWSPEED:
        what = "CAN_OPMODE_LOWSPEED needs CAN_BUSC_LOWSPEED: this line does not have it"
        raise VciError.of(VCI_E_NOT_SUPPORTED, what)


def check_ex_mode(ex_mode: int, capabilities: Capabilities) -> None:
    """Raises VciInvalidArgument or VciNotSupported if the line cannot have this bExMode."""
    if ex_mode & ~_EXMODES:
        raise VciError.of(VCI_E_INVALIDARG, f"extended operating mode {ex_mode:#04x}: not CAN_EXMODE_ flags")
    for flag, feature, what in _EXMODE_NEEDS:
        if ex_mode & flag:
            _need(capabilities, feature, what)
    if ex_mode & _FD and not ex_mode & CAN_EXMODE_NONISO:
        _need(
            capabilities, CAN_FEATURE_ISOFRAME, "CAN FD without CAN_EXMODE_NONISO needs CAN_FEATURE_ISOFRAME"
        )


def line_status(status: LineStatus) -> CanLineStatus:
    """CANLINESTATUS of a line; both registers are 0 if an SJA1000 cannot make the bit rate."""
    made = CanLineStatus(bus_load=_load(status), status=_flags(status))
    if status.initialised and status.mode is not None:
        init = _noted(status.mode)
        made.op_mode = _op_mode(status.mode) if init is None else init.op_mode
        if isinstance(init, CanInitLine) and not init.op_mode & CAN_OPMODE_AUTOBAUD:
            made.bt_reg0, made.bt_reg1 = init.bt_reg0, init.bt_reg1
        elif status.mode.timing is not None:
            made.bt_reg0, made.bt_reg1 = registers_of_timing(status.mode.timing)
    return made


def line_status2(status: LineStatus) -> CanLineStatus2:
    """CANLINESTATUS2 of a line; timings as given to InitLine, otherwise in bit/s and ratios."""
    made = CanLineStatus2(bus_load=_load(status), status=_flags(status))
    if status.initialised and status.mode is not None:
        mode, init = status.mode, _noted(status.mode)
        made.op_mode = _op_mode(mode) if init is None else init.op_mode
        made.ex_mode = init.ex_mode if isinstance(init, CanInitLine2) else _ex_mode(mode)
        made.btp_sdr, made.btp_fdr = btp_of_timing(mode.timing), btp_of_timing(mode.data_timing)
        if isinstance(init, CanInitLine2):
            made.btp_fdr = init.btp_fdr
            if not init.op_mode & CAN_OPMODE_AUTOBAUD:
                made.btp_sdr = init.btp_sdr
    return made


def _line_mode(
    op_mode: int,
    timing: BitTiming | None,
    data_timing: BitTiming | None = None,
    ex_mode: int = 0,
    standard_filter: FilterSetup = _INCLUSIVE,
    extended_filter: FilterSetup = _INCLUSIVE,
    *,
    note: bytes,
) -> LineMode:
    return LineMode(
        timing=timing,
        data_timing=data_timing,
        long_data=bool(ex_mode & CAN_EXMODE_EXTDATA),
        iso_fd=not ex_mode & CAN_EXMODE_NONISO,
        standard=bool(op_mode & CAN_OPMODE_STANDARD),
        extended=bool(op_mode & CAN_OPMODE_EXTENDED),
        error_frames=bool(op_mode & CAN_OPMODE_ERRFRAME),
        listen_only=bool(op_mode & CAN_OPMODE_LISTONLY),
        low_speed=bool(op_mode & CAN_OPMODE_LOWSPEED),
        standard_filter=standard_filter,
        extended_filter=extended_filter,
        note=note,
        kin=KIN,
    )


def _filter_setups(init: CanInitLine2) -> tuple[FilterSetup, FilterSetup]:
    """A size of 0 makes no filter, with any mode; otherwise the mode must be a CAN_FILTER_ mode."""
    setups = []
    for name, mode, size in (("bSFMode", init.sf_mode, init.sf_ids), ("bEFMode", init.ef_mode, init.ef_ids)):
        if size and not CAN_FILTER_LOCK <= mode <= CAN_FILTER_EXCL:
            raise VciError.of(VCI_E_INVALIDARG, f"CANINITLINE2.{name} {mode:#04x}: not a CAN_FILTER_ mode")
        setups.append(FilterSetup(FilterMode(mode) if size else FilterMode.PASS, size))
    return setups[0], setups[1]


def _need(capabilities: Capabilities, feature: int, what: str) -> None:
    if not capabilities.can(feature):
        raise VciError.of(VCI_E_NOT_SUPPORTED, f"{what}: this line does not have it")


def _noted(mode: LineMode) -> CanInitLine | CanInitLine2 | None:
    """The structure that InitLine got; None if a program of another dialect initialised the line."""
    if mode.note.startswith(_NOTE):
        return CanInitLine.from_bytes(mode.note.removeprefix(_NOTE))
    if mode.note.startswith(_NOTE2):
        return CanInitLine2.from_bytes(mode.note.removeprefix(_NOTE2))
    return None


def _op_mode(mode: LineMode) -> int:
    return (
        CAN_OPMODE_STANDARD * mode.standard
        | CAN_OPMODE_EXTENDED * mode.extended
        | CAN_OPMODE_ERRFRAME * mode.error_frames
        | CAN_OPMODE_LISTONLY * mode.listen_only
        | CAN_OPMODE_LOWSPEED * mode.low_speed
    )


def _ex_mode(mode: LineMode) -> int:
    flags = CAN_EXMODE_EXTDATA * mode.long_data | CAN_EXMODE_FASTDATA * (mode.data_timing is not None)
    return flags | CAN_EXMODE_NONISO * (flags != 0 and not mode.iso_fd)


def _load(status: LineStatus) -> int:
    return max(0, min(100, round(status.load)))


def _flags(status: LineStatus) -> int:
    """The CAN_STATUS_ flags; OVRRUN is never set, since the simulated controller loses no frame."""
    return (
        CAN_STATUS_TXPEND * status.transmitting
        | CAN_STATUS_ERRLIM * (status.state in _ERROR_STATES)
        | CAN_STATUS_BUSOFF * (status.state == ErrorState.BUS_OFF)
        | CAN_STATUS_ININIT * (not status.running)
        | CAN_STATUS_BUSCERR * status.coupling_fault
    )
