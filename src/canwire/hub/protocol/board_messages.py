"""Requests about many lines together, boards' chips, what goes past them, and notes of programs for each other."""

from __future__ import annotations

from canwire.boards.can.modes import LineStatus
from canwire.hub.protocol.message import Message
from canwire.values.register import RegisterValue


class GetLineStatuses(Message):
    """-> LineStatuses: all CAN lines of these boards, 256 at most; a board that is not there is left out."""

    boards: tuple[int, ...]


class GetRegisters(Message):
    """-> Registers: those of a line's chip, read without side effects; none where the chip is an ideal one."""

    board: int
    line: int


class KeepSettings(Message):
    """-> Opened. A CAN or LIN line keeps its settings for as long as this is open."""

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
    """Control -> Number, with what reading the register does"""

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
    """Control -> None: another note in the line's mode; the controller is left alone, channels hear CHANGED."""

    handle: int
    note: bytes


class HoldInterrupts(Message):
    """-> None: keep the line's driver from serving its chip, or let it again."""

    board: int
    line: int
    held: bool


class PassOn(Message):
    """Channel -> None: a frame's 80 bytes, as if it had come by the bus, for the line's other AS_BUS channels."""

    handle: int
    record: bytes


class SetNote(Message):
    """-> None. It lies there until another takes its place, or its writer `leaves`; an empty one is taken away."""

    name: str
    value: bytes
    leaves: bool = False


class GetNote(Message):
    """-> Note, empty where there is none."""

    name: str


class ListNotes(Message):
    """-> Notes: those whose names begin so."""

    prefix: str


class Notes(Message):
    values: tuple[tuple[str, bytes], ...]


class LineStatuses(Message):
    """Each with its board and its number there."""

    values: tuple[tuple[int, int, LineStatus], ...]


class Registers(Message):
    values: tuple[RegisterValue, ...]


class Note(Message):
    value: bytes
