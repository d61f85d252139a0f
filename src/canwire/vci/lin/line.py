"""How a LIN line is set up, how it is, and what goes out on it: VCI's structures to canwire's and back.

can/line.py looks alike; its words are of other bits.
A line remembers the structure it was initialised with, so that every program reads the same back.
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
_KIN = "VCI"  # whose programs may set each other's running lines up anew, as the manual has it
_LONGEST = 8


def capabilities_of(capabilities: canwire.LinCapabilities) -> LinCapabilities:
    """LINCAPABILITIES."""
    return LinCapabilities(
        features=capabilities.features,
        clock_freq=capabilities.stamps.clock_hz,
        tsc_divisor=capabilities.stamps.divisor,
    )


def mode_of_init(init: LinInitLine) -> LinMode:
    """What ILinControl.InitLine asks for; raises VciInvalidArgument for an operating mode that is none."""
    note = _NOTE + init.to_bytes()
    if init.op_mode & ~_OPMODES:
        raise VciError.of(VCI_E_INVALIDARG, f"operating mode {init.op_mode:#04x}: LIN_OPMODE_ flags")
    return LinMode(
        master=bool(init.op_mode & LIN_OPMODE_MASTER),
        bit_rate=init.bitrate,
        errors=bool(init.op_mode & LIN_OPMODE_ERRORS),
        note=note,
        kin=_KIN,
    )


def line_status(status: canwire.LinLineStatus) -> LinLineStatus:
    """LINLINESTATUS of a line; its bit rate is LIN_BITRATE_UNDEF before InitLine, LIN_BITRATE_AUTO while unknown."""
    made = LinLineStatus(bitrate=LIN_BITRATE_UNDEF, bus_load=max(0, min(100, round(status.load))))
    made.status = (
        status.status | LIN_STATUS_TXPEND * status.transmitting | LIN_STATUS_ININIT * (not status.running)
    )
    if status.initialised and status.mode is not None:
        made.op_mode, made.bitrate = _op_mode(status.mode), status.bit_rate
    return made


def frame_to_send(message: LinMsg) -> LinFrame:
    """A data message as a frame, or with ido as a header alone. Raises VciInvalidArgument and BadFrame."""
    if not message.msg_info.ido:
        return frame_to_respond(message)
    return LinFrame(
        _identifier(message), enhanced=bool(message.msg_info.ecs), header_only=True, length=_length(message)
    )


def frame_to_respond(message: LinMsg) -> LinFrame:
    """A data message as a response; ido means nothing there. Raises VciInvalidArgument and BadFrame."""
    data = bytes(message.ab_data[: _length(message)])
    return LinFrame(_identifier(message), data, enhanced=bool(message.msg_info.ecs))


def _identifier(message: LinMsg) -> int:
    """The identifier in pid, which may have its parity bits with it, as that of a received message has."""
    pid = message.msg_info.pid
    identifier = pid & LIN_PIDMASK_ID
    if pid not in (identifier, LinFrame(identifier).pid):
        what = "0 to 0x3F, or with right parity bits"
        raise VciError.of(VCI_E_INVALIDARG, f"LINMSGINFO's pid {pid:#04x}: an identifier is from {what}")
    return identifier


def _length(message: LinMsg) -> int:
    length = message.msg_info.dlen
    if length > _LONGEST:
        raise VciError.of(VCI_E_INVALIDARG, f"LINMSGINFO's dlen {length}: a LIN message has at most 8 bytes")
    return length


def _op_mode(mode: LinMode) -> int:
    """As InitLine got it, or as it would have to be for a line that was not initialised by VCI."""
    if mode.note.startswith(_NOTE):
        return LinInitLine.from_bytes(mode.note.removeprefix(_NOTE)).op_mode
    return LIN_OPMODE_MASTER * mode.master | LIN_OPMODE_ERRORS * mode.errors
