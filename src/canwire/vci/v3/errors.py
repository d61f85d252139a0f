"""The exceptions of the .NET interface, and their translation from canwire's and V4's errors.

CanwireError
  vci.VciError                            `code` is the header's number, `str` its text
    VciException                          VCI refused
      ArgumentException (ValueError)      an argument is wrong
        ArgumentOutOfRangeException (IndexError)
    NotImplementedException (NotImplementedError)
    InvalidOperationException             defined by .NET: an enumerator that is at no element
      ObjectDisposedException

As in .NET, the last three are not derived from VciException: they allow programs to distinguish "another program has
the cyclic list" from "this board has no cyclic list" (manual 4.2.5). `vci.VciError` catches all of them, in V3 and V4.
Source: VCI V3 .NET manual 4.1 and 4.2.5; reference/vci.md section 7a.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from canwire import CanwireError
from canwire.vci.structures.errors import (
    VCI_E_INVALID_INDEX,
    VCI_E_INVALIDARG,
    VCI_E_INVHANDLE,
    VCI_E_NOINTERFACE,
    VCI_E_NOT_IMPLEMENTED,
    VciError,
)
from canwire.vci.translation import as_vci_error


class VciException(VciError):
    """VCI refused the call; `code` is the cause."""


class ArgumentException(VciException, ValueError):
    """An argument is wrong: VCI_E_INVALIDARG."""


class ArgumentOutOfRangeException(ArgumentException, IndexError):
    """An argument, an index or a property's value is out of range."""


class NotImplementedException(VciError, NotImplementedError):
    """The object does not exist: a board has no cyclic list, or a connector does not have the interface."""


class InvalidOperationException(VciError):
    """The object is in the wrong state: an enumerator is before its first element, or after the last one."""


class ObjectDisposedException(InvalidOperationException):
    """The object was disposed, or what it belongs to no longer exists, or the channel is not initialised yet."""


_KINDS: dict[int, type[VciError]] = {
    VCI_E_INVALIDARG: ArgumentException,
    VCI_E_INVALID_INDEX: ArgumentOutOfRangeException,
    VCI_E_NOT_IMPLEMENTED: NotImplementedException,
    VCI_E_NOINTERFACE: NotImplementedException,
    VCI_E_INVHANDLE: ObjectDisposedException,
}
OURS = (VciException, NotImplementedException, InvalidOperationException)


def as_exception(error: CanwireError) -> VciError:
    """The exception of V3 for an error, with the same text; an exception of V3 is returned as it is."""
    known = as_vci_error(error)
    if isinstance(known, OURS):
        return known
    return _KINDS.get(known.code, VciException)(known.code, known.what)


@contextlib.contextmanager
def exceptions() -> Iterator[None]:
    """A context that raises errors of canwire and V4 as exceptions of V3."""
    try:
        yield
    except OURS:
        raise
    except CanwireError as error:
        raise as_exception(error) from error


def out_of_range(name: str, value: object, low: int, high: int) -> ArgumentOutOfRangeException:
    """The exception for a value that is no whole number from `low` to `high`."""
    text = f"{name} {value!r:.40}: a whole number from {low} to {high}"
    return ArgumentOutOfRangeException(VCI_E_INVALIDARG, text)


def checked(name: str, value: int, high: int, low: int = 0) -> int:
    """The value; raises ArgumentOutOfRangeException if it is no whole number from `low` to `high`."""
    if not isinstance(value, int) or not low <= value <= high:
        raise out_of_range(name, value, low, high)
    return value
