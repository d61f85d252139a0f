"""LIN frames, which are always valid, the protected identifier and the two checksums.

Source: LIN 2.2A 2.3 (frame structure); reference/lin-protocol.md sections 2 to 4.
"""

from __future__ import annotations

from typing import Any

from canwire.errors import BadFrame

LARGEST_ID = 0x3F
LARGEST_LENGTH = 8
MASTER_REQUEST = 0x3C
SLAVE_RESPONSE = 0x3D
GO_TO_SLEEP = b"\x00" + b"\xff" * 7


def _protected(id: int) -> int:
    low = id ^ id >> 1 ^ id >> 2 ^ id >> 4
    high = ~(id >> 1 ^ id >> 3 ^ id >> 4 ^ id >> 5)
    return id | (low & 1) << 6 | (high & 1) << 7


_PIDS = tuple(_protected(id) for id in range(LARGEST_ID + 1))


def protected_id(id: int) -> int:
    """The identifier with its two parity bits, as on the wire; raises BadFrame beyond 0..0x3F."""
    if not isinstance(id, int) or not 0 <= id <= LARGEST_ID:
        raise BadFrame(f"LIN identifier {_shown(id)}: a whole number from 0 to 0x3F")
    return _PIDS[id]


def parity_holds(pid: int) -> bool:
    """Whether both parity bits of a protected identifier (0..255) are right."""
    return _PIDS[pid & LARGEST_ID] == pid


def lin_checksum(data: bytes, pid: int = 0) -> int:
    """The checksum byte: classic over the data alone, enhanced with the protected identifier in front.

    255 minus the sum with end-around carry; a sum of 255 stays 255, so only no data at all gives 255.
    """
    total = sum(data) + pid
    return 255 - ((total - 1) % 255 + 1) if total else 255


class LinFrame:
    """One LIN frame: header and response, or with `header_only` the header by itself.

    `id` is 0..0x3F without parity, `data` 0..8 bytes. `enhanced` is the checksum model: True (LIN 2.x, over
    identifier and data) or False (classic, LIN 1.x); left out it is True, but for 0x3C to 0x3F. The
    diagnostic frames 0x3C and 0x3D are always classic. `length` is that of the data; a header alone may say
    for how many bytes it asks (1..8; 0: as many as come). `timestamp_ns` is the end of the frame on the bus.
    It takes no part in comparisons, nor do `sent` (the receiving line's own controller sent this response)
    and `overrun` (the queue was full after this frame). Raises BadFrame, naming the value at fault.
    """

    __slots__ = ("_data", "_enhanced", "_header_only", "_id", "_length", "_overrun", "_sent", "_timestamp_ns")

    def __init__(
        self,
        id: int,
        data: bytes | bytearray | memoryview = b"",
        *,
        enhanced: bool | None = None,
        header_only: bool = False,
        length: int | None = None,
        timestamp_ns: int = 0,
        sent: bool = False,
        overrun: bool = False,
    ) -> None:
        protected_id(id)
        if type(data) is not bytes:
            data = _as_bytes(data)
        if not isinstance(timestamp_ns, int) or timestamp_ns < 0 or timestamp_ns >> 64:
            raise BadFrame(
                f"timestamp_ns {timestamp_ns!r}: a whole number of nanoseconds from 0 to 2**64 - 1"
            )
        self._id = id
        self._data = data
        self._length = _checked_length(data, length, header_only)
        self._enhanced = _checked_model(id, enhanced)
        self._header_only = bool(header_only)
        self._timestamp_ns = timestamp_ns
        self._sent = bool(sent)
        self._overrun = bool(overrun)

    @property
    def id(self) -> int:
        return self._id

    @property
    def pid(self) -> int:
        """The identifier with its parity bits, as on the wire."""
        return _PIDS[self._id]

    @property
    def data(self) -> bytes:
        return self._data

    @property
    def length(self) -> int:
        """Number of data bytes; of a header alone, the requested number, 0 for any."""
        return self._length

    @property
    def enhanced(self) -> bool:
        """True when the checksum covers the protected identifier too (LIN 2.x)."""
        return self._enhanced

    @property
    def checksum(self) -> int:
        """The checksum byte of data like these, 0..255."""
        return lin_checksum(self._data, self.pid if self._enhanced else 0)

    @property
    def header_only(self) -> bool:
        """True for a header without its response (VCI: id only)."""
        return self._header_only

    @property
    def sent(self) -> bool:
        """True when the receiving line's own controller sent the response (VCI: sender of response)."""
        return self._sent

    @property
    def overrun(self) -> bool:
        """True when the receive queue was full once this frame was in it."""
        return self._overrun

    @property
    def timestamp_ns(self) -> int:
        """End of the frame on the bus, in nanoseconds of the lab's time."""
        return self._timestamp_ns

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LinFrame):
            return NotImplemented
        return self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def __repr__(self) -> str:
        shown = [f"0x{self._id:02X}"]
        if self._data:
            shown.append(f'bytes.fromhex("{self._data.hex()}")')
        if self._enhanced != _usual_model(self._id):
            shown.append(f"enhanced={self._enhanced}")
        for name in ("header_only", "sent", "overrun"):
            if getattr(self, name):
                shown.append(f"{name}=True")
        if self._header_only and self._length:
            shown.append(f"length={self._length}")
        if self._timestamp_ns:
            shown.append(f"timestamp_ns={self._timestamp_ns}")
        return f"LinFrame({', '.join(shown)})"

    def _identity(self) -> tuple[Any, ...]:
        return self._id, self._data, self._length, self._enhanced, self._header_only


