"""Names and signals of frames by a network description, as far as there is one."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any, NamedTuple

from canwire import BadDescription, ExtraMissing, Frame


class Signal(NamedTuple):
    """A signal's value for people."""

    name: str
    value: str
    unit: str
    comment: str


class Database:
    """`path` is a DBC, KCD, SYM or ARXML file, "" for none; raises BadDescription, ExtraMissing when made."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.name = os.path.basename(path)
        self._database: Any = _loaded(path) if path else None

    @cached_property
    def names(self) -> dict[str, str]:
        """Message names by "1A2" or, with eight digits, "000001A2" for a 29-bit identifier."""
        if self._database is None:
            return {}
        return {
            f"{message.frame_id:08X}"
            if message.is_extended_frame
            else f"{message.frame_id:03X}": message.name
            for message in self._database.messages
        }

    def signals(self, frame: Frame) -> list[Signal]:
        """Decoded; none for a frame that the file does not know, or whose data do not fit it."""
        message = self._message(frame)
        if message is None or frame.remote:
            return []
        try:
            values = message.decode(frame.data, decode_choices=True, allow_truncated=True, scaling=True)
        except (ValueError, KeyError):  # no signal could be read, or no such multiplexer
            return []
        return [
            Signal(signal.name, _shown(values[signal.name]), signal.unit or "", signal.comment or "")
            for signal in message.signals
            if signal.name in values
        ]

    def messages(self) -> list[str]:
        """The names of all messages, in their order."""
        return sorted(self.names.values())

    def _message(self, frame: Frame) -> Any:
        if self._database is None:
            return None
        name = self.names.get(f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}")
        return None if name is None else self._database.get_message_by_name(name)


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _loaded(path: str) -> Any:
    try:
        import cantools
    except ModuleNotFoundError:
        raise ExtraMissing("cantools", "databases") from None
    try:
        return cantools.database.load_file(path)
    except (OSError, ValueError, cantools.Error) as error:
        raise BadDescription(f"--db {path}: {error}") from None
