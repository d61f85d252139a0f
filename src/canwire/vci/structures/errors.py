"""Result codes, their text, and the exceptions that carry them.

A code has 32 bits: 31-30 severity (0 success, 1 information, 2 warning, 3 error), 29 customer, 27-16 facility,
15-0 code. The manual names only codes that single functions return; the numbers are those of vcierr.h. The texts are
canwire's, since those of the original are in its library.
Source: VCI V4 manual 6.1.2; reference/vci.md section 1.

VciError has a subclass for each frequent code:
VciAccessDenied VciBufferOverflow VciBusy VciDeviceNotConnected VciDisconnected VciFail
VciInvalidArgument VciInvalidIndex VciInvalidState VciNoInterface VciNoMoreItems VciNoSuchDevice
VciNotImplemented VciNotInitialized VciNotSupported VciRxQueueEmpty VciTimeout VciTxQueueFull
"""

from __future__ import annotations

import operator
from typing import Self, cast

from canwire import CanwireError

FACILITY_VCI = 1
SEV_VCI_INFO = 0x60010000
SEV_VCI_WARN = 0xA0010000
SEV_VCI_ERROR = 0xE0010000
VCI_MAX_ERRSTRLEN = 256  # with the final NUL

VCI_OK = 0
VCI_SUCCESS = 0
VCI_E_UNEXPECTED = 0xE0010001
VCI_E_NOT_IMPLEMENTED = 0xE0010002
VCI_E_OUTOFMEMORY = 0xE0010003
VCI_E_INVALIDARG = 0xE0010004
VCI_E_NOINTERFACE = 0xE0010005
VCI_E_INVPOINTER = 0xE0010006
VCI_E_INVHANDLE = 0xE0010007
VCI_E_ABORT = 0xE0010008
VCI_E_FAIL = 0xE0010009
VCI_E_ACCESSDENIED = 0xE001000A
VCI_E_TIMEOUT = 0xE001000B
VCI_E_BUSY = 0xE001000C
VCI_E_PENDING = 0xE001000D
VCI_E_NO_DATA = 0xE001000E
VCI_E_NO_MORE_ITEMS = 0xE001000F
VCI_E_NOT_INITIALIZED = 0xE0010010
VCI_E_ALREADY_INITIALIZED = 0xE0010011
VCI_E_RXQUEUE_EMPTY = 0xE0010012
VCI_E_TXQUEUE_FULL = 0xE0010013
VCI_E_BUFFER_OVERFLOW = 0xE0010014
VCI_E_INVALID_STATE = 0xE0010015
VCI_E_OBJECT_ALREADY_EXISTS = 0xE0010016
VCI_E_INVALID_INDEX = 0xE0010017
VCI_E_END_OF_FILE = 0xE0010018
VCI_E_DISCONNECTED = 0xE0010019
VCI_E_INVALID_FIRMWARE = 0xE001001A
VCI_E_INVALID_LICENSE = 0xE001001B
VCI_E_NO_SUCH_LICENSE = 0xE001001C
VCI_E_LICENSE_EXPIRED = 0xE001001D
VCI_E_LICENSE_QUOTA_EXCEEDED = 0xE001001E
VCI_E_INVALID_TIMING = 0xE001001F
VCI_E_IN_USE = 0xE0010020
VCI_E_NO_SUCH_DEVICE = 0xE0010021
VCI_E_DEVICE_NOT_CONNECTED = 0xE0010022
VCI_E_DEVICE_NOT_READY = 0xE0010023
VCI_E_TYPE_MISMATCH = 0xE0010024
VCI_E_NOT_SUPPORTED = 0xE0010025
VCI_E_DUPLICATE_OBJECTID = 0xE0010026
VCI_E_OBJECTID_NOT_FOUND = 0xE0010027
VCI_E_WRONG_LEVEL = 0xE0010028
VCI_E_WRONG_DRV_VERSION = 0xE0010029
VCI_E_LUIDS_EXHAUSTED = 0xE001002A