def go_to_sleep_frame() -> LinFrame:
    """The master's command that puts every node to sleep."""
    return LinFrame(MASTER_REQUEST, GO_TO_SLEEP)


def is_go_to_sleep(id: int, data: bytes) -> bool:
    """A master request whose first byte is 0; slaves ignore the others."""
    return id == MASTER_REQUEST and data[:1] == b"\x00"


def checked_id(value: int) -> int:
    """The identifier in a byte that holds it with parity bits or without; raises BadFrame."""
    if value <= LARGEST_ID:
        return value
    if value > 0xFF or not parity_holds(value):
        raise BadFrame(
            f"LIN identifier {_shown(value)}: from 0 to 0x3F, or with right parity bits "
            f"({protected_id(value & LARGEST_ID):#x} for {value & LARGEST_ID:#x})"
        )
    return value & LARGEST_ID


def _usual_model(id: int) -> bool:
    return id < MASTER_REQUEST


def _checked_model(id: int, enhanced: bool | None) -> bool:
    if enhanced is None:
        return _usual_model(id)
    if enhanced and id in (MASTER_REQUEST, SLAVE_RESPONSE):
        raise BadFrame(f"LIN identifier {id:#x}: diagnostic frames always have the classic checksum")
    return bool(enhanced)


def _checked_length(data: bytes, length: int | None, header_only: bool) -> int:
    if header_only:
        if data:
            raise BadFrame(f"{len(data)} bytes: a header alone has no data; give the length it asks for")
        if length is not None and (not isinstance(length, int) or not 0 <= length <= LARGEST_LENGTH):
            raise BadFrame(f"length {length!r}: from 1 to 8, or 0 for as many as come")
        return length or 0
    if len(data) > LARGEST_LENGTH:
        raise BadFrame(f"{len(data)} bytes: a LIN frame carries at most 8")
    if length is not None and length != len(data):
        raise BadFrame(f"length {length!r}, but data has {len(data)} bytes")
    return len(data)


def _as_bytes(data: object) -> bytes:
    if isinstance(data, (bytearray, memoryview, bytes, list, tuple)):
        try:
            return bytes(data)
        except (ValueError, TypeError) as error:
            raise BadFrame(f"data {data!r}: {error}") from None
    raise BadFrame(f"data {data!r} is not bytes")


def _shown(value: object) -> str:
    return f"{value:#x}" if isinstance(value, int) else repr(value)
