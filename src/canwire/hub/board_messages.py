"""Requests about a board's chips, and notes that programs leave for each other."""

from __future__ import annotations

from canwire.hub.message import Message
from canwire.values.register import RegisterValue


class GetRegisters(Message):
    """-> Registers: those of a line's chip, read without side effects; none where the chip is an ideal one."""

    board: int
    line: int


class SetNote(Message):
    """-> None. A note lies at the hub until another takes its place; an empty one is taken away."""

    name: str
    value: bytes


class GetNote(Message):
    """-> Note, empty where there is none."""

    name: str


class Registers(Message):
    values: tuple[RegisterValue, ...]


class Note(Message):
    value: bytes
