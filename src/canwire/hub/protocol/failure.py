"""Converts an error of errors.py to a message for the client, and back."""

from __future__ import annotations

from typing import Any

import msgspec

from canwire import errors
from canwire.errors import CanwireError
from canwire.hub.protocol.messages import Failed


def failed(error: CanwireError) -> Failed:
    """Return the message for an error: the name of its class in errors.py, and its text."""
    return Failed(type(error).__name__, str(error))


def raised(failure: Failed) -> CanwireError:
    """Return the error that a Failed reply reports; an unknown one becomes a CanwireError."""
    kind: Any = getattr(errors, failure.error, None)
    if not (isinstance(kind, type) and issubclass(kind, CanwireError)):
        kind = CanwireError
    error: CanwireError = kind.__new__(kind, failure.text)  # __init__ would change the text
    return error


def serial_in(payload: bytes) -> int:
    """Return the serial of a request that could not be decoded; 0 if its serial is unknown."""
    try:
        serial, _ = _ANY_REQUEST.decode(payload)
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return 0
    return max(0, serial)


_ANY_REQUEST = msgspec.msgpack.Decoder(tuple[int, msgspec.Raw])
