"""CandrvError: a call that failed, with the Win32 code of GetLastError; and the table of canwire's errors to codes.

Source: CANDRV manual, 7.8 and chapter 8; rulings.md 20; winerror.h for the texts.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from canwire import CanwireError, NoSuchBoard
from canwire.candrv.constants import Win32Error

TEXTS = {
    Win32Error.ERROR_SUCCESS: "the operation completed successfully",
    Win32Error.ERROR_FILE_NOT_FOUND: "no such device exists",
    Win32Error.ERROR_ACCESS_DENIED: "the handle was not opened with the access that the call needs",
    Win32Error.ERROR_INVALID_HANDLE: "the handle is closed or invalid",
    Win32Error.ERROR_INVALID_DATA: "the data is invalid",
    Win32Error.ERROR_NOT_READY: "the device is not ready",
    Win32Error.ERROR_GEN_FAILURE: "the device is not functioning",
    Win32Error.ERROR_SHARING_VIOLATION: "another handle or program uses it and does not share it",
    Win32Error.ERROR_NOT_SUPPORTED: "the request is not supported",
    Win32Error.ERROR_DEV_NOT_EXIST: "the device is no longer available",
    Win32Error.ERROR_FILE_EXISTS: "the file exists",
    Win32Error.ERROR_INVALID_PARAMETER: "the parameter is incorrect",
    Win32Error.ERROR_INSUFFICIENT_BUFFER: "the buffer is too small",
    Win32Error.ERROR_MOD_NOT_FOUND: "a module is missing",
    Win32Error.ERROR_BUSY: "the device is in use",
    Win32Error.ERROR_OPERATION_ABORTED: "the operation was aborted",
    Win32Error.ERROR_BADDB: "the registry is damaged",
    Win32Error.ERROR_IO_DEVICE: "the controller left the bus",
    Win32Error.ERROR_NO_SYSTEM_RESOURCES: "all virtual channels are taken",
    Win32Error.ERROR_TIMEOUT: "the time ran out",
    Win32Error.ERROR_DEVICE_REMOVED: "the board was pulled out",
    Win32Error.ERROR_INVALID_STATE: "the call is not possible in this state",
}

# the code of each error of canwire, by its name; an error that is not listed has the code of its base class
CODES = {
    "CanwireError": Win32Error.ERROR_GEN_FAILURE,
    "BadValue": Win32Error.ERROR_INVALID_PARAMETER,
    "BadFrame": Win32Error.ERROR_INVALID_PARAMETER,
    "BadTiming": Win32Error.ERROR_INVALID_PARAMETER,
    "BadFilter": Win32Error.ERROR_INVALID_PARAMETER,
    "BadText": Win32Error.ERROR_INVALID_PARAMETER,
    "BadConfig": Win32Error.ERROR_BADDB,
    "BadDescription": Win32Error.ERROR_INVALID_PARAMETER,
    "BadLog": Win32Error.ERROR_INVALID_PARAMETER,
    "BadSignals": Win32Error.ERROR_INVALID_PARAMETER,
    "LineError": Win32Error.ERROR_GEN_FAILURE,
    "QueueFull": Win32Error.ERROR_TIMEOUT,
    "Busy": Win32Error.ERROR_BUSY,
    "NotTransmitted": Win32Error.ERROR_OPERATION_ABORTED,
    "BusOff": Win32Error.ERROR_IO_DEVICE,
    "InUse": Win32Error.ERROR_SHARING_VIOLATION,
    "NotInitialised": Win32Error.ERROR_NOT_READY,
    "WrongState": Win32Error.ERROR_INVALID_STATE,
    "NoChannel": Win32Error.ERROR_NO_SYSTEM_RESOURCES,
    "Unsupported": Win32Error.ERROR_NOT_SUPPORTED,
    "NothingHeard": Win32Error.ERROR_TIMEOUT,
    "HubError": Win32Error.ERROR_GEN_FAILURE,
    "HubLost": Win32Error.ERROR_DEV_NOT_EXIST,
    "NoSuchBoard": Win32Error.ERROR_FILE_NOT_FOUND,
    "Unplugged": Win32Error.ERROR_DEVICE_REMOVED,
    "LimitReached": Win32Error.ERROR_NO_SYSTEM_RESOURCES,
    "BadMessage": Win32Error.ERROR_INVALID_DATA,
    "Closed": Win32Error.ERROR_INVALID_HANDLE,
    "NotIdle": Win32Error.ERROR_TIMEOUT,
    "NotReceived": Win32Error.ERROR_TIMEOUT,
    "ExtraMissing": Win32Error.ERROR_MOD_NOT_FOUND,
}


class CandrvError(CanwireError):
    """A call that failed: `code` is the Win32 code, `what` names the object and the cause."""

    def __init__(self, code: int, what: str = "") -> None:
        text = format_error(code)
        super().__init__(f"{text}: {what}" if what else text)
        self.code = int(code)
        self.what = what

    @property
    def name(self) -> str:
        """The code's name, or its number."""
        return _name(self.code)


def format_error(code: int) -> str:
    """`ERROR_TIMEOUT (1460), the time ran out`"""
    known = TEXTS.get(code)  # type: ignore[call-overload]
    return f"{_name(code)} ({int(code)}), {known}" if known else f"error {int(code)}"


def _name(code: int) -> str:
    try:
        return Win32Error(code).name
    except ValueError:
        return str(int(code))


def win32_code(error: CanwireError) -> int:
    """The Win32 code of an error of canwire, or of a CandrvError."""
    if isinstance(error, CandrvError):
        return error.code
    return next(CODES[base.__name__] for base in type(error).__mro__ if base.__name__ in CODES)


def as_candrv(error: CanwireError) -> CandrvError:
    """The error as a CandrvError with the same text."""
    return error if isinstance(error, CandrvError) else CandrvError(win32_code(error), str(error))


@contextmanager
def translated(*, opened: bool = False) -> Iterator[None]:
    """A context that raises errors of canwire as CandrvError. `opened`: a missing board means that it was removed."""
    try:
        yield
    except CandrvError:
        raise
    except NoSuchBoard as error:
        code = Win32Error.ERROR_DEVICE_REMOVED if opened else win32_code(error)
        raise CandrvError(code, str(error)) from error
    except CanwireError as error:
        raise as_candrv(error) from error
