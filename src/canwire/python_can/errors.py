"""Our errors as python-can's, with our message."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from can import CanInitializationError, CanOperationError

from canwire import CanwireError


@contextmanager
def operating() -> Iterator[None]:
    """Whatever goes wrong is a CanOperationError."""
    try:
        yield
    except CanwireError as error:
        raise CanOperationError(str(error)) from error


@contextmanager
def opening() -> Iterator[None]:
    """Whatever goes wrong is a CanInitializationError."""
    try:
        yield
    except CanwireError as error:
        raise CanInitializationError(str(error)) from error
