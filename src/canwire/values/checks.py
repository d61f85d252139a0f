"""Checks of the arguments of public calls; the code below these calls does not check again."""

from __future__ import annotations

import math
from numbers import Real

from canwire.errors import BadValue

LONGEST_NS = 1 << 62  # 146 years
_LONGEST_S = LONGEST_NS // 1_000_000_000
_LEAST_PACE, _MOST_PACE = 0.0001, 10_000.0
_SHOWN = 60  # characters of a value in an error


def instance(name: str, value: object, *kinds: type) -> None:
    """Raise TypeError with the expected and the given type, unless the value has one of these types."""
    if not isinstance(value, kinds):
        wanted = " or ".join(kind.__name__ for kind in kinds)
        came = f"the class {value.__name__}" if isinstance(value, type) else type(value).__name__
        raise TypeError(f"{name} {shown(value)}: must be {wanted}, not {came}")


def check_frame(frame: object, kind: type) -> None:
    """Raise TypeError unless the value is a frame of this class; for a text the message shows how to make one."""
    if isinstance(frame, int):
        raise TypeError(f"frame {frame:#x}: must be Frame, not int; write Frame({frame:#x}, data)")
    if isinstance(frame, str):
        raise TypeError(
            f"frame {shown(frame)}: must be Frame, not str; parse_frame(text) makes one of 123#1122"
        )
    instance("frame", frame, kind)


def more_than_a_frame(frame: object, others: tuple[object, ...]) -> TypeError:
    """The error for a `send` that was given other arguments than a frame, as an identifier and bytes."""
    if isinstance(frame, int) and not isinstance(frame, bool):
        return TypeError(f"send() takes one frame: send(Frame({frame:#x}, {shown(others[0])}))")
    return TypeError(
        f"send(): {shown(others[0])} is one argument too many; send(frame) does not wait for room"
    )


def check_expected(id: object) -> None:
    """Raise TypeError if an expected identifier is no integer."""
    if isinstance(id, str):
        raise TypeError(
            f"id {shown(id)}: must be int, not str; a message has a name by a database: "
            f"db.on(node).expect_message({shown(id)}, within=...)"
        )
    instance("id", id, int)


def whole(name: str, value: int, lowest: int, highest: int) -> int:
    """An integer within bounds, both included; raises BadValue, or TypeError for what is no integer."""
    try:
        number = value.__index__()
    except (AttributeError, TypeError):
        instance(name, value, int)
        raise
    if not lowest <= number <= highest:
        raise BadValue(f"{name} {shown(value)}: from {lowest} to {highest}")
    return number


def finite(name: str, value: float, lowest: float, highest: float) -> float:
    """A number within bounds, both included; raises BadValue, or TypeError for what is no number."""
    _number(name, value)
    if not lowest <= value <= highest:
        raise BadValue(f"{name} {shown(value)}: from {lowest:g} to {highest:g}")
    return float(value)


def pace(factor: float | None) -> float:
    """Check the number of virtual seconds in one second of the wall clock; None (no limit) becomes 0."""
    return 0.0 if factor is None else finite("pace", factor, _LEAST_PACE, _MOST_PACE)


def nanoseconds(name: str, seconds: float) -> int:
    """A span in whole nanoseconds. A span above 0 becomes at least 1, so a wait for it always lets time pass.

    Raises BadValue if it is negative, not finite or longer than 146 years.
    """
    _number(name, seconds)
    if not 0 <= seconds <= _LONGEST_S:
        raise BadValue(f"{name} {shown(seconds)}: a finite time, not negative, of at most 146 years")
    return round(seconds * 1e9) or int(seconds > 0)


def shown(value: object) -> str:
    """A value in a short form for an error message."""
    if isinstance(value, int) and not -(1 << 128) < value < 1 << 128:
        return f"of {math.ceil(value.bit_length() / 3.3219)} digits"
    if isinstance(value, (str, bytes, bytearray)) and len(value) > _SHOWN:
        value = value[:_SHOWN]  # the rest of a megabyte is not shown
    text = repr(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


def _number(name: str, value: object) -> None:
    if not isinstance(
        value, (int, float, Real)
    ):  # the first two are what nearly everybody hands in, and quick
        instance(name, value, int, float)


def octets(name: str, value: bytes | bytearray | memoryview) -> bytes:
    """The bytes of a buffer of any shape; raises TypeError for other objects."""
    instance(name, value, bytes, bytearray, memoryview)
    return bytes(value)
