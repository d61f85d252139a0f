"""The common part of all objects of VCI: reference counts, interfaces, and errors as VciError.

Source: VCI V4 manual 6.2.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ClassVar, Concatenate, ParamSpec, Self, TypeVar
from uuid import UUID

from canwire import CanwireError, HubLost, Unplugged
from canwire.vci.structures.errors import VCI_E_INVHANDLE, VCI_E_NOINTERFACE, VciError
from canwire.vci.structures.guids import INTERFACES, IID_IUnknown
from canwire.vci.translation import as_vci_error

if TYPE_CHECKING:
    from types import TracebackType

P = ParamSpec("P")
R = TypeVar("R")
Object = TypeVar("Object", bound="Unknown")


def vci_call(method: Callable[Concatenate[Object, P], R]) -> Callable[Concatenate[Object, P], R]:
    """Makes a method of an interface raise VciError: for each error of canwire, and if the object was released."""

    @wraps(method)
    def call(self: Object, /, *args: P.args, **kwargs: P.kwargs) -> R:
        try:
            self._check()
            return method(self, *args, **kwargs)
        except VciError:
            raise
        except CanwireError as error:
            raise as_vci_error(error) from error

    return call


class Unknown:
    """IUnknown: an object that exists while it has references.

    A call that returns an object returns one reference; `release` or the end of a `with` block releases it. After the
    last reference is released, each further call raises VciError with VCI_E_INVHANDLE.

    Calls raise VciError with VCI_E_DISCONNECTED once the hub is gone, and with VCI_E_DEVICE_NOT_CONNECTED once the
    board is removed.
    """

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown})

    def __init__(self) -> None:
        self._references = 1

    def query_interface(self, iid: UUID) -> Any:
        """QueryInterface: another interface of the object, with one more reference.

        Raises VciNoInterface for an interface that the object does not have. Source: manual 6.2.1.
        """
        self._check_references()
        if iid not in self.interfaces:
            raise no_interface(self, iid)
        self._references += 1
        return self

    def add_ref(self) -> int:
        """AddRef: add a reference; returns the number of references. Source: manual 6.2.2."""
        self._check_references()
        self._references += 1
        return self._references

    def release(self) -> int:
        """Release: release a reference; returns how many are left, 0 if the object no longer exists.

        Source: manual 6.2.3.
        """
        self._check_references()
        self._references -= 1
        if self._references == 0:
            with contextlib.suppress(HubLost, Unplugged):  # then nothing is left to release
                self._close()
        return self._references

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._references:
            self.release()

    def _check(self) -> None:
        """Raises an error if the object cannot be used; subclasses also check what they hold."""
        self._check_references()

    def _check_references(self) -> None:
        if not self._references:
            raise VciError.of(VCI_E_INVHANDLE, f"this {type(self).__name__} was released")

    def _close(self) -> None:
        """Release what the object holds; called once, after the last reference."""


def no_interface(there: Unknown, iid: object) -> VciError:
    """The error for an interface that an object does not have."""
    return VciError.of(VCI_E_NOINTERFACE, f"{type(there).__name__} has no {interface_name(iid)}")


def interface_name(iid: object) -> str:
    """The name of an interface identifier for messages; its digits if it is unknown."""
    return next((name for name, known in INTERFACES.items() if known == iid), str(iid))
