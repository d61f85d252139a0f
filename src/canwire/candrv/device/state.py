"""The state that all handles on a device share: it is stored in the mode of its line, and in the note of that mode.

Source: CANDRV manual, 7.9 (table 10), 8.13 to 8.18, 8.21, 8.23.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue, NotInitialised
from canwire.candrv.constants import CanMode, FrameFormat

if TYPE_CHECKING:
    from canwire import LineStatus
    from canwire.candrv.registry.settings import Settings

_NOTE = struct.Struct("<4sBB")  # CAN mode, default format
_MAGIC = b"CIDn"
KIN = "CANDRV"  # CANDRV programs may configure a line that another CANDRV program runs, as in the manual


class DeviceState(NamedTuple):
    """The state that all handles on a device share; `rate` is in bit/s."""

    rate: int
    mode: int = CanMode.CAN_2_0_A
    format: int = FrameFormat.DEFAULT
    listen: bool = False
    loop_back: bool = False

    @property
    def extended(self) -> bool:
        """Whether messages with FrameFormat.DEFAULT are extended frames (table 10)."""
        return self.extends(FrameFormat.DEFAULT)

    def extends(self, wanted: int) -> bool:
        """Whether a message in this format is an extended frame."""
        chosen = wanted or self.format
        return self.mode == CanMode.CAN_2_0_B and chosen != FrameFormat.STD

    def to_note(self) -> bytes:
        """The part of the state that the line's mode does not contain, as bytes."""
        return _NOTE.pack(_MAGIC, self.mode, self.format)


def state_of(status: LineStatus, settings: Settings) -> DeviceState:
    """The state of a line; before it is configured, the state from `settings`.

    Without this dialect's note, the CAN mode is CAN2.0B if the line receives extended frames, else CAN2.0A.
    """
    mode = status.mode
    if mode is None:
        return DeviceState(settings.baudrate, settings.can_mode_2b, settings.format)
    if mode.timing is None:
        raise NotInitialised("the line is searching for its bit rate")
    can_mode, frame_format = int(CanMode.CAN_2_0_B if mode.extended else CanMode.CAN_2_0_A), 0
    can_mode, frame_format = _noted(mode.note) or (can_mode, frame_format)
    return DeviceState(mode.timing.bit_rate, can_mode, frame_format, mode.listen_only, mode.loop_back)


def _noted(note: bytes) -> tuple[int, int] | None:
    """CAN mode and default format from a note; None if it is not of this dialect, or invalid."""
    if len(note) != _NOTE.size or not note.startswith(_MAGIC):
        return None
    _, can_mode, frame_format = _NOTE.unpack(note)
    known = can_mode in set(CanMode) and frame_format in set(FrameFormat)
    return (can_mode, frame_format) if known else None


def can_time(at_ns: int) -> int:
    """The low word of CAN_TIME; it wraps after 49.7 days, and the high word stays 0."""
    return at_ns // 1_000_000 & 0xFFFF_FFFF


def checked(name: str, value: int, kind: type[CanMode] | type[FrameFormat]) -> int:
    """The value, if it is in the enumeration; raises BadValue otherwise."""
    try:
        return int(kind(value))
    except ValueError:
        known = ", ".join(f"{int(one)} {one.name}" for one in kind)
        raise BadValue(f"{name} {value}: it must be one of {known}") from None
