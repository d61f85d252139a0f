"""The adapters on this machine's USB: found, and one of them chosen by its number or its serial number."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from canwire.drivers.obstacles import absent
from canwire.drivers.python_can.gs_usb.protocol import IDS


def find_devices() -> list[Any]:
    """pyusb's devices, by their places on the bus; raises ModuleNotFoundError without pyusb, its own without libusb."""
    import usb.core  # type: ignore[import-not-found]

    found = usb.core.find(find_all=True, custom_match=lambda one: (one.idVendor, one.idProduct) in IDS)
    return sorted(found, key=lambda one: (one.bus or 0, one.address or 0))


def release(device: Any) -> None:
    """Give it back to the system, so that other programs may have it."""
    import usb.util  # type: ignore[import-not-found]

    usb.util.dispose_resources(device)


def serial_of(device: Any) -> str:
    """Its serial number, "" where the system does not let us ask for it."""
    with suppress(OSError, ValueError):  # pyusb: no permission, or no languages
        return str(device.serial_number or "")
    return ""


def name_of(device: Any) -> str:
    """For people: its product's name."""
    with suppress(OSError, ValueError):
        return str(device.product or "")
    return ""


def chosen(devices: Sequence[Any], channel: str) -> Any:
    """The one with this serial number, or of this number from 0; raises FileNotFoundError naming those there are."""
    for device in devices:
        if channel and serial_of(device) == channel:
            return device
    if channel.isdecimal() and int(channel) < len(devices):
        return devices[int(channel)]
    if not channel and devices:
        return devices[0]
    raise FileNotFoundError(absent(f"gs_usb/{channel}", names_of(devices)))


def names_of(devices: Sequence[Any]) -> list[str]:
    """What each goes by: its serial number, or else its number."""
    return [f"gs_usb/{serial_of(device) or number}" for number, device in enumerate(devices)]
