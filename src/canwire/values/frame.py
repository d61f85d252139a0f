"""CAN frames: classic, remote or FD. They are always valid, frozen, and quick to make.

Source: ISO 11898-1:2015 8.4.2; record layout in values/record.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Never

from canwire import _mem
from canwire.errors import BadFrame
from canwire.values.arguments import SignatureOf, frame, unknown_argument
from canwire.values.dlc import CLASSIC_LENGTHS, FD_LENGTHS
from canwire.values.mistakes.names import WrongName

if TYPE_CHECKING:  # and for the compiler
    import cython
else:
    from canwire import _cython as cython

# info bits of values/record.py that a frame is made of, as C constants
_EXTENDED = 1 << 23
_REMOTE = 1 << 22
_SELF_RECEPTION = 1 << 21
_FD = 1 << 10
_BIT_RATE_SWITCH = 1 << 11
_ERROR_STATE = 1 << 12
_DLC_SHIFT = 16
_IDENTITY = _EXTENDED | _REMOTE | _FD | _BIT_RATE_SWITCH | _ERROR_STATE | 0xF << _DLC_SHIFT
_DLC_OF_LENGTH = tuple(
    next((code for code, size in enumerate(FD_LENGTHS) if size == length), -1) for length in range(65)
)

_NOT_GIVEN: Any = object()
_NO_TIME = 0  # the default needs no check that it is a whole number
_LAST_KEPT = 255
_KEPT: list[Frame | None] = [None] * (_LAST_KEPT + 1)  # the frames read last: frozen, so they can be shared


@cython.freelist(128)
@cython.cclass
class Frame:
    """One data or remote frame, classic or FD.

    >>> Frame(0x123, b"\\x11\\x22")
    Frame(0x123, bytes.fromhex("1122"))
    >>> Frame(0x18DAF110, bytes(12), extended=True, fd=True, bit_rate_switch=True).dlc
    9

    `id` is 11 bits (0..0x7FF), or 29 bits with `extended`. `data` holds 0..8 bytes, with `fd`
    also 12, 16, 20, 24, 32, 48 or 64. `dlc` is worked out from the data; give it for a remote
    frame's request (0..15), or to send the codes 9..15 that a classic frame may carry beside
    its 8 bytes. `timestamp_ns` is the end of the frame on the bus and takes no part in
    comparisons, nor does `self_received`. Raises BadFrame, naming the value at fault.
    """

    __slots__ = ("_data", "_id", "_info", "_timestamp_ns")
    __signature__ = SignatureOf(frame)
    # other libraries' names
    arbitration_id = WrongName("Frame", "arbitration_id")
    is_extended_id = WrongName("Frame", "is_extended_id")
    is_remote_frame = WrongName("Frame", "is_remote_frame")
    is_fd = WrongName("Frame", "is_fd")
    bitrate_switch = WrongName("Frame", "bitrate_switch")
    timestamp = WrongName("Frame", "timestamp")
    length = WrongName("Frame", "length")
    payload = WrongName("Frame", "payload")

    def __init__(
        self,
        id: int = _NOT_GIVEN,
        data: bytes | bytearray | memoryview = b"",
        *,
        extended: bool = False,
        remote: bool = False,
        fd: bool = False,
        bit_rate_switch: bool = False,
        error_state_indicator: bool = False,
        dlc: int | None = None,
        timestamp_ns: int = _NO_TIME,
        self_received: bool = False,
        **unknown: Never,
    ) -> None:
        if unknown:
            raise unknown_argument("Frame()", unknown, frame)
        number = _mem.whole(id)
        if number < 0 or number > (0x1FFFFFFF if extended else 0x7FF):
            raise BadFrame(_bad_id(id, extended))
        if type(data) is not bytes:
            data = _as_bytes(data)
        if (bit_rate_switch or error_state_indicator) and not fd:
            raise BadFrame("bit_rate_switch and error_state_indicator exist only in FD frames; add fd=True")
        if timestamp_ns is not _NO_TIME and not _is_time(timestamp_ns):
            raise BadFrame(
                f"timestamp_ns {timestamp_ns!r}: a whole number of nanoseconds from 0 to 2**64 - 1"
            )
        self._info = _checked_dlc(data, remote, fd, dlc) << _DLC_SHIFT | _flags(
            extended, remote, fd, bit_rate_switch, error_state_indicator, self_received
        )
        self._id = number
        self._data = data
        self._timestamp_ns = timestamp_ns

    @property
    def id(self) -> int:
        return self._id

    @property
    def data(self) -> bytes:
        return self._data

    @property
    def dlc(self) -> int:
        """The data length code on the wire, 0..15."""
        return self._info >> _DLC_SHIFT & 15

    @property
    def extended(self) -> bool:
        """True for a 29-bit identifier."""
        return self._info & _EXTENDED != 0

    @property
    def remote(self) -> bool:
        return self._info & _REMOTE != 0

    @property
    def fd(self) -> bool:
        return self._info & _FD != 0

    @property
    def bit_rate_switch(self) -> bool:
        """True when the data phase runs at the data bit rate (BRS)."""
        return self._info & _BIT_RATE_SWITCH != 0

    @property
    def error_state_indicator(self) -> bool:
        """True when the sender was error passive (ESI)."""
        return self._info & _ERROR_STATE != 0

    @property
    def self_received(self) -> bool:
        """True on a sender's own frame, returned to it by self-reception."""
        return self._info & _SELF_RECEPTION != 0

    @property
    def timestamp_ns(self) -> int:
        """End of the frame on the bus, in nanoseconds of the lab's time."""
        return self._timestamp_ns

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Frame):
            return NotImplemented
        return _same(self, other)

    def __hash__(self) -> int:
        return hash((self._id, self._info & _IDENTITY, self._data))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (self._id, self._info, self._data, self._timestamp_ns)

    def __repr__(self) -> str:
        shown = [f"0x{self._id:08X}" if self.extended else f"0x{self._id:03X}"]
        if self._data:
            shown.append(f'bytes.fromhex("{self._data.hex()}")')
        for name in ("extended", "remote", "fd", "bit_rate_switch", "error_state_indicator", "self_received"):
            if getattr(self, name):
                shown.append(f"{name}=True")
        if _checked_dlc(self._data, self.remote, self.fd, None) != self.dlc:
            shown.append(f"dlc={self.dlc}")
        if self._timestamp_ns:
            shown.append(f"timestamp_ns={self._timestamp_ns}")
        return f"Frame({', '.join(shown)})"


