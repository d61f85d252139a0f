"""Finds the gs_usb adapters on this machine's USB, and chooses one by its number or its serial number."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from canwire.drivers.obstacles import absent
from canwire.drivers.python_can.gs_usb.protocol import IDS


def find_devices() -> list[Any]:
    """pyusb's devices by USB address; raises ModuleNotFoundError without pyusb, pyusb's own error without libusb."""
    import usb.core  # type: ignore[import-not-found]

    found = usb.core.find(find_all=True, custom_match=lambda one: (one.idVendor, one.idProduct) in IDS)
    return sorted(found, key=lambda one: (one.bus or 0, one.address or 0))


def release(device: Any) -> None:
    """Release a device, so that other programs can open it."""
    import usb.util  # type: ignore[import-not-found]

    usb.util.dispose_resources(device)


def serial_of(device: Any) -> str:
    """The serial number of a device, "" if the system does not permit to read it."""
    with suppress(OSError, ValueError):  # pyusb: no permission, or no languages
        return str(device.serial_number or "")
    return ""


def name_of(device: Any) -> str:
    """The product name of a device, for display."""
    with suppress(OSError, ValueError):
        return str(device.product or "")
    return ""


def chosen(devices: Sequence[Any], channel: str) -> Any:
    """The device with this serial number or index (from 0); raises FileNotFoundError that names all devices."""
    for device in devices:
        if channel and serial_of(device) == channel:
            return device
    if channel.isdecimal() and int(channel) < len(devices):
        return devices[int(channel)]
    if not channel and devices:
        return devices[0]
    raise FileNotFoundError(absent(f"gs_usb/{channel}", names_of(devices)))


def names_of(devices: Sequence[Any]) -> list[str]:
    """The name of each device: its serial number, or its index if it has none."""
    return [f"gs_usb/{serial_of(device) or number}" for number, device in enumerate(devices)]
