"""Limits for readers, which protect against damaged or malicious files."""

from __future__ import annotations

from dataclasses import dataclass, fields

from canwire.values.checks import whole


@dataclass(frozen=True)
class LogLimits:
    """Limits of `open_log` for one log. Beyond them it raises BadLog, which names the limit; a long line is a fault.

    `line_bytes`: a line of text, and a value in a database; a longer line is read in pieces, which are invalid.
    `block_bytes`: an object, block or unpacked container of a binary log.
    `channels`: names of channels, and interfaces of a capture.
    `memory_bytes`, `seconds`: memory and time of the process that reads MF4 with asammdf.
    """

    line_bytes: int = 1 << 16
    block_bytes: int = 1 << 26
    channels: int = 1 << 14
    memory_bytes: int = 1 << 33
    seconds: int = 3600

    def __post_init__(self) -> None:
        largest = {"channels": 1 << 15}  # a record has two bytes for it, and a batch's new names come on top
        for field in fields(self):
            whole(field.name, getattr(self, field.name), 1, largest.get(field.name, 1 << 40))


USUAL = LogLimits()