def _checked_dlc(data: bytes, remote: bool, fd: bool, dlc: int | None) -> int:
    """The data length code for the data, or the given one if it fits the data; raises BadFrame."""
    length = len(data)
    if remote and (fd or length):
        raise BadFrame(
            "a remote frame is never FD: CAN FD has none"
            if fd
            else f"a remote frame carries no data ({length} bytes given); give the length it asks for as dlc"
        )
    if dlc is None:
        if length <= 8:
            return length
        dlc = _DLC_OF_LENGTH[length] if fd and length <= 64 else -1
        if dlc < 0:
            raise BadFrame(_bad_length(length, fd))
        return dlc
    if not isinstance(dlc, int) or dlc < 0 or dlc > 15:
        raise BadFrame(f"dlc {dlc!r}: a whole number from 0 to 15")
    expected = (FD_LENGTHS if fd else CLASSIC_LENGTHS)[dlc]
    if not remote and expected != length:
        raise BadFrame(f"dlc {dlc} means {expected} bytes, but data has {length}")
    return dlc


def _flags(extended: bool, remote: bool, fd: bool, switch: bool, error_state: bool, own: bool) -> int:
    """Their bits in a record's info word."""
    info = 0
    if extended:
        info |= _EXTENDED
    if remote:
        info |= _REMOTE
    if fd:
        info |= _FD
    if switch:
        info |= _BIT_RATE_SWITCH
    if error_state:
        info |= _ERROR_STATE
    if own:
        info |= _SELF_RECEPTION
    return info


def _is_time(timestamp_ns: object) -> bool:
    return isinstance(timestamp_ns, int) and timestamp_ns >= 0 and timestamp_ns >> 64 == 0


def _bad_id(id: object, extended: bool) -> str:
    if id is _NOT_GIVEN:
        return "a frame needs an identifier: Frame(0x123, ...)"
    if not isinstance(id, int):
        return f"identifier {id!r} is no whole number"
    if id < 0 or id > 0x1FFFFFFF:
        return f"identifier {id:#x}: an identifier has at most 29 bits (0..0x1FFFFFFF)"
    return f"identifier {id:#x} needs more than 11 bits (0..0x7FF); add extended=True for a 29-bit one"


