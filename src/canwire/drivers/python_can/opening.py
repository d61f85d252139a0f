"""Opens python-can's bus, or canwire's own driver in its place, with the settings of a line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from canwire.drivers.python_can.backends import PASSIVE, backend
from canwire.drivers.python_can.gs_usb import devices
from canwire.drivers.python_can.gs_usb.bus import GsUsbBus, Opening
from canwire.drivers.python_can.port import Port
from canwire.drivers.python_can.reasons import silence
from canwire.errors import BadValue, ExtraMissing
from canwire.values.checks import whole
from canwire.values.timing.bit_timing import BitTiming


@dataclass(frozen=True, slots=True)
class Setup:
    """The settings to open the bus with."""

    timing: BitTiming
    data_timing: BitTiming | None
    listen_only: bool


def open_bus(port: Port, setup: Setup) -> Any:
    """can.Bus with the settings of the line; raises what can.Bus raises, ExtraMissing without python-can."""
    if port.interface == "gs_usb":
        return open_gs_usb(port, setup)
    can = load_can()
    known = backend(port.interface)
    arguments: dict[str, Any] = {"bitrate": setup.timing.bit_rate}
    if setup.data_timing is not None:
        arguments.update(known.fd or {})
        if known.timing:
            arguments["timing"] = _timing(can, setup.timing, setup.data_timing)
            del arguments["bitrate"]
        else:
            arguments["data_bitrate"] = setup.data_timing.bit_rate
    if setup.listen_only:
        arguments.update(known.listen_only or {})
    arguments = {
        name: can.BusState.PASSIVE if value == PASSIVE else value for name, value in arguments.items()
    }
    arguments.update(port.options)
    return can.Bus(channel=port.channel, interface=port.interface, ignore_config=True, **arguments)


def load_can() -> Any:
    """The module `can`; raises ExtraMissing, which names the extra to install."""
    try:
        import can
    except ModuleNotFoundError:
        raise ExtraMissing("python-can", "hardware") from None
    silence()
    return can


def open_gs_usb(port: Port, setup: Setup) -> GsUsbBus:
    """canwire's own driver, with the options `port` and `detach`; raises OSError, Unsupported, BadValue, BadTiming."""
    if unknown := sorted(set(port.options) - {"port", "detach"}):
        raise BadValue(f"{port.text}: gs_usb has no option {unknown[0]!r}, but port=NUMBER and detach=true")
    opening = Opening(
        setup.timing,
        setup.data_timing,
        setup.listen_only,
        whole("port", port.options.get("port", 0), 0, 255),
        bool(port.options.get("detach", False)),
    )
    return GsUsbBus(devices.chosen(devices.find_devices(), port.channel or ""), opening)


def _timing(can: Any, nominal: BitTiming, data: BitTiming) -> Any:
    return can.BitTimingFd(
        f_clock=nominal.clock_hz,
        nom_brp=nominal.prescaler,
        nom_tseg1=nominal.tseg1,
        nom_tseg2=nominal.tseg2,
        nom_sjw=nominal.sjw,
        data_brp=data.prescaler,
        data_tseg1=data.tseg1,
        data_tseg2=data.tseg2,
        data_sjw=data.sjw,
    )
