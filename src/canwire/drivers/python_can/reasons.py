"""Why python-can cannot open an adapter: turns its many exceptions into one sentence that says what to do.

Source: python-can 4.6's interfaces: what each raises without its package, driver, adapter or permission.
"""

from __future__ import annotations

import errno
import importlib
import logging
import re
from contextlib import suppress
from typing import Any, NamedTuple

from canwire.drivers.obstacles import absent, busy, denied, is_absent, is_busy, is_denied, text_of
from canwire.drivers.python_can.gs_usb import devices
from canwire.drivers.python_can.port import Port
from canwire.errors import CanwireError, ExtraMissing

_DETECT_S = 3.0
_LISTED = ("socketcan", "pcan", "serial")  # whose channels are found by the names that open them


class Needs(NamedTuple):
    """What an interface needs besides python-can: a package of PyPI, the maker's driver, or both."""

    package: str = ""
    driver: str = ""


NEEDS = {
    "pcan": Needs(driver="PCAN-Basic, peak-system.com"),
    "kvaser": Needs(driver="CANlib, kvaser.com"),
    "ixxat": Needs(driver="VCI V4, hms-networks.com, on Windows"),
    "vector": Needs(driver="XL Driver Library, vector.com, on Windows"),
    "nican": Needs(driver="NI-CAN, ni.com, on Windows"),
    "nixnet": Needs("nixnet", "NI-XNET, ni.com, on Windows"),
    "iscan": Needs(driver="isCAN, thorsis.com, on Windows"),
    "usb2can": Needs("pywin32", "USB2CAN, 8devices.com, on Windows"),
    "systec": Needs(driver="USB-CANmodul, systec-electronic.com, on Windows"),
    "etas": Needs(driver="BOA, etas.com, on Windows"),
    "neousys": Needs(driver="WDT_DIO, neousys-tech.com"),
    "neovi": Needs("python-ics"),
    "canalystii": Needs("canalystii"),
    "cantact": Needs("cantact"),
    "gs_usb": Needs("pyusb", "libusb 1.0"),
    "udp_multicast": Needs("msgpack"),
    "serial": Needs("pyserial"),
    "seeedstudio": Needs("pyserial"),
    "robotell": Needs("pyserial"),
}
_SERIAL = ("serial", "seeedstudio", "robotell")
_NO_DRIVER = (
    "library not found",
    "driver could not be loaded",
    "could not load",
    "driver missing",
    "could not be loaded",
    "only supported on windows",
    "no backend available",
    "not loaded",
    "has no attribute 'windll'",
    "cannot import name 'hresult'",
)


def reason(port: Port, error: Exception) -> str:
    """One sentence; python-can's own message comes last, in parentheses, if it says more."""
    if isinstance(error, CanwireError):
        return str(error)
    said, found = text_of(error), _cause(port, error)
    return f"{found} ({said})" if found else f"{port.interface} cannot be opened: {said}"


def _cause(port: Port, error: Exception) -> str:
    said, needs = text_of(error), NEEDS.get(port.interface, Needs())
    name = f"{port.interface}/{port.channel or ''}"
    if isinstance(error, NotImplementedError) and "not supported" in said:
        return absent(f"interface {port.interface!r} in python-can", known_interfaces(), port.interface)
    if _no_module(said):
        way = f"pip install {needs.package}" if needs.package else "install the package that it names"
        return f"python-can's {port.interface} needs a package that is not installed: {way}"
    if isinstance(error, NameError) or any(word in said.lower() for word in _NO_DRIVER):
        driver = needs.driver or "its maker provides it"
        return f"the driver that python-can's {port.interface} needs is not installed: {driver}"
    if isinstance(error, TypeError) and (missing := re.findall(r"'(\w+)'", said.partition("missing")[2])):
        return f"give it its arguments: {name}?{'&'.join(f'{one}=...' for one in missing)}"
    if isinstance(error, OSError) and error.errno == errno.EAFNOSUPPORT:
        return "this machine's kernel has no CAN sockets: load its module (modprobe can_raw)"
    if is_denied(error):
        return denied(name, usb=port.interface not in _SERIAL)
    if is_busy(error):
        return busy(name)
    if is_absent(error):
        return absent(name, (f"{port.interface}/{one}" for one in detected(port.interface)))
    return ""


def _no_module(said: str) -> bool:
    return any(word in said for word in ("No module named", "module is not installed", "Please install"))


def known_interfaces() -> list[str]:
    """python-can's own interfaces and those of packages that add some; raises ExtraMissing."""
    try:
        from can.interfaces import BACKENDS
    except ModuleNotFoundError:
        raise ExtraMissing("python-can", "hardware") from None
    return sorted(BACKENDS)


def detected(interface: str) -> list[str]:
    """The channels that python-can finds for this interface; empty if it cannot search for them."""
    if interface == "gs_usb":
        return [name.removeprefix("gs_usb/") for name in devices.names_of(devices.find_devices())]
    return [str(one.get("channel", "")) for one in detected_configs([interface])]


def detected_configs(interfaces: list[str]) -> list[dict[str, Any]]:
    """What python-can's `detect_available_configs` finds; an interface whose search fails has none."""
    found: list[dict[str, Any]] = []
    import can

    silence()
    for interface in interfaces:
        with suppress(Exception):  # somebody else's code: anything may come
            found += [dict(one) for one in can.detect_available_configs([interface], timeout=_DETECT_S)]
    return found


def missing(port: Port) -> str:
    """An obstacle that shows before the port is opened: no such interface, package, driver or channel; "" if none."""
    try:
        if port.interface == "gs_usb":
            devices.chosen(devices.find_devices(), port.channel or "")
        elif port.interface not in known_interfaces():
            raise NotImplementedError(f"CAN interface {port.interface!r} not supported")
        else:
            _load(port.interface)
    except Exception as error:  # somebody else's code: anything may come
        return reason(port, error)
    there = detected(port.interface) if port.interface in _LISTED and port.channel else []
    if there and port.channel not in there:
        return absent(f"{port.interface}/{port.channel}", (f"{port.interface}/{one}" for one in there))
    return ""


def _load(interface: str) -> None:
    from can.interfaces import BACKENDS

    importlib.import_module(BACKENDS[interface][0])


def silence() -> None:
    """Silence python-can's warnings of what is missing, which repeat with each attempt: the hub reports it once."""
    logger = logging.getLogger("can")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
