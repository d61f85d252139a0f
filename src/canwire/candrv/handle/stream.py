"""A handle as a text file: each event is a line, and written text is messages, as in the manual with fprintf."""

from __future__ import annotations

import io
from typing import Protocol

from canwire.candrv.constants import Win32Error
from canwire.candrv.errors import CandrvError

_THE_END = (Win32Error.ERROR_TIMEOUT, Win32Error.ERROR_OPERATION_ABORTED)


class TextHandle(Protocol):
    """What a stream needs from a handle."""

    readable: bool
    writable: bool

    @property
    def name(self) -> str:
        """The name of its device."""

    def read_text(self) -> bytes:
        """The next event as text."""

    def write(self, text: str) -> int:
        """Send messages as text; returns how many characters were used."""

    def close(self) -> None:
        """Close the handle."""


class EventStream(io.TextIOBase):
    """`readline` returns one event as ReadFile does, with the line break inside an event that has data.

    The stream ends when no event arrives within the read timeout, or when the handle is closed.
    """

    def __init__(self, handle: TextHandle) -> None:
        super().__init__()
        self.handle = handle

    @property
    def name(self) -> str:
        return self.handle.name

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return "ascii"

    def readable(self) -> bool:
        return self.handle.readable

    def writable(self) -> bool:
        return self.handle.writable

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        """The next event; `size` is ignored, since an event is not split."""
        if self.closed:
            raise ValueError("I/O operation on closed file")
        try:
            return self.handle.read_text().decode("ascii")
        except CandrvError as error:
            if error.code in _THE_END:
                return ""
            raise

    def read(self, size: int | None = -1, /) -> str:
        """All events until the stream ends; `size` is ignored."""
        return "".join(iter(self.readline, ""))

    def write(self, text: str, /) -> int:
        if self.closed:
            raise ValueError("I/O operation on closed file")
        return self.handle.write(text)

    def close(self) -> None:
        if not self.closed:
            super().close()
            self.handle.close()
