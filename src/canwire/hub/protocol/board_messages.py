"""Requests about many lines together, about chips and registers of boards, and about notes between programs."""

from __future__ import annotations

from canwire.boards.can.modes import LineStatus
from canwire.hub.protocol.message import Message
from canwire.values.register import RegisterValue


class GetLineStatuses(Message):
    """-> LineStatuses: all CAN lines of these boards, 256 boards at most; a board that does not exist is left out."""

    boards: tuple[int, ...]


class GetRegisters(Message):
    """-> Registers: those of a line's chip, read without side effects; none for an ideal controller."""

    board: int
    line: int


class KeepSettings(Message):
    """-> Opened. A CAN or LIN line keeps its settings while this is open."""

    board: int
    line: int


class OpenShare(Message):
    """-> Opened. `share` says what others may do: 1 read, 2 write."""

    board: int
    line: int
    read: bool
    write: bool
    share: int


class ReadRegister(Message):
    """Control -> Number: the register's value, read with all side effects."""

    handle: int
    address: int
    reset_mode: bool


class WriteRegister(Message):
    """Control -> None"""

    handle: int
    address: int
    value: int
    reset_mode: bool


class Sleep(Message):
    """Control -> None: let the line's controller sleep, or wake it."""

    handle: int
    asleep: bool


class Annotate(Message):
    """Control -> None: replace the note in the line's mode; channels get CHANGED, the controller is not affected."""

    handle: int
    note: bytes


class HoldInterrupts(Message):
    """-> None: stop the line's driver from serving its chip, or let it continue."""

    board: int
    line: int
    held: bool


class PassOn(Message):
    """Channel -> None: a frame's 80 bytes, for the line's other AS_BUS channels, as if received from the bus."""

    handle: int
    record: bytes


class SetNote(Message):
    """-> None. The note stays until it is replaced; with `leaves`, until its writer ends. An empty one removes it."""

    name: str
    value: bytes
    leaves: bool = False


class GetNote(Message):
    """-> Note, empty if it does not exist."""

    name: str


class ListNotes(Message):
    """-> Notes: those whose names begin with the prefix."""

    prefix: str


class Notes(Message):
    values: tuple[tuple[str, bytes], ...]


class LineStatuses(Message):
    """Each status with its board and line number."""

    values: tuple[tuple[int, int, LineStatus], ...]


class Registers(Message):
    values: tuple[RegisterValue, ...]


class Note(Message):
    value: bytes
