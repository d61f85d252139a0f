"""The CAN port of the main window: a handle that only queries the device, and uses no virtual channel of it.

Source: CANDRV manual, 10.4, main dialog.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire import candrv
from canwire.candrv import CanMode, Command, FrameFormat
from canwire.candrv.errors import translated

if TYPE_CHECKING:
    from canwire import Hub


@dataclass(frozen=True)
class Shown:
    """The values of the main window: the present state of the device, even if another program set
    it. `rates` in bit/s."""

    port: str
    rate: int
    mode: int
    format: int
    rates: tuple[int, ...]
    commands: tuple[tuple[int, str], ...]
    lowest: int
    highest: int
    driver: str


class Port:
    """An open port. Its methods raise CandrvError; a setting that is refused leaves the device unchanged."""

    def __init__(self, hub: Hub, name: str) -> None:
        self._handle = candrv.open(name, read=False, write=False, hub=hub)

    @property
    def name(self) -> str:
        return self._handle.name

    @property
    def align(self) -> int:
        """The setting Align with which the driver was loaded."""
        return self._handle.device.settings.align

    @property
    def extended(self) -> bool:
        """Whether the device is in CAN2.0B."""
        return self._handle.can_mode == CanMode.CAN_2_0_B

    def shown(self) -> Shown:
        """Read the values from the device: another program may have changed them, and commands depend on the mode."""
        handle = self._handle
        with translated(opened=True):
            state = handle.device.state()
        properties = handle.properties()
        return Shown(
            handle.name,
            state.rate,
            int(state.mode),
            int(state.format),
            tuple(properties.baudrates[: properties.nBaudrates]),
            tuple((one, Command(one).name) for one in properties.commands[: properties.nCommands]),
            properties.min,
            properties.max,
            properties.device_name,
        )

    def set_rate(self, rate: int) -> None:
        """Set the bit rate in bit/s."""
        self._handle.baud_rate = rate

    def set_mode(self, mode: int) -> None:
        self._handle.can_mode = CanMode(mode)

    def set_format(self, format: int) -> None:
        self._handle.frame_format = FrameFormat(format)

    def command(self, number: int) -> None:
        """Execute one of the special commands."""
        self._handle.command(number)

    def close(self) -> None:
        """Close the handle; a second call does nothing."""
        self._handle.close()
