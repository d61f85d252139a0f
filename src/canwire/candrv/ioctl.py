"""The control codes of DeviceIoControl: a table of the input, the output and the necessary access of each code.

As on Windows CE, the access bits inside a code do not decide: 8.11 sets a filter through a handle for reading, although
the code contains write access, and a handle with no access can read the device's time. A code needs the virtual channel
that it applies to; other codes need no access.

Source: CANDRV manual, 8.10 to 8.29 and appendix A; rulings.md 16.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError
from canwire.candrv.constants import ControlCode, Win32Error
from canwire.candrv.errors import CandrvError, as_candrv
from canwire.candrv.structures import (
    CAN_ACCEPTANCE_FILTER,
    CAN_EVENT,
    CAN_PROPERTIES,
    CAN_TIME,
    CAN_TRANSMIT_DATA,
)

if TYPE_CHECKING:
    from canwire.candrv.handle.handle import Handle

_DWORD = struct.Struct("<I")


class Reply(NamedTuple):
    """The output: bytes for the out buffer, and the function's return value (0: a failure, except for TEST_DEVICE)."""

    data: bytes = b""
    answer: int = 1


class Call(NamedTuple):
    """One call: the input bytes, and the previous content of the out buffer (`second`), which two codes read."""

    handle: Handle
    data: bytes
    second: bytes

    @property
    def number(self) -> int:
        """The DWORD or BYTE in the in buffer."""
        return int.from_bytes(self.data, "little")


class Code(NamedTuple):
    """A row of the table: the sizes in bytes of the in buffer (`takes`) and the out buffer (`gives`).

    `least` bytes in the in buffer are enough (0: all are needed). An `optional` out buffer may be missing. `reads` and
    `writes` say which channel the handle must have.
    """

    do: Callable[[Call], Reply]
    takes: int = 0
    gives: int = 0
    least: int = 0
    optional: bool = False
    reads: bool = False
    writes: bool = False


def control(handle: Handle, code: int, data: bytes = b"", out_size: int = 0, second: bytes = b"") -> Reply:
    """Execute a code; `out_size` is the size of the out buffer in bytes, `second` its previous content.

    Raises CandrvError: ERROR_NOT_SUPPORTED for an unknown code, ERROR_INVALID_PARAMETER for an in buffer that is too
    small, ERROR_INSUFFICIENT_BUFFER for an out buffer that is too small, ERROR_ACCESS_DENIED without the channel.
    """
    handle.check()
    row = CODES.get(code)
    if row is None:
        known = ", ".join(one.name for one in ControlCode)
        raise CandrvError(
            Win32Error.ERROR_NOT_SUPPORTED, f"control code {code:#x}: the known codes are {known}"
        )
    takes, gives = row.takes, row.gives
    if (row.reads and not handle.readable) or (row.writes and not handle.writable):
        raise _refused(code, row)
    if len(data) < (row.least or takes):
        raise CandrvError(
            Win32Error.ERROR_INVALID_PARAMETER,
            f"{ControlCode(code).name} needs {takes} bytes, not {len(data)}",
        )
    if out_size < gives and (out_size or not row.optional):
        raise CandrvError(
            Win32Error.ERROR_INSUFFICIENT_BUFFER,
            f"{ControlCode(code).name} returns {gives} bytes: the out buffer has {out_size}",
        )
    try:
        return row.do(Call(handle, data[:takes], second))
    except CandrvError:
        raise
    except CanwireError as error:
        raise as_candrv(error) from error


def _refused(code: int, row: Code) -> CandrvError:
    what = "receive channel (GENERIC_READ)" if row.reads else "send channel (GENERIC_WRITE)"
    return CandrvError(Win32Error.ERROR_ACCESS_DENIED, f"{ControlCode(code).name} needs a {what}")


# channels


def _write_filter(call: Call) -> Reply:
    call.handle.filter = CAN_ACCEPTANCE_FILTER.unpack(call.data)
    return Reply()


def _read_filter(call: Call) -> Reply:
    return Reply(call.handle.filter.pack())


def _write_transmit_data(call: Call) -> Reply:
    message = CAN_TRANSMIT_DATA.unpack(call.data)
    call.handle.write_message(
        message.identifier, bytes(message.msg), rtr=message.rtr, dlc=message.dlc, fmt=message.fmt
    )
    return Reply()


def _read_event_data(call: Call) -> Reply:
    return Reply(call.handle.read_event().pack())


# the device


