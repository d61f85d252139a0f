"""AUTOSAR features of messages, with cantools: E2E protection by profile 2 or 5, and containers.

Profile 2 has a checksum in byte 0 and a counter from 0 to 15 in the low half of byte 1; profile 5 a checksum in the
bytes 0 and 1 (low one first) and a counter from 0 to 255 in byte 2.
Source: AUTOSAR E2E Protocol Specification (PRS_E2EProtocol), profiles 2 and 5; cantools 45, cantools.autosar.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

from canwire.errors import BadDescription

_IDS_OF_2 = 16  # one for each value of the counter
_IDS_OF_5 = 1


class Profile(NamedTuple):
    """The counter of a profile: `place` is its byte, `last` its highest value."""

    number: int
    place: int
    last: int


class Guard(NamedTuple):
    """The check of one message: the fault of its checksum ("" for none), its counter, the number of counter values."""

    name: str
    fault: str
    counter: tuple[int, int] | None


_PROFILES = {_IDS_OF_2: Profile(2, 1, 15), _IDS_OF_5: Profile(5, 2, 255)}


def profile_of(message: Any) -> Profile | None:
    """Return the profile that protects cantools' message; None without one, or if cantools does not support it."""
    e2e = None if message.autosar is None else message.autosar.e2e
    if e2e is None or not e2e.data_ids:
        return None
    return _PROFILES.get(len(e2e.data_ids))


def protected(message: Any, data: bytes, count: int) -> bytes:
    """Return the data with this counter and its checksum; in a container, each protected message gets them.

    Raises BadDescription if they do not fit."""
    made = bytearray(data)
    for held, profile, at, part in _guarded(message, data):
        made[at : at + len(part)] = _counted(held, profile, part, count)
    return bytes(made)


def guards_in(message: Any, data: bytes) -> list[Guard]:
    """Check the checksum of the message, or of each protected message in a container."""
    return [
        Guard(
            held.name,
            _fault_of(held, profile, part),
            (part[profile.place] & profile.last, profile.last + 1) if len(part) > profile.place else None,
        )
        for held, profile, _, part in _guarded(message, data)
    ]


def _guarded(message: Any, data: bytes) -> Iterator[tuple[Any, Profile, int, bytes]]:
    """Yield each protected message, its profile, the index of its data, and the data; nothing for a cut container."""
    parts: list[tuple[Any, bytes]] = [(message, data)]
    head = 4 if message.is_container else 0
    if message.is_container:
        try:
            parts = message.unpack_container(data)
        except import_module("cantools").database.DecodeError:
            return
    at = 0
    for held, part in parts:
        at += head
        if not isinstance(held, int) and (profile := profile_of(held)) is not None:
            yield held, profile, at, bytes(part)
        at += len(part)


def _counted(message: Any, profile: Profile, data: bytes, count: int) -> bytes:
    if len(data) <= profile.place:
        raise BadDescription(
            f"{message.name}: {len(data)} bytes have no room for E2E profile {profile.number}"
        )
    counted = bytearray(data)
    upper = counted[profile.place] & ~profile.last & 0xFF
    counted[profile.place] = upper | count % (profile.last + 1)
    found = getattr(_end_to_end(), f"apply_profile{profile.number}_crc")(bytes(counted), message)
    return bytes(counted if found is None else found)


def _fault_of(message: Any, profile: Profile, data: bytes) -> str:
    right = getattr(_end_to_end(), f"check_profile{profile.number}_crc")(data, message)
    if right is None:
        return f"too short for E2E profile {profile.number}"
    return "" if right else f"wrong checksum (E2E profile {profile.number})"


def contents_of(message: Any, data: bytes) -> Iterator[tuple[Any, bytes]]:
    """Yield each message in a container, and its data; a message that the file does not define is given as its number.

    Raises cantools' DecodeError if the container's length fields do not match its data."""
    for held, part in message.unpack_container(data):
        if part or not isinstance(held, int):  # zeros behind the last one fill the frame
            yield held, bytes(part)


def _end_to_end() -> Any:
    return import_module("cantools.autosar.end_to_end")
