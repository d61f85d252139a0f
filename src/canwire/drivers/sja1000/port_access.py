"""The registers of a real INduCAN104, through Linux's /dev/port; used only if a configuration selects it.

No interrupt reaches a program this way, so the driver polls the registers.
Source: port(4); INduCAN104 manual ("PC/104 board address").
"""

from __future__ import annotations

import os
import weakref
from typing import NoReturn

from canwire.errors import Closed, NoSuchBoard, Unsupported
from canwire.values.isa_address import REGISTERS, checked_byte, port_of, port_text

PATH = "/dev/port"
_INSTEAD = 'leave access = "port" out of canwire.toml to simulate the board'
_CDR = 31  # the clock divider: in both modes at that address
_CDR_OUTPUT = 0x07  # CLKOUT's divisor can always be written; the board uses CLKOUT for nothing
_CDR_ZERO = 0x10  # reads 0


class PortAccess:
    """read(address) and write(address, value) of an SJA1000's registers, 0..127, at a base address.

    The constructor opens `path`. It raises NoSuchBoard if the device does not exist, Unsupported if this process may
    not use it, BadValue for a base address that no board can have.
    """

    def __init__(self, base: int, path: str = PATH) -> None:
        self._ports = tuple(port_of(register, base) for register in range(REGISTERS))
        self._path = path
        if not hasattr(os, "pread"):
            raise NoSuchBoard(f"{path}: this system has no port device; {_INSTEAD}")
        try:
            self._descriptor = os.open(path, os.O_RDWR)
        except OSError as error:
            self._refuse(error)
        self._close = weakref.finalize(self, os.close, self._descriptor)

    def read(self, address: int) -> int:
        """Read one register; raises NoSuchBoard if the device ends before it, and Closed."""
        port = self._port(address)
        try:
            found = os.pread(self._descriptor, 1, port)
        except OSError as error:
            self._refuse(error)
        if not found:
            raise NoSuchBoard(f"{self._path}: it ends before port {port_text(port)}; it is no port device")
        return found[0]

    def write(self, address: int, value: int) -> None:
        """Write one register; raises BadValue for a value outside 0..255, and Closed."""
        port = self._port(address)
        block = bytes((checked_byte(value, port),))
        try:
            os.pwrite(self._descriptor, block, port)
        except OSError as error:
            self._refuse(error)

    def answers(self) -> bool:
        """True if an SJA1000 answers: its clock divider keeps a written value. No other register is touched."""
        before = self.read(_CDR)
        if before & _CDR_ZERO:  # 0xFF: an empty port
            return False
        try:
            return all(self._keeps(before ^ pattern) for pattern in (_CDR_OUTPUT, 0x05, 0x02))
        finally:
            self.write(_CDR, before)

    def close(self) -> None:
        """Close the device; a second call has no effect."""
        self._close()

    def _keeps(self, value: int) -> bool:
        self.write(_CDR, value)
        return self.read(_CDR) == value

    def _port(self, address: int) -> int:
        if not self._close.alive:
            raise Closed(f"{self._path} at {port_text(self._ports[0])}")
        return self._ports[address & REGISTERS - 1]

    def _refuse(self, error: OSError) -> NoReturn:
        if isinstance(error, FileNotFoundError):
            why = "there is no such device; ports need Linux on a PC"
            raise NoSuchBoard(f"{self._path}: {why}, or {_INSTEAD}") from None
        if isinstance(error, PermissionError):
            why = "it takes root with CAP_SYS_RAWIO, and a kernel that is not locked down"
            raise Unsupported(f"{self._path}: no rights to use ports: {why}; or {_INSTEAD}") from None
        raise Unsupported(f"{self._path} is no port device: {error.strerror}; or {_INSTEAD}") from None
