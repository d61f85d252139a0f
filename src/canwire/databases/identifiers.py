"""J1939 identifiers: priority, parameter group, addresses.

Source: SAE J1939-21 5.1.
"""

from __future__ import annotations

from canwire.databases.description import MessageDescription
from canwire.errors import BadValue


def addressed(
    message: MessageDescription, source: int | None, destination: int | None, priority: int | None
) -> int:
    """The identifier; arguments that are not None replace the values of the file. Raises BadValue."""
    told = (("source", source, 255), ("destination", destination, 255), ("priority", priority, 7))
    for what, value, most in told:
        if value is None:
            continue
        if not message.j1939:
            raise BadValue(f"{message.name} is no J1939 message: it has no {what}")
        if not isinstance(value, int) or not 0 <= value <= most:
            raise BadValue(f"{message.name}: {what} {value!r}: 0 to {most}")
    if destination is not None and message.id >> 16 & 0xFF >= 240:
        raise BadValue(
            f"{message.name}: parameter group {message.pgn:#x} is for everybody, it has no destination"
        )
    id = message.id
    if source is not None:
        id = id & ~0xFF | source
    if destination is not None:
        id = id & ~0xFF00 | destination << 8
    if priority is not None:
        id = id & 0x3FF_FFFF | priority << 26
    return id
