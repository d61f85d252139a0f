"""The real adapters of this machine: those that python-can and pyserial find, each with the text that shares it."""

from __future__ import annotations

from contextlib import suppress
from importlib.util import find_spec
from urllib.parse import quote

from canwire.drivers.python_can.gs_usb import devices
from canwire.drivers.python_can.reasons import detected_configs, known_interfaces
from canwire.drivers.slcan_dongle.ports import described_ports
from canwire.errors import CanwireError, ExtraMissing
from canwire.values.frozen import dataclass

# our own driver finds gs_usb adapters, pyserial the serial ports; the others are no adapters, or need no search
_LEFT_OUT = {"virtual", "udp_multicast", "canwire", "gs_usb", "serial", "slcan", "seeedstudio", "robotell"}


@dataclass(frozen=True, slots=True)
class FoundAdapter:
    """One adapter: `canwire share` and `Hub.plug` accept `spec`; `description` names the adapter."""

    spec: str
    description: str


def find_adapters() -> list[FoundAdapter]:
    """All adapters that are found, serial ports included; the search may take seconds.

    Raises ExtraMissing if neither library is installed, CanwireError if the system cannot list its serial ports.
    """
    found = [*_serial(), *_usb(), *_of_python_can()]
    if not found and find_spec("serial") is None and find_spec("can") is None:
        raise ExtraMissing("pyserial", "hardware")
    return found


def _serial() -> list[FoundAdapter]:
    if find_spec("serial") is None:
        return []
    try:
        ports = described_ports()
    except OSError as error:
        raise CanwireError(str(error)) from error
    return [
        FoundAdapter(f"?serial={quote(number)}" if number else device, f"{device}, {description}")
        for device, number, description in ports
    ]


def _usb() -> list[FoundAdapter]:
    with suppress(Exception):  # no pyusb, no libusb, or no right to look
        there = devices.find_devices()
        return [
            FoundAdapter(f"python-can:{name}", devices.name_of(device) or "gs_usb")
            for name, device in zip(devices.names_of(there), there, strict=True)
        ]
    return []


def _of_python_can() -> list[FoundAdapter]:
    if find_spec("can") is None:
        return []
    wanted = [name for name in known_interfaces() if name not in _LEFT_OUT]
    return [
        FoundAdapter(
            f"python-can:{one['interface']}/{quote(str(one.get('channel', '')))}",
            str(one.get("device_name") or one.get("name") or one["interface"]),
        )
        for one in detected_configs(wanted)
    ]