_NAMES = {value: name for name, value in list(globals().items()) if name.startswith("VCI_E_")} | {0: "VCI_OK"}
_MEANINGS = {
    VCI_OK: "success",
    VCI_E_UNEXPECTED: "an unexpected failure",
    VCI_E_NOT_IMPLEMENTED: "the function is not implemented",
    VCI_E_OUTOFMEMORY: "no memory left",
    VCI_E_INVALIDARG: "an argument is wrong",
    VCI_E_NOINTERFACE: "the object does not have that interface",
    VCI_E_INVPOINTER: "a pointer is wrong",
    VCI_E_INVHANDLE: "a handle is wrong",
    VCI_E_ABORT: "the operation was aborted",
    VCI_E_FAIL: "the call failed for a reason without a code",
    VCI_E_ACCESSDENIED: "another program or object uses it, or the access is not allowed",
    VCI_E_TIMEOUT: "the time ran out",
    VCI_E_BUSY: "the resource is busy",
    VCI_E_PENDING: "the result is not available yet",
    VCI_E_NO_DATA: "no data are available",
    VCI_E_NO_MORE_ITEMS: "the enumeration is at its end",
    VCI_E_NOT_INITIALIZED: "the object is not initialised",
    VCI_E_ALREADY_INITIALIZED: "the object is initialised already",
    VCI_E_RXQUEUE_EMPTY: "the receive queue is empty",
    VCI_E_TXQUEUE_FULL: "the transmit queue is full",
    VCI_E_BUFFER_OVERFLOW: "the data do not fit into the buffer",
    VCI_E_INVALID_STATE: "the object is in the wrong state for the call",
    VCI_E_OBJECT_ALREADY_EXISTS: "the object exists already",
    VCI_E_INVALID_INDEX: "the index is invalid",
    VCI_E_END_OF_FILE: "the end of the data is reached",
    VCI_E_DISCONNECTED: "the connection is lost",
    VCI_E_INVALID_FIRMWARE: "the firmware cannot be used, or is too old",
    VCI_E_INVALID_LICENSE: "the licence is not valid",
    VCI_E_NO_SUCH_LICENSE: "no such licence exists",
    VCI_E_LICENSE_EXPIRED: "the licence has expired",
    VCI_E_LICENSE_QUOTA_EXCEEDED: "the limit of the licence is reached",
    VCI_E_INVALID_TIMING: "the bit timing is wrong",
    VCI_E_IN_USE: "the resource is taken",
    VCI_E_NO_SUCH_DEVICE: "no such device exists",
    VCI_E_DEVICE_NOT_CONNECTED: "the device is not plugged in",
    VCI_E_DEVICE_NOT_READY: "the device is not ready",
    VCI_E_TYPE_MISMATCH: "the type is wrong",
    VCI_E_NOT_SUPPORTED: "the device does not support it",
    VCI_E_DUPLICATE_OBJECTID: "the object identifier is used twice",
    VCI_E_OBJECTID_NOT_FOUND: "no object has that identifier",
    VCI_E_WRONG_LEVEL: "the call is not possible at this execution level",
    VCI_E_WRONG_DRV_VERSION: "the version of the driver is wrong",
    VCI_E_LUIDS_EXHAUSTED: "no identifiers are left",
}
_SEVERITIES = ("success", "information", "warning", "error")
_by_code: dict[int, type[VciError]] = {}


class VciError(CanwireError):
    """A call that did not return VCI_OK; `what` names the object and the cause.

    VciError(code) makes an instance of the subclass for that code, so that `except VciTimeout` always works. `code` is
    the header's value or the negative HRESULT. Raises VciInvalidArgument if it is no 32-bit number.
    """

    def __init_subclass__(cls, code: int | None = None) -> None:
        if code is not None:
            _by_code[code] = cls

    def __new__(cls, code: int, what: str = "") -> Self:
        known = _by_code.get(_unsigned(code)) if cls is VciError else None
        return super().__new__(cast("type[Self]", known or cls))

    def __init__(self, code: int, what: str = "") -> None:
        text = format_error(code)
        super().__init__(f"{text}; {what}" if what else text)
        self.code = _unsigned(code)
        self.what = what

    @property
    def hresult(self) -> int:
        """The code as C's HRESULT: signed, negative for errors."""
        return self.code - (1 << 32) if self.code >> 31 else self.code

    @classmethod
    def of(cls, code: int, what: str = "") -> VciError:
        """The exception for a code, an instance of the code's subclass."""
        return VciError(code, what)


