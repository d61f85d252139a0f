"""How much of a file a reader takes: what is more is refused, whatever the file says of itself."""

from __future__ import annotations

from dataclasses import dataclass, fields

from canwire.values.checks import whole


@dataclass(frozen=True)
class LogLimits:
    """What `open_log` takes of one log. What is beyond raises BadLog, which names the limit; a line is a fault instead.

    `line_bytes`: a line of text, and a value in a database; a longer line is read in pieces, which mean nothing.
    `block_bytes`: an object, block or unpacked container of a binary log.
    `channels`: names of channels, and interfaces of a capture.
    `memory_bytes`, `seconds`: what the process takes that reads MF4 with somebody else's library.
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
