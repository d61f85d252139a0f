"""Filters of a task block: masks over the ACAN identifier, and what to do with a frame that passes; channels.

Source: INduCAN104 manual, "CAN channels", "Message filters".
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from canwire import BadValue, Frame
from canwire.acan.constants import Action, Format
from canwire.acan.identifiers import LARGEST_EXTENDED, acan_word, plain_identifier


class Elsewhere(ABC):
    """A channel's variable outside this process."""

    @abstractmethod
    def read(self) -> bytes:
        """Return the present bytes of the variable; fewer than the channel has if that memory no longer exists."""

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Write 1 to 8 bytes at the variable's start."""


Variable = bytes | bytearray | memoryview | Elsewhere

DWORD = 0xFFFF_FFFF
LONGEST = 8  # bytes of a channel's variable
_RECEIVE, _SEND = Action.CHANRCV, Action.CHANSND
_EVERY = Action.NOTIFY | Action.QUEUE | _RECEIVE | _SEND
_REQUEST = 6  # bytes of a message's head: dwID, bFormat, bLength


@dataclass(frozen=True, slots=True, eq=False)
class Filter:
    """ACANID: a frame passes if (identifier AND `and_mask`) XOR `xor_value` = 0; `actions` says what happens then.

    The identifier is an ACAN word: its first bit is bit 28 in both formats. A channel (CHANRCV or CHANSND, not
    both) writes or sends the first `length` bytes (1..8; None: all) of `variable`, which is memory of the
    application, while the application does nothing. Raises BadValue with the field's name here and in the manual.
    """

    and_mask: int
    xor_value: int
    actions: Action = Action.NOTIFY | Action.QUEUE
    variable: Variable | None = None
    length: int | None = None

    def __post_init__(self) -> None:
        for name, value in (("and_mask (dwAnd)", self.and_mask), ("xor_value (dwXor)", self.xor_value)):
            if not isinstance(value, int) or not 0 <= value <= DWORD:
                raise BadValue(f"{name} {value!r}: a whole number from 0 to {DWORD:#x}")
        if not isinstance(self.actions, int) or self.actions & ~_EVERY:
            raise BadValue(f"actions (bAction) {self.actions!r}: unknown bits")
        object.__setattr__(self, "actions", Action(self.actions))
        self.check()

    @classmethod
    def any(cls, actions: Action = Action.NOTIFY | Action.QUEUE) -> Filter:
        """A filter that each frame passes."""
        return cls(0, 0, actions)

    @classmethod
    def one(
        cls,
        id: int,
        extended: bool = False,
        actions: Action = Action.NOTIFY | Action.QUEUE,
        variable: Variable | None = None,
        length: int | None = None,
    ) -> Filter:
        """A filter for one identifier of 11 or 29 bits. The manual's masks cannot tell the two formats apart."""
        return cls(LARGEST_EXTENDED, acan_word(id, extended), actions, variable, length)

    @property
    def is_channel(self) -> bool:
        return bool(self.actions & (_RECEIVE | _SEND))

    def matches(self, word: int) -> bool:
        """Whether a frame with this ACAN identifier passes."""
        return (word & self.and_mask) ^ self.xor_value == 0

    def check(self) -> None:
        """Raises BadValue if the channel cannot work with its variable as it is now."""
        if self.actions & _RECEIVE and self.actions & _SEND:
            raise BadValue("actions (bAction): CHANRCV and CHANSND exclude each other")
        if not self.is_channel:
            if self.variable is not None:
                raise BadValue("variable (lpAddress): only channels, CHANRCV or CHANSND, have one")
            return
        if not isinstance(self.variable, (bytes, bytearray, memoryview, Elsewhere)):
            raise BadValue(f"variable (lpAddress) {self.variable!r}: a channel needs a bytes-like object")
        view = memoryview(self._elsewhere() if isinstance(self.variable, Elsewhere) else self.variable)
        if self.actions & _RECEIVE and view.readonly:
            raise BadValue("variable (lpAddress): a channel that receives writes to it; give a bytearray")
        if not view.c_contiguous:
            raise BadValue("variable (lpAddress): its bytes must be contiguous")
        length = view.nbytes if self.length is None else self.length
        if not isinstance(length, int) or not 1 <= length <= LONGEST:
            raise BadValue(f"length (bLength) {length!r}: a channel's variable has 1 to {LONGEST} bytes")
        if length > view.nbytes:
            raise BadValue(f"length (bLength) {length}: the variable (lpAddress) has {view.nbytes} bytes")

    def transfer(self, frame: Frame) -> Frame | None:
        """CHANRCV writes the frame's data to the variable; CHANSND returns the answer, None for a short request."""
        if self.actions & _RECEIVE:
            self._receive(frame.data)
            return None
        return self._answer(frame.data)

    def _elsewhere(self) -> bytearray:
        """The bytes of a variable outside this process; a channel that receives needs only their number."""
        assert isinstance(self.variable, Elsewhere)
        return bytearray(self.variable.read() if self.actions & _SEND else LONGEST)

    def _receive(self, data: bytes) -> None:
        if isinstance(self.variable, Elsewhere):
            if data:
                self.variable.write(data[: LONGEST if self.length is None else self.length])
            return
        with self._view() as view:
            count = min(len(data), len(view))
            view[:count] = data[:count]

    def _answer(self, request: bytes) -> Frame | None:
        """The request begins like an ACANMB: identifier (4 bytes, little-endian), format, length."""
        if len(request) < _REQUEST:
            return None
        extended = bool(request[4] & Format.EXTENDED)
        id = plain_identifier(int.from_bytes(request[:4], "little"), extended)
        with self._view() as view:
            count = min(request[5], len(view))
            if request[4] & Format.RTR:
                return Frame(id, extended=extended, remote=True, dlc=count)
            return Frame(id, bytes(view[:count]), extended=extended)

    def _view(self) -> memoryview:
        """The channel's bytes: at most as many as the variable has now, none if its memory was released."""
        assert self.variable is not None
        if isinstance(self.variable, memoryview) and _released(self.variable):
            return memoryview(bytearray())
        held = self._elsewhere() if isinstance(self.variable, Elsewhere) else self.variable
        return memoryview(held).cast("B")[: LONGEST if self.length is None else self.length]


def _released(view: memoryview) -> bool:
    try:
        return view.nbytes < 0
    except ValueError:  # the only way to find out
        return True
