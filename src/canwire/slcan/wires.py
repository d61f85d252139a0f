"""The wire between a dongle and its host: a pseudo terminal, a serial port, or TCP (tcp_wire.py). No wire blocks.

A wire without a host accepts no bytes and returns none; it may have to `look` for a host periodically.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys
from pathlib import Path
from typing import Any, Protocol

from canwire import BadValue, ExtraMissing, InUse, Unsupported

if sys.platform != "win32":
    import fcntl
    import termios
    import tty

CHUNK = 4096
_LOOK_S = 0.05  # for a client that opens the pseudo terminal
_REOPEN_S = 0.5  # a serial port that went away


class Wire(Protocol):
    """`name` is the address for hosts. `read` returns b"" if no bytes wait; `write` returns how many bytes were
    written, 0 if there is no room. Both notice that the host has gone: `connected` is then False."""

    name: str

    @property
    def look_s(self) -> float | None:
        """Seconds until `look` is to be called; None: its descriptors say when there is something."""

    @property
    def connected(self) -> bool: ...

    def descriptors(self) -> tuple[int, ...]:
        """The descriptors to wait on for reading."""

    def writing(self) -> int:
        """The descriptor to wait on for writing while a host is connected."""

    def look(self) -> None:
        """Find out whether a host has connected, and whether one has been silent for too long."""

    def read(self) -> bytes: ...
    def write(self, data: bytes | bytearray | memoryview) -> int: ...
    def close(self) -> None: ...


class PtyWire:
    """A pseudo terminal with a symbolic link to it. Clients may open and close it; each finds it raw and empty.

    A lock file beside the link reserves the link for this wire; the lock ends with the process in any case. Raises
    InUse if another wire has the link, BadValue if the path exists and is no symbolic link.
    """

    def __init__(self, link: str | os.PathLike[str]) -> None:
        if sys.platform == "win32":
            raise Unsupported("Windows has no pseudo terminals; use --tcp")
        self.link = Path(link).expanduser()
        self.link.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if self.link.exists() and not self.link.is_symlink():
            raise BadValue(f"{self.link}: the path exists and is no symbolic link; choose another one")
        self._lock = _locked(self.link.with_name(f".{self.link.name}.lock"), self.link)
        self._master, slave = os.openpty()
        self.terminal = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._closed = self.connected = False
        self._clean()
        self._make_link()
        self.name = str(self.link)

    @property
    def look_s(self) -> float | None:
        return None if self.connected else _LOOK_S

    def descriptors(self) -> tuple[int, ...]:
        return (self._master,) if self.connected else ()

    def writing(self) -> int:
        return self._master

    def look(self) -> None:
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        events = poll.poll(0)
        state = events[0][1] if events else 0
        self.connected = bool(state & select.POLLIN) or not state & select.POLLHUP

    def read(self) -> bytes:
        try:
            return os.read(self._master, CHUNK)
        except BlockingIOError:
            return b""
        except OSError:  # EIO: the last client has closed it
            self._hung_up()
            return b""

    def write(self, data: bytes | bytearray | memoryview) -> int:
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0
        except OSError:
            self._hung_up()
            return 0

    def close(self) -> None:
        """Close the pseudo terminal and remove the link; a second call has no effect."""
        if not self._closed:
            self._closed = True
            self.connected = False
            with contextlib.suppress(OSError):
                if os.readlink(self.link) == self.terminal:
                    self.link.unlink()
            os.close(self._master)
            os.close(self._lock)

    def _hung_up(self) -> None:
        self.connected = False
        self._clean()

    def _clean(self) -> None:
        """Reset the terminal: remove the settings of the last client and the bytes that it did not read."""
        slave = os.open(self.terminal, os.O_RDWR | os.O_NOCTTY)
        try:
            tty.setraw(slave, termios.TCSANOW)
            termios.tcflush(slave, termios.TCIFLUSH)
        finally:
            os.close(slave)

    def _make_link(self) -> None:
        new = self.link.with_name(f".{self.link.name}.new")
        with contextlib.suppress(FileNotFoundError):
            new.unlink()
        new.symlink_to(self.terminal)
        new.replace(self.link)


def _locked(path: Path, link: Path) -> int:
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise InUse(f"{link}: another dongle is served there") from None
    return descriptor


class SerialWire:
    """A serial port with the host at its other end; opened again when the port was gone and is back. Needs pyserial."""

    def __init__(self, device: str, baud_rate: int = 115_200) -> None:
        try:
            import serial  # type: ignore[import-untyped]
        except ModuleNotFoundError:
            raise ExtraMissing("pyserial", "hardware") from None
        if sys.platform == "win32":
            raise Unsupported("a dongle on a serial port is not supported on Windows; use --tcp")
        self.name = device
        self._baud_rate = baud_rate
        self._serial: Any = serial
        self._port: Any = None
        self._open()

    @property
    def look_s(self) -> float | None:
        return None if self.connected else _REOPEN_S

    @property
    def connected(self) -> bool:
        return self._port is not None

    def descriptors(self) -> tuple[int, ...]:
        return () if self._port is None else (self._port.fileno(),)

    def writing(self) -> int:
        return -1 if self._port is None else int(self._port.fileno())

    def look(self) -> None:
        with contextlib.suppress(OSError):
            self._open()

    def read(self) -> bytes:
        try:
            return b"" if self._port is None else os.read(self._port.fileno(), CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            self.close()
            return b""

    def write(self, data: bytes | bytearray | memoryview) -> int:
        try:
            return 0 if self._port is None else os.write(self._port.fileno(), data)
        except BlockingIOError:
            return 0
        except OSError:
            self.close()
            return 0

    def close(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            with contextlib.suppress(OSError):
                port.close()

    def _open(self) -> None:
        self._port = self._serial.Serial(self.name, self._baud_rate, timeout=0, exclusive=True)
