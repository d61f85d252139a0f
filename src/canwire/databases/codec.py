"""What ports and simulations need of a database; `database.py` is one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from canwire.databases.decoded import DecodedMessage
from canwire.databases.description import MessageDescription, Number, Value
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame


class Codec(Protocol):
    """Messages to frames and back; see `Database` for each."""

    path: str
    messages: dict[str, MessageDescription]

    def message(self, name: str) -> MessageDescription:
        """By name; raises BadValue."""

    def sent_by(self, node: str) -> list[MessageDescription]:
        """A node's; raises BadValue."""

    def signals_in(self, name: str, signals: Mapping[str, Value]) -> list[str]:
        """Which are in the frame; raises BadValue."""

    def complete(
        self, name: str, signals: Mapping[str, Value], *, fill: Number | None = None
    ) -> dict[str, Value]:
        """With start values; raises BadSignals, BadValue."""

    def encode(
        self,
        name: str,
        signals: Mapping[str, Value],
        *,
        fill: Number | None = None,
        source: int | None = None,
    ) -> Frame | LinFrame:
        """The frame; raises BadSignals, BadValue."""

    def decode(self, frame: Frame | LinFrame) -> DecodedMessage | None:
        """The message; None for an unknown frame."""

    def protect(self, frame: Frame, count: int) -> Frame:
        """With the counter and checksum that the file has for it."""

    def protections_of(self, frame: Frame) -> list[tuple[str, str, tuple[int, int] | None]]:
        """What is wrong with checksums in it, and their counters."""
