"""The result code of VCI for each error of canwire.

The first class in an error's order of base classes that is in the table decides. Source: reference/vci.md section 1;
a function whose description requires another code uses `meaning`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping

from canwire import (
    BadConfig,
    BadDescription,
    BadFilter,
    BadFrame,
    BadLog,
    BadMessage,
    BadSignals,
    BadText,
    BadTiming,
    BadValue,
    BusOff,
    Busy,
    CanwireError,
    Closed,
    ExtraMissing,
    HubError,
    HubLost,
    InUse,
    LimitReached,
    LineError,
    NoChannel,
    NoSuchBoard,
    NothingHeard,
    NotIdle,
    NotInitialised,
    NotReceived,
    NotTransmitted,
    QueueFull,
    Unplugged,
    Unsupported,
    WrongState,
)
from canwire.vci.structures.errors import (
    VCI_E_ABORT,
    VCI_E_ACCESSDENIED,
    VCI_E_BUSY,
    VCI_E_DEVICE_NOT_CONNECTED,
    VCI_E_DISCONNECTED,
    VCI_E_FAIL,
    VCI_E_INVALID_STATE,
    VCI_E_INVALID_TIMING,
    VCI_E_INVALIDARG,
    VCI_E_INVHANDLE,
    VCI_E_NO_SUCH_DEVICE,
    VCI_E_NOT_IMPLEMENTED,
    VCI_E_NOT_INITIALIZED,
    VCI_E_NOT_SUPPORTED,
    VCI_E_OUTOFMEMORY,
    VCI_E_TIMEOUT,
    VCI_E_TXQUEUE_FULL,
    VCI_E_UNEXPECTED,
    VciError,
)

CODES: Mapping[type[CanwireError], int] = {
    CanwireError: VCI_E_FAIL,
    BadValue: VCI_E_INVALIDARG,
    BadFrame: VCI_E_INVALIDARG,
    BadTiming: VCI_E_INVALID_TIMING,
    BadFilter: VCI_E_INVALIDARG,
    BadText: VCI_E_INVALIDARG,
    BadConfig: VCI_E_INVALIDARG,
    BadDescription: VCI_E_INVALIDARG,
    BadLog: VCI_E_INVALIDARG,
    BadSignals: VCI_E_INVALIDARG,
    LineError: VCI_E_INVALID_STATE,
    Busy: VCI_E_BUSY,
    QueueFull: VCI_E_TXQUEUE_FULL,
    NotTransmitted: VCI_E_ABORT,
    BusOff: VCI_E_INVALID_STATE,
    InUse: VCI_E_ACCESSDENIED,
    NoChannel: VCI_E_ACCESSDENIED,
    NotInitialised: VCI_E_NOT_INITIALIZED,
    WrongState: VCI_E_INVALID_STATE,
    Unsupported: VCI_E_NOT_SUPPORTED,
    NothingHeard: VCI_E_TIMEOUT,
    HubError: VCI_E_FAIL,
    HubLost: VCI_E_DISCONNECTED,
    NoSuchBoard: VCI_E_NO_SUCH_DEVICE,
    Unplugged: VCI_E_DEVICE_NOT_CONNECTED,
    LimitReached: VCI_E_OUTOFMEMORY,
    BadMessage: VCI_E_UNEXPECTED,
    Closed: VCI_E_INVHANDLE,
    NotIdle: VCI_E_BUSY,
    NotReceived: VCI_E_TIMEOUT,
    ExtraMissing: VCI_E_NOT_IMPLEMENTED,
}


def as_vci_error(error: CanwireError) -> VciError:
    """The VciError for an error, with the same text; a VciError is returned as it is."""
    if isinstance(error, VciError):
        return error
    code = next(CODES[kind] for kind in type(error).__mro__ if kind in CODES)
    return VciError.of(code, str(error))


@contextlib.contextmanager
def translated() -> Iterator[None]:
    """A context that raises errors of canwire as VciError."""
    try:
        yield
    except CanwireError as error:
        known = as_vci_error(error)
        if known is error:
            raise
        raise known from error


@contextlib.contextmanager
def meaning(code: int, *kinds: type[CanwireError]) -> Iterator[None]:
    """A context that raises errors of these kinds as VciError with this code."""
    try:
        yield
    except kinds as error:
        raise VciError.of(code, str(error)) from error
