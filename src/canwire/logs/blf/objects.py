"""Objects of a BLF file as frames and events."""

from __future__ import annotations

from canwire.errors import BadText
from canwire.logs.blf import layout as b
from canwire.logs.entry import Content
from canwire.values.dlc import FD_LENGTHS
from canwire.values.event import BusEvent, ErrorKind, EventKind
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

_LIN_2_ID, _LIN_2_DATA = 37, 112  # offsets in a LIN_MESSAGE_2
Made = tuple[int, Content, str | None]  # channel, content, direction


def content_of_object(kind: int, body: bytes, time_ns: int) -> Made | None:
    """Return the content of an object; None for kinds that are no traffic. Raises BadText, BadFrame, struct.error."""
    if kind in (b.CAN_MESSAGE, b.CAN_MESSAGE_2):
        return _can(body, time_ns)
    if kind == b.CAN_FD:
        return _fd(body, time_ns)
    if kind == b.CAN_FD_64:
        return _fd_64(body, time_ns)
    if kind in (b.CAN_ERROR, b.CAN_ERROR_EXT):
        channel = int.from_bytes(body[:2], "little")
        return channel, BusEvent(EventKind.ERROR, time_ns, error=ErrorKind.OTHER), None
    if kind == b.LIN_MESSAGE:
        channel, id, length, data, *_, sent = b.LIN.unpack_from(body)
        return _lin(channel, id, data[:length], bool(sent), time_ns)
    if kind == b.LIN_MESSAGE_2:
        id, length, model = body[_LIN_2_ID : _LIN_2_ID + 3]
        channel = int.from_bytes(body[12:14], "little")
        sent = bool(body[_LIN_2_DATA + 10])
        data = body[_LIN_2_DATA : _LIN_2_DATA + length]
        return _lin(channel, id, data, sent, time_ns, bool(model))
    return None


def text_of_object(body: bytes) -> str:
    """Return the text of an APP_TEXT object."""
    length = b.TEXT.unpack_from(body)[2]
    return body[b.TEXT.size : b.TEXT.size + length].rstrip(b"\0").decode("utf-8", "replace")


def _can(body: bytes, time_ns: int) -> Made:
    channel, flags, dlc, word, data = b.CAN.unpack_from(body)
    remote = bool(flags & b.REMOTE)
    frame = Frame(
        word & 0x1FFF_FFFF,
        b"" if remote else data[: min(dlc, 8)],
        extended=bool(word & b.EXTENDED),
        remote=remote,
        dlc=dlc,
        timestamp_ns=time_ns,
    )
    return channel, frame, _direction(flags & b.SENT)


def _fd(body: bytes, time_ns: int) -> Made:
    channel, flags, dlc, word, _, _, kinds, valid, data = b.FD.unpack_from(body.ljust(b.FD.size, b"\0"))
    made = _made(
        word, data[:valid], dlc, flags & b.REMOTE, kinds & b.EDL, kinds & b.BRS, kinds & b.ESI, time_ns
    )
    return channel, made, _direction(flags & b.SENT)


def _fd_64(body: bytes, time_ns: int) -> Made:
    channel, dlc, valid, _, word, _, flags, *_, sent, _, _ = b.FD_64.unpack_from(body)
    data = body[b.FD_64.size : b.FD_64.size + valid]
    made = _made(
        word, data, dlc, flags & b.REMOTE_64, flags & b.EDL_64, flags & b.BRS_64, flags & b.ESI_64, time_ns
    )
    return channel, made, _direction(sent)


def _made(word: int, data: bytes, dlc: int, remote: int, fd: int, brs: int, esi: int, time_ns: int) -> Frame:
    if dlc > 15:
        raise BadText(f"data length code {dlc}: up to 15")
    length = 0 if remote else FD_LENGTHS[dlc] if fd else min(dlc, 8)
    return Frame(
        word & 0x1FFF_FFFF,
        data[:length].ljust(length, b"\0"),
        extended=bool(word & b.EXTENDED),
        remote=bool(remote),
        fd=bool(fd),
        bit_rate_switch=bool(fd and brs),
        error_state_indicator=bool(fd and esi),
        dlc=dlc,
        timestamp_ns=time_ns,
    )


def _lin(channel: int, id: int, data: bytes, sent: bool, time_ns: int, enhanced: bool | None = None) -> Made:
    frame = LinFrame(id & 0x3F, data, enhanced=enhanced, timestamp_ns=time_ns, sent=sent)
    return channel, frame, _direction(sent)


def _direction(sent: int) -> str:
    return "T" if sent else "R"