def _bad_length(length: int, fd: bool) -> str:
    if fd:
        return f"{length} bytes: an FD frame carries 0..8, 12, 16, 20, 24, 32, 48 or 64 bytes"
    return f"{length} bytes: a classic frame carries at most 8; add fd=True for up to 64"


def _as_bytes(data: object) -> bytes:
    if isinstance(data, (bytearray, memoryview, bytes, list, tuple)):
        try:
            return bytes(data)
        except (ValueError, TypeError) as error:
            raise BadFrame(f"data {data!r}: {error}") from None
    raise BadFrame(f"data {data!r} is not bytes")


def _same(one: Frame, other: Frame) -> bool:
    return one._id == other._id and (one._info ^ other._info) & _IDENTITY == 0 and one._data == other._data


def _restore(id: int, info: int, data: bytes, timestamp_ns: int) -> Frame:
    frame = Frame.__new__(Frame)
    frame._id = id
    frame._info = info
    frame._data = data
    frame._timestamp_ns = timestamp_ns
    return frame


def frame_at(words: _mem.Words, at: int) -> Frame:
    """The frame in the record that starts at word `at`; its data length comes from its DLC alone.

    Receivers of a frame whose rings hold it at the same place get one object, if they read it soon after each other.
    """
    place = at >> 3 & _LAST_KEPT  # a record has ten words: neighbours never meet
    kept = _KEPT[place]
    if kept is not None and _is_at(kept, words, at):
        return kept
    frame = _made(words, at)
    _KEPT[place] = frame
    return frame


def _is_at(frame: Frame, words: _mem.Words, at: int) -> bool:
    head = words[at + 1]
    if frame._timestamp_ns != words[at] or frame._info != head >> 32 or frame._id != head & 0x1FFFFFFF:
        return False
    return _mem.same_data(words, at + 2, frame._data)


def _made(words: _mem.Words, at: int) -> Frame:
    frame = Frame.__new__(Frame)
    head = words[at + 1]
    info = head >> 32
    frame._timestamp_ns = words[at]
    frame._id = head & 0x1FFFFFFF
    frame._info = info
    dlc = info >> _DLC_SHIFT & 15
    if info & _REMOTE:
        length = 0
    elif dlc <= 8:
        length = dlc
    elif info & _FD:
        length = FD_LENGTHS[dlc]
    else:
        length = 8
    frame._data = _mem.data_of(words, at + 2, length)
    return frame


def frame_of_record(record: bytes | bytearray | memoryview) -> Frame:
    """The frame in a record of 80 bytes; raises BadFrame if it contains no valid frame."""
    block = bytearray(record)
    if len(block) != 80:
        raise BadFrame(f"a record has 80 bytes, not {len(block)}")
    frame = frame_at(_mem.words_of(block), 0)
    _check_format(frame, int.from_bytes(block[8:12], "little"))
    return frame


def _check_format(frame: Frame, identifier: int) -> None:
    """Check a record like the constructor of Frame checks its arguments."""
    if identifier > (0x1FFFFFFF if frame.extended else 0x7FF):
        raise BadFrame(_bad_id(identifier, frame.extended))
    if frame.fd and frame.remote:
        raise BadFrame("a remote frame is never FD: CAN FD has none")
    if (frame.bit_rate_switch or frame.error_state_indicator) and not frame.fd:
        raise BadFrame("bit_rate_switch and error_state_indicator exist only in FD frames")


def record_to_send(frame: Frame, flags: int = 0, delay_ns: int = 0) -> bytes:
    """The frame as 80 bytes for a transmit queue: request bits in its info word, its delay as time word."""
    block = bytearray(80)
    store_frame(frame, _mem.words_of(block), 0, flags, delay_ns)
    return bytes(block)


def record_of_frame(frame: Frame) -> bytes:
    """The frame as 80 bytes of record; its time word is the frame's timestamp."""
    block = bytearray(80)
    store_frame(frame, _mem.words_of(block), 0, 0, frame._timestamp_ns)
    return bytes(block)


def store_frame(frame: Frame, words: _mem.Words, at: int, flags: int, time_ns: int) -> None:
    """Write the frame as the record that starts at word `at`, with more info bits and its time word."""
    info = frame._info & _IDENTITY | flags
    words[at] = time_ns
    words[at + 1] = frame._id | info << 32
    _mem.store_data(words, at + 2, frame._data)
