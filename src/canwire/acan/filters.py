"""What a task block does with which frames: masks over the ACAN identifier, and channels.

Source: INduCAN104 manual, "CAN channels", "Message filters".
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from canwire import BadValue, Frame
from canwire.acan.constants import Action, Format
from canwire.acan.identifiers import LARGEST_EXTENDED, acan_word, plain_identifier


class Elsewhere(ABC):
    """A channel's variable that is not in this process."""

    @abstractmethod
    def read(self) -> bytes:
        """What is there now; fewer bytes than the channel moves where that memory is gone."""

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Put 1 to 8 bytes where it begins."""


Variable = bytes | bytearray | memoryview | Elsewhere

DWORD = 0xFFFF_FFFF
LONGEST = 8  # bytes of a channel's variable
_RECEIVE, _SEND = Action.CHANRCV, Action.CHANSND
_EVERY = Action.NOTIFY | Action.QUEUE | _RECEIVE | _SEND
_REQUEST = 6  # bytes of a message's head: dwID, bFormat, bLength


@dataclass(frozen=True, slots=True, eq=False)
class Filter:
    """ACANID: frames with (identifier AND `and_mask`) XOR `xor_value` = 0, and what to do with them.

    The identifier is ACAN's word: its first bit is bit 28, whatever the format. A channel (CHANRCV or CHANSND,
    never both) moves the first `length` bytes (1..8, else all) of `variable`, an application's own memory,
    without asking the application. Raises BadValue, naming the field here and in the manual.
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
        """Every frame."""
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
        """Frames with this identifier of 11 or 29 bits, of either format: the manual's masks do not tell them."""
        return cls(LARGEST_EXTENDED, acan_word(id, extended), actions, variable, length)

    @property
    def is_channel(self) -> bool:
        return bool(self.actions & (_RECEIVE | _SEND))

    def matches(self, word: int) -> bool:
        """Whether a frame with this ACAN identifier passes."""
        return (word & self.and_mask) ^ self.xor_value == 0

    def check(self) -> None:
        """Raise BadValue if the channel, as its variable is now, could not work."""
        if self.actions & _RECEIVE and self.actions & _SEND:
            raise BadValue("actions (bAction): CHANRCV and CHANSND exclude each other")
        if not self.is_channel:
            if self.variable is not None:
                raise BadValue("variable (lpAddress): only channels, CHANRCV or CHANSND, have one")
            return
        if not isinstance(self.variable, (bytes, bytearray, memoryview, Elsewhere)):
            raise BadValue(f"variable (lpAddress) {self.variable!r}: a channel needs bytes to move")
        view = memoryview(self._elsewhere() if isinstance(self.variable, Elsewhere) else self.variable)
        if self.actions & _RECEIVE and view.readonly:
            raise BadValue("variable (lpAddress): a channel that receives writes to it; give a bytearray")
        if not view.c_contiguous:
            raise BadValue("variable (lpAddress): its bytes have to lie together")
        length = view.nbytes if self.length is None else self.length
        if not isinstance(length, int) or not 1 <= length <= LONGEST:
            raise BadValue(f"length (bLength) {length!r}: a channel's variable has 1 to {LONGEST} bytes")
        if length > view.nbytes:
            raise BadValue(f"length (bLength) {length}: the variable (lpAddress) has {view.nbytes} bytes")

    def transfer(self, frame: Frame) -> Frame | None:
        """Do what the channel is for; CHANSND returns its answer, unless the request is too short to be one."""
        if self.actions & _RECEIVE:
            self._receive(frame.data)
            return None
        return self._answer(frame.data)

    def _elsewhere(self) -> bytearray:
        """Bytes of a variable elsewhere; to receive any will do."""
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
        """The channel's bytes: never more than the variable has by now, none if its memory was released."""
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