def _set_baudrate(call: Call) -> Reply:
    call.handle.baud_rate = call.number
    return Reply()


def _get_baudrate(call: Call) -> Reply:
    return Reply(_DWORD.pack(call.handle.baud_rate))


def _set_baudrate_by_constant(call: Call) -> Reply:
    call.handle.baud_rate_constant = call.number
    return Reply()


def _get_baudrate_by_constant(call: Call) -> Reply:
    return Reply(_DWORD.pack(call.handle.baud_rate_constant))


def _set_can_mode(call: Call) -> Reply:
    call.handle.can_mode = call.number
    return Reply()


def _set_format(call: Call) -> Reply:
    call.handle.frame_format = call.number
    return Reply()


def _read_time(call: Call) -> Reply:
    return Reply(CAN_TIME(call.handle.time(), 0).pack())


def _read_properties(call: Call) -> Reply:
    return Reply(call.handle.properties().pack())


def _set_command(call: Call) -> Reply:
    call.handle.command(call.number)
    return Reply()


def _init(call: Call) -> Reply:
    """It also returns the error status, which is 0 on success."""
    call.handle.initialise()
    return Reply(_DWORD.pack(Win32Error.ERROR_SUCCESS))


def _test_device(call: Call) -> Reply:
    return Reply(b"", int(call.handle.in_configuration_mode()))


# registers: both buffers go in when one is written


def _register_reader(reset_mode: bool) -> Callable[[Call], Reply]:
    def read(call: Call) -> Reply:
        return Reply(bytes([call.handle.read_register(call.number, reset_mode=reset_mode)]))

    return read


def _register_writer(reset_mode: bool) -> Callable[[Call], Reply]:
    def write(call: Call) -> Reply:
        if not call.second:
            raise CandrvError(Win32Error.ERROR_INVALID_PARAMETER, "the new value must be in the out buffer")
        call.handle.write_register(call.number, call.second[0], reset_mode=reset_mode)
        return Reply()

    return write


CODES: dict[int, Code] = {
    ControlCode.WRITE_ACCEPTANCE_FILTER: Code(_write_filter, CAN_ACCEPTANCE_FILTER.SIZE, reads=True),
    ControlCode.READ_ACCEPTANCE_FILTER: Code(_read_filter, 0, CAN_ACCEPTANCE_FILTER.SIZE, reads=True),
    ControlCode.SET_BAUDRATE: Code(_set_baudrate, 4),
    ControlCode.GET_BAUDRATE: Code(_get_baudrate, 0, 4),
    ControlCode.SET_BAUDRATE_BY_CONSTANT: Code(_set_baudrate_by_constant, 4),
    ControlCode.GET_BAUDRATE_BY_CONSTANT: Code(_get_baudrate_by_constant, 0, 4),
    ControlCode.SET_CAN_MODE: Code(_set_can_mode, 4),
    ControlCode.SET_DEFAULT_FRAME_FORMAT: Code(_set_format, 4),
    ControlCode.WRITE_TRANSMIT_DATA: Code(_write_transmit_data, CAN_TRANSMIT_DATA.SIZE, writes=True),
    ControlCode.READ_EVENT_DATA: Code(_read_event_data, 0, CAN_EVENT.SIZE, reads=True),
    ControlCode.READ_TIME: Code(_read_time, 0, CAN_TIME.SIZE),
    ControlCode.READ_PROPERTIES: Code(_read_properties, 0, CAN_PROPERTIES.SIZE),
    ControlCode.SET_COMMAND: Code(_set_command, 4, least=1),  # 8.9 passes a BYTE, 8.23 a DWORD
    ControlCode.READ_REGISTER: Code(_register_reader(False), 1, 1),
    ControlCode.WRITE_REGISTER: Code(_register_writer(False), 1),
    ControlCode.READ_REGISTER_RM: Code(_register_reader(True), 1, 1),
    ControlCode.WRITE_REGISTER_RM: Code(_register_writer(True), 1),
    ControlCode.INIT: Code(_init, 0, 4, optional=True),
    ControlCode.TEST_DEVICE: Code(_test_device),
}

READ_BOTH = frozenset({ControlCode.WRITE_REGISTER, ControlCode.WRITE_REGISTER_RM})
"""Codes that also read the out buffer."""


def init_status(error: CanwireError) -> bytes:
    """What IOCTL_CAN_INIT writes into its out buffer when it fails: the Win32 code."""
    return _DWORD.pack(as_candrv(error).code)
