"""The configuration, the status and the messages of a LIN line: conversion between VCI's structures and canwire's.

can/line.py is similar, but its words have other bits.

A line stores the structure with which it was initialised, so that each program reads the same values.
Source: VCI V4 manual 5.3.3 and 7.4.1 to 7.4.6; reference/vci.md section 4.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import LinFrame, LinMode
from canwire.vci.lin.constants import (
    LIN_BITRATE_UNDEF,
    LIN_OPMODE_ERRORS,
    LIN_OPMODE_MASTER,
    LIN_PIDMASK_ID,
    LIN_STATUS_ININIT,
    LIN_STATUS_TXPEND,
)
from canwire.vci.lin.structures import LinCapabilities, LinInitLine, LinLineStatus
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError

if TYPE_CHECKING:
    import canwire
    from canwire.vci.lin.message import LinMsg

_OPMODES = LIN_OPMODE_MASTER | LIN_OPMODE_ERRORS
_NOTE = b"LININITLINE "
_KIN = "VCI"  # VCI programs may configure a line that another VCI program runs, as in the manual
_LONGEST = 8


def capabilities_of(capabilities: canwire.LinCapabilities) -> LinCapabilities:
    """LINCAPABILITIES."""
    return LinCapabilities(
        features=capabilities.features,
        clock_freq=capabilities.stamps.clock_hz,
        tsc_divisor=capabilities.stamps.divisor,
    )


def mode_of_init(init: LinInitLine) -> LinMode:
    """The mode for ILinControl.InitLine; raises VciInvalidArgument for an invalid operating mode."""
    note = _NOTE + init.to_bytes()
    if init.op_mode & ~_OPMODES:
        raise VciError.of(VCI_E_INVALIDARG, f"operating mode {init.op_mode:#04x}: not LIN_OPMODE_ flags")
    return LinMode(
        master=bool(init.op_mode & LIN_OPMODE_MASTER),
        bit_rate=init.bitrate,
        errors=bool(init.op_mode & LIN_OPMODE_ERRORS),
        note=note,
        kin=_KIN,
    )


def line_status(status: canwire.LinLineStatus) -> LinLineStatus:
    """LINLINESTATUS of a line; the bit rate is LIN_BITRATE_UNDEF before InitLine, LIN_BITRATE_AUTO if unknown."""
    made = LinLineStatus(bitrate=LIN_BITRATE_UNDEF, bus_load=max(0, min(100, round(status.load))))
    made.status = (
        status.status | LIN_STATUS_TXPEND * status.transmitting | LIN_STATUS_ININIT * (not status.running)
    )
    if status.initialised and status.mode is not None:
        made.op_mode, made.bitrate = _op_mode(status.mode), status.bit_rate
    return made


def frame_to_send(message: LinMsg) -> LinFrame:
    """The frame of a data message, only its header with ido. Raises VciInvalidArgument and BadFrame."""
    if not message.msg_info.ido:
        return frame_to_respond(message)
    return LinFrame(
        _identifier(message), enhanced=bool(message.msg_info.ecs), header_only=True, length=_length(message)
    )


def frame_to_respond(message: LinMsg) -> LinFrame:
    """The response of a data message; ido is ignored. Raises VciInvalidArgument and BadFrame."""
    data = bytes(message.ab_data[: _length(message)])
    return LinFrame(_identifier(message), data, enhanced=bool(message.msg_info.ecs))


def _identifier(message: LinMsg) -> int:
    """The identifier in pid, which may include the parity bits, as in a received message."""
    pid = message.msg_info.pid
    identifier = pid & LIN_PIDMASK_ID
    if pid not in (identifier, LinFrame(identifier).pid):
        what = "0 to 0x3F, without or with the correct parity bits"
        raise VciError.of(VCI_E_INVALIDARG, f"LINMSGINFO's pid {pid:#04x}: an identifier is {what}")
    return identifier


def _length(message: LinMsg) -> int:
    length = message.msg_info.dlen
    if length > _LONGEST:
        raise VciError.of(VCI_E_INVALIDARG, f"LINMSGINFO's dlen {length}: a LIN message has at most 8 bytes")
    return length


def _op_mode(mode: LinMode) -> int:
    """The bOpMode that InitLine got; for a line of another dialect, the bOpMode that means the same."""
    if mode.note.startswith(_NOTE):
        return LinInitLine.from_bytes(mode.note.removeprefix(_NOTE)).op_mode
    return LIN_OPMODE_MASTER * mode.master | LIN_OPMODE_ERRORS * mode.errors
