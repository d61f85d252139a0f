"""Opens and lists ports: serial ports by pyserial, TCP bridges by a socket."""

from __future__ import annotations

import os
import socket
import sys
from typing import Any

from canwire.drivers.obstacles import absent, busy, denied, is_absent, is_busy, is_denied, text_of
from canwire.errors import ExtraMissing

CONNECT_S = 5.0
_POLL_S = 0.1


def open_port(where: str, baudrate: int) -> Any:
    """A socket, or a port of pyserial; raises OSError or ValueError, ExtraMissing without pyserial."""
    if where.startswith("socket://") and sys.platform != "win32":
        host, _, number = where.removeprefix("socket://").rstrip("/").rpartition(":")
        connection = socket.create_connection((host.strip("[]"), int(number)), CONNECT_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setblocking(False)
        return connection
    serial = load_serial()
    source = serial.serial_for_url(where, baudrate, timeout=_POLL_S, do_not_open=True)
    if hasattr(source, "exclusive") and sys.platform != "win32":
        source.exclusive = True
    source.open()
    if watchable(source):
        os.set_blocking(source.fileno(), False)
    return source


def watchable(source: Any) -> bool:
    """True if the hub's poller can wait for this port."""
    if sys.platform == "win32":
        return False
    try:
        return isinstance(source.fileno(), int)
    except Exception:  # pyserial's other ports have none, or say so in one way or another
        return False


def listed_ports() -> list[tuple[str, str]]:
    """Serial ports of this machine and their USB serial numbers; raises ExtraMissing or OSError."""
    return [(device, number) for device, number, _ in described_ports()]


def described_ports() -> list[tuple[str, str, str]]:
    """Device, USB serial number and description of each serial port; raises ExtraMissing.

    Raises OSError if they cannot be listed: pyserial's search calls functions of Windows that Wine 8 lacks.
    """
    load_serial()
    try:
        from serial.tools import list_ports  # type: ignore[import-untyped]
    except AttributeError as error:
        raise OSError(
            f"serial ports cannot be listed here: this Windows lacks a function that pyserial calls ({error}); "
            "name the port, as in `canwire share COM3`"
        ) from error
    return [(port.device, port.serial_number or "", port.description or "") for port in list_ports.comports()]


def usb_serial_of(where: str) -> str:
    """The USB serial number of a port, "" if the system does not know it."""
    if "://" in where:
        return ""
    try:
        return next((number for device, number in listed_ports() if device == where), "")
    except (ExtraMissing, OSError):
        return ""


def reason(where: str, error: Exception) -> str:
    """Why this port cannot be opened, in a sentence that says what to do; the library's own words come last."""
    found = ""
    if is_denied(error):
        found = denied(where, usb=False)
    elif is_busy(error):
        found = busy(where)
    elif is_absent(error):
        found = absent(f"port {where}", (device for device, _ in listed_ports()))
    return f"{found} ({text_of(error)})" if found else f"{where} cannot be opened: {text_of(error)}"


def load_serial() -> Any:
    """The module `serial`; raises ExtraMissing, which names the extra to install."""
    try:
        import serial  # type: ignore[import-untyped]
    except ModuleNotFoundError:
        raise ExtraMissing("pyserial", "hardware") from None
    return serial
