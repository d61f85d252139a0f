"""IDisposable: objects that hold other objects until `dispose`.

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
    """Makes a method of an interface raise V3's exceptions: for each error, and if the object was disposed."""

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
    """Holds objects of V4 and releases them in `dispose`, which the end of a `with` block calls.

    A second `dispose` does nothing; each other call after `dispose` raises ObjectDisposedException. Calls raise
    VciException with VCI_E_DEVICE_NOT_CONNECTED once the board is removed, or VCI_E_DISCONNECTED once the hub is gone.
    """

    def __init__(self) -> None:
        self._held: list[Unknown] = []
        self._disposed = False

    def dispose(self) -> None:
        """Dispose: release what the object holds."""
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
        """Keep one reference until `dispose`."""
        self._held.append(held)
        return held

    def _drop(self, held: Unknown) -> None:
        """Release one object before `dispose`."""
        if held in self._held:
            self._held.remove(held)
            held.release()

    def _check(self) -> None:
        if self._disposed:
            raise ObjectDisposedException(VCI_E_INVHANDLE, f"this {type(self).__name__} was disposed")
