"""IDisposable: objects that hold something until `dispose`.

Source: VCI V3 .NET manual 2.3 and 3.1.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Concatenate, ParamSpec, Self, TypeVar

from canwire import CanwireError
from canwire.vci.structures.errors import VCI_E_INVHANDLE
from canwire.vci.unknown import Unknown
from canwire.vci.v3.errors import OURS, ObjectDisposedException, as_exception

if TYPE_CHECKING:
    from types import TracebackType

P = ParamSpec("P")
R = TypeVar("R")
Object = TypeVar("Object", bound="Disposable")
Held = TypeVar("Held", bound=Unknown)


def net_call(method: Callable[Concatenate[Object, P], R]) -> Callable[Concatenate[Object, P], R]:
    """A method of an interface: refused once the object is disposed, and its errors come out as those of V3."""

    @wraps(method)
    def call(self: Object, /, *args: P.args, **kwargs: P.kwargs) -> R:
        self._check()
        try:
            return method(self, *args, **kwargs)
        except OURS:
            raise
        except CanwireError as error:
            raise as_exception(error) from error

    return call


class Disposable:
    """Holds objects of V4 and releases them in `dispose`, which a `with` block calls.

    Disposing twice is fine; every other call after that raises ObjectDisposedException. Once the board is pulled
    out, calls raise VciException with VCI_E_DEVICE_NOT_CONNECTED, once the hub is gone with VCI_E_DISCONNECTED.
    """

    def __init__(self) -> None:
        self._held: list[Unknown] = []
        self._disposed = False

    def dispose(self) -> None:
        """Dispose: give back what the object holds."""
        self._disposed = True
        while self._held:
            self._held.pop().release()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.dispose()

    def _hold(self, held: Held) -> Held:
        """Take over one reference."""
        self._held.append(held)
        return held

    def _drop(self, held: Unknown) -> None:
        """Release something before the rest."""
        if held in self._held:
            self._held.remove(held)
            held.release()

    def _check(self) -> None:
        if self._disposed:
            raise ObjectDisposedException(VCI_E_INVHANDLE, f"this {type(self).__name__} was disposed")
