"""The signature of Frame, and errors for unknown arguments, with their canwire name or the most similar one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from inspect import Signature

_OF_PYTHON_CAN = {
    "arbitration_id": "id",
    "is_extended_id": "extended",
    "is_remote_frame": "remote",
    "is_fd": "fd",
    "bitrate_switch": "bit_rate_switch",
    "timestamp": "timestamp_ns",
    "bitrate": "bit_rate",
    "data_bitrate": "data_bit_rate",
    "f_clock": "timing",
    "sample_point": "timing",
    "can_filters": "filters",
    "receive_own_messages": "self_reception",
    "monitor": "listen_only",
    "fd_non_iso": "iso_fd",
}
_WORTH_A_WORD = {
    "extended": " (False unless given: the reverse of python-can)",
    "timestamp_ns": ", in whole nanoseconds",
    "iso_fd": ", with the reverse meaning",
}


def unknown_argument(call: str, unknown: Iterable[str], prototype: Callable[..., Any]) -> TypeError:
    """The error for the first of the `unknown` names; for names of python-can it gives the canwire name."""
    name = next(iter(unknown))
    code = getattr(prototype, "__wrapped__", prototype).__code__
    taken = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    there = [one for one in taken if one != "self"]
    here = _OF_PYTHON_CAN.get(name)
    if here is not None and here in there:
        return TypeError(
            f"{call} has no argument {name!r}: what python-can calls {name} is {here} here{_WORTH_A_WORD.get(here, '')}"
        )
    from difflib import get_close_matches  # for mistakes alone

    near = get_close_matches(name, there, 1)
    hint = f"; did you mean {near[0]!r}?" if near else f"; it has {', '.join(there)}"
    return TypeError(f"{call} has no argument {name!r}{hint}")


def frame(
    id: int,
    data: bytes | bytearray | memoryview = b"",
    *,
    extended: bool = False,
    remote: bool = False,
    fd: bool = False,
    bit_rate_switch: bool = False,
    error_state_indicator: bool = False,
    dlc: int | None = None,
    timestamp_ns: int = 0,
    self_received: bool = False,
) -> None:
    """The signature of Frame for inspect and help(), which cannot read that of a compiled class."""


class SignatureOf:
    """`__signature__` for a class whose compiled form has none that Python could read: that of `prototype`."""

    def __init__(self, prototype: Callable[..., Any]) -> None:
        self._prototype = prototype

    def __get__(self, instance: object, owner: type) -> Signature:
        import inspect  # 8 ms that only help() and its like pay

        return inspect.signature(self._prototype)
