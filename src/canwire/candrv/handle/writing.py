"""Converts the messages that a handle sends, as text or structures, into frames.

Source: CANDRV manual, 7.8, 7.9, 8.3, 8.5, 8.19.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.candrv.constants import INFINITE, FrameFormat, Win32Error
from canwire.candrv.errors import CandrvError, as_candrv
from canwire.candrv.filters import identifier_of
from canwire.candrv.handle.receiving import DLC_SHIFT, EXTENDED, REMOTE, Key
from canwire.candrv.text import MalformedMessage, Message, MessageParser

if TYPE_CHECKING:
    from canwire.candrv.device.device import Device
    from canwire.candrv.handle.channel import Channel
    from canwire.candrv.structures import COMMTIMEOUTS

_LONGEST_DLC = 15


class PartialWrite(CandrvError):
    """A write of text that failed; `written` is the number of characters used before the failure."""

    def __init__(self, code: int, what: str = "", written: int = 0) -> None:
        super().__init__(code, what)
        self.written = written


class _Parsers(threading.local):
    """One parser for each thread: a message in several writes is not mixed with those of other threads."""

    def __init__(self) -> None:
        self.parser = MessageParser()


class Writer:
    """Sends a handle's messages on its channel, and waits according to its `timeouts`."""

    def __init__(self, device: Device, channel: Channel, timeouts: COMMTIMEOUTS) -> None:
        self.timeouts = timeouts
        self._device = device
        self._channel = channel
        self._parsers = _Parsers()

    def write(self, text: bytes) -> int:
        """Send the messages in a text; returns how many characters were used. Raises PartialWrite."""
        parser, used = self._parsers.parser, 0
        try:
            while True:
                message, end = parser.next(text, used)
                if message is None:
                    return len(text)
                self.send(message, FrameFormat.DEFAULT)
                used = end
        except MalformedMessage as error:
            raise PartialWrite(Win32Error.ERROR_INVALID_PARAMETER, str(error), error.consumed) from error
        except CanwireError as error:
            code = as_candrv(error)
            raise PartialWrite(code.code, code.what, used) from error

    def send(self, message: Message, fmt: int) -> None:
        channel, virtualize = self._channel, self._device.virtualize
        with channel.lock:
            channel.look()  # another program may have changed the device's configuration
            key = self._key(message, fmt)
        channel.send(key, self._write_timeout(message.dlc), virtualize=virtualize)

    def _key(self, message: Message, fmt: int) -> Key:
        """The frame for a message; raises CandrvError or BadFrame for an invalid message."""
        identifier, rtr, dlc, data = message
        if fmt not in (0, 1, 2) or rtr not in (0, 1) or not 0 <= dlc <= _LONGEST_DLC:
            raise CandrvError(
                Win32Error.ERROR_INVALID_PARAMETER,
                f"fmt {fmt}, rtr {rtr}, dlc {dlc}: not in 0..2, 0..1 and 0..15",
            )
        if not rtr and len(data) < min(dlc, 8):
            raise CandrvError(
                Win32Error.ERROR_INVALID_PARAMETER, f"{len(data)} data bytes for a DLC of {dlc}"
            )
        extended = self._channel.receiver.state.extends(fmt)
        right = identifier_of(identifier, extended, self._device.settings.align)
        info = dlc << DLC_SHIFT | (REMOTE if rtr else 0) | (EXTENDED if extended else 0)
        return Key(right, info, (b"" if rtr else data[: min(dlc, 8)]).ljust(8, b"\0"))

    def _write_timeout(self, dlc: int) -> float | None:
        """The write timeout in seconds, multiplier * DLC + constant; None: without limit."""
        timeouts = self.timeouts
        multiplier, constant = timeouts.WriteTotalTimeoutMultiplier, timeouts.WriteTotalTimeoutConstant
        if constant == INFINITE or (multiplier == INFINITE and dlc):
            return None
        return seconds(min(multiplier * dlc + constant, INFINITE))


def seconds(milliseconds: int) -> float | None:
    """A timeout in seconds; None for INFINITE."""
    return None if milliseconds == INFINITE else milliseconds / 1000


def ascii_of(text: str | bytes | bytearray | memoryview) -> bytes:
    """The text as ASCII; other characters become question marks, which are no hex digits."""
    if isinstance(text, str):
        return text.encode("ascii", "replace")
    return bytes(text)
