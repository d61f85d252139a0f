"""The interface of a database for ports and simulations; `database.py` implements it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from canwire.databases.decoded import DecodedMessage
from canwire.databases.description import MessageDescription, Number, Value
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame


class Codec(Protocol):
    """Converts messages to frames and back; see the methods of `Database`."""

    path: str
    messages: dict[str, MessageDescription]

    def message(self, name: str) -> MessageDescription:
        """The message of this name; raises BadValue."""

    def sent_by(self, node: str) -> list[MessageDescription]:
        """The messages of a node; raises BadValue."""

    def signals_in(self, name: str, signals: Mapping[str, Value]) -> list[str]:
        """The signals in the frame; raises BadValue."""

    def complete(
        self, name: str, signals: Mapping[str, Value], *, fill: Number | None = None
    ) -> dict[str, Value]:
        """The values, completed with start values; raises BadSignals, BadValue."""

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
        """The frame with the counter and checksum that the file defines."""

    def protections_of(self, frame: Frame) -> list[tuple[str, str, tuple[int, int] | None]]:
        """The faults of the checksums in the frame, and the counters."""
