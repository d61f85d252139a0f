"""Converts canwire's errors to python-can's: what happened, and what a python-can program can do about it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from can import CanInitializationError, CanOperationError

from canwire import CanwireError, Closed, HubLost, Unplugged

_REMEDIES = (
    (Closed, "it was shut down; stop what still uses it before, such as a Notifier (notifier.stop())"),
    (HubLost, "once a hub runs again (`canwire serve`), open a new can.Bus"),
    (Unplugged, "once it is plugged in again, open a new can.Bus"),
)
_RETURNS = "the bus connects again by itself, and nothing is sent until then"


@contextmanager
def operating(*, returns: bool = False) -> Iterator[None]:
    """Raise each error as a CanOperationError; `returns`: of a bus that connects again."""
    try:
        yield
    except CanwireError as error:
        raise operation_error(error, returns=returns) from error


@contextmanager
def opening() -> Iterator[None]:
    """Raise each error as a CanInitializationError."""
    try:
        yield
    except CanwireError as error:
        raise CanInitializationError(str(error)) from error


def operation_error(error: CanwireError, *, returns: bool = False) -> CanOperationError:
    """The CanOperationError for this error, with a remedy if one is known; `returns` as above."""
    if returns and isinstance(error, (HubLost, Unplugged)):
        return CanOperationError(f"{error}; {_RETURNS}")
    for kind, remedy in _REMEDIES:
        if isinstance(error, kind):
            return CanOperationError(f"{error}; {remedy}")
    return CanOperationError(str(error))