class VciNotImplemented(VciError, code=VCI_E_NOT_IMPLEMENTED):
    """VCI_E_NOT_IMPLEMENTED: the function is not implemented."""


class VciInvalidArgument(VciError, code=VCI_E_INVALIDARG):
    """VCI_E_INVALIDARG: an argument is wrong."""


class VciNoInterface(VciError, code=VCI_E_NOINTERFACE):
    """VCI_E_NOINTERFACE: the object does not have that interface."""


class VciFail(VciError, code=VCI_E_FAIL):
    """VCI_E_FAIL: the call failed for a reason without a code."""


class VciAccessDenied(VciError, code=VCI_E_ACCESSDENIED):
    """VCI_E_ACCESSDENIED: another program or object uses it."""


class VciTimeout(VciError, code=VCI_E_TIMEOUT):
    """VCI_E_TIMEOUT: the time ran out."""


class VciBusy(VciError, code=VCI_E_BUSY):
    """VCI_E_BUSY: the resource is busy."""


class VciNoMoreItems(VciError, code=VCI_E_NO_MORE_ITEMS):
    """VCI_E_NO_MORE_ITEMS: the enumeration is at its end."""


class VciNotInitialized(VciError, code=VCI_E_NOT_INITIALIZED):
    """VCI_E_NOT_INITIALIZED: the object is not initialised."""


class VciRxQueueEmpty(VciError, code=VCI_E_RXQUEUE_EMPTY):
    """VCI_E_RXQUEUE_EMPTY: the receive queue is empty."""


class VciTxQueueFull(VciError, code=VCI_E_TXQUEUE_FULL):
    """VCI_E_TXQUEUE_FULL: the transmit queue is full."""


class VciBufferOverflow(VciError, code=VCI_E_BUFFER_OVERFLOW):
    """VCI_E_BUFFER_OVERFLOW: the data do not fit into the buffer."""


class VciInvalidState(VciError, code=VCI_E_INVALID_STATE):
    """VCI_E_INVALID_STATE: the object is in the wrong state for the call."""


class VciInvalidIndex(VciError, code=VCI_E_INVALID_INDEX):
    """VCI_E_INVALID_INDEX: the index is invalid."""


class VciDisconnected(VciError, code=VCI_E_DISCONNECTED):
    """VCI_E_DISCONNECTED: the connection is lost."""


class VciNoSuchDevice(VciError, code=VCI_E_NO_SUCH_DEVICE):
    """VCI_E_NO_SUCH_DEVICE: no such device exists."""


class VciDeviceNotConnected(VciError, code=VCI_E_DEVICE_NOT_CONNECTED):
    """VCI_E_DEVICE_NOT_CONNECTED: the device is not plugged in."""


class VciNotSupported(VciError, code=VCI_E_NOT_SUPPORTED):
    """VCI_E_NOT_SUPPORTED: the device does not support it."""


def format_error(code: int) -> str:
    """VciFormatError: name, number and meaning of a result code, at most 255 characters.

    `code` is the header's value or the negative HRESULT; for an unknown code the text contains its severity, facility
    and number. Raises VciInvalidArgument if it is no 32-bit number.
    Source: VCI V4 manual 6.1.2.

    >>> format_error(-536805365)
    'VCI_E_TIMEOUT (0xE001000B): the time ran out'
    """
    number = _unsigned(code)
    if number in _NAMES:
        return f"{_NAMES[number]} (0x{number:08X}): {_MEANINGS[number]}"
    severity, facility = _SEVERITIES[number >> 30], number >> 16 & 0xFFF
    return f"0x{number:08X}: unknown result code ({severity} {number & 0xFFFF} of facility {facility})"


def _unsigned(code: object) -> int:
    try:
        number = operator.index(cast(int, code))
    except TypeError:
        number = 1 << 32
    if not -(1 << 31) <= number < 1 << 32:
        raise VciError(VCI_E_INVALIDARG, "a result code must be a 32-bit number")
    return number & 0xFFFF_FFFF
