"""The controls of a device that a handle of any access offers. Settings apply to all programs with the device open.

Source: CANDRV manual, 8.13 to 8.18, 8.21 to 8.29.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from canwire.candrv.constants import CanMode, Command, FrameFormat
from canwire.candrv.errors import translated

if TYPE_CHECKING:
    from canwire.candrv.device.device import Device
    from canwire.candrv.structures import CAN_PROPERTIES

T = TypeVar("T")


class Controls:
    """The settings and commands of a device. Each failure raises a CandrvError with a Win32 code."""

    device: Device

    def check(self) -> None:
        """Raises ERROR_INVALID_HANDLE once the handle is closed."""
        raise NotImplementedError

    def abort(self) -> int:
        """CANBUS_CMD_ABORT_TRANSMISSION; returns how many messages were aborted."""
        raise NotImplementedError

    @property
    def baud_rate(self) -> int:
        """The bit rate in bit/s. Setting it raises ERROR_INVALID_PARAMETER if the controller cannot make that rate."""
        return self._tell(lambda device: device.state().rate)

    @baud_rate.setter
    def baud_rate(self, rate: int) -> None:
        self._tell(lambda device: device.change(rate=rate))

    @property
    def baud_rate_constant(self) -> int:
        """The index of the bit rate in the table of the properties, 0xFFFFFFFF for another rate.

        Setting it raises ERROR_INVALID_PARAMETER for an index outside the table.
        """
        return self._tell(lambda device: device.controller.index_of_rate(device.state().rate))

    @baud_rate_constant.setter
    def baud_rate_constant(self, index: int) -> None:
        self._tell(lambda device: device.change(rate=device.controller.rate_of_index(index)))

    @property
    def can_mode(self) -> CanMode:
        """CAN2.0A or CAN2.0B."""
        return CanMode(self._tell(lambda device: device.state().mode))

    @can_mode.setter
    def can_mode(self, mode: int) -> None:
        self._tell(lambda device: device.change(mode=mode))

    @property
    def frame_format(self) -> FrameFormat:
        """The format of messages that are sent with FrameFormat.DEFAULT."""
        return FrameFormat(self._tell(lambda device: device.state().format))

    @frame_format.setter
    def frame_format(self, format: int) -> None:
        self._tell(lambda device: device.change(format=format))

    @property
    def virtualize(self) -> bool:
        """Whether handles on this board receive what other handles on it send."""
        return self._tell(lambda device: device.virtualize)

    def command(self, number: int) -> None:
        """IOCTL_CAN_SET_COMMAND: execute a Command that the properties list."""
        self._tell(lambda device: self._command(device, number))

    def time(self) -> int:
        """The present CAN time in ms."""
        return self._tell(lambda device: device.time_ms())

    def properties(self) -> CAN_PROPERTIES:
        """The properties of driver and controller in the present CAN mode."""
        return self._tell(lambda device: device.controller.properties(device.state().mode))

    def initialise(self) -> None:
        """IOCTL_CAN_INIT: configure the controller with its settings again, for example after a bus-off."""
        self._tell(lambda device: device.initialise())

    def in_configuration_mode(self) -> bool:
        """Whether the controller is in its configuration mode (IOCTL_CAN_TEST_DEVICE)."""
        return self._tell(lambda device: device.in_configuration_mode())

    def read_register(self, address: int, *, reset_mode: bool = False) -> int:
        """Read a register of the controller; with `reset_mode` in reset mode, as IOCTL_CAN_READ_REGISTER_RM does."""
        return self._tell(lambda device: device.read_register(address, reset_mode=reset_mode))

    def write_register(self, address: int, value: int, *, reset_mode: bool = False) -> None:
        """Write a register of the controller; the driver does not check what effect that has."""
        self._tell(lambda device: device.write_register(address, value, reset_mode=reset_mode))

    def _command(self, device: Device, number: int) -> None:
        command = device.controller.command(number)
        device.debug(f"command {command.name}")
        if command == Command.ABORT_TRANSMISSION:
            self.abort()
        else:
            COMMANDS[command](device)

    def _tell(self, call: Callable[[Device], T]) -> T:
        """Run `call`; a board that the hub no longer has was removed, since it was present when the handle opened."""
        self.check()
        with translated(opened=True):
            return call(self.device)


def _virtualize(device: Device, on: bool) -> None:
    device.virtualize = on


COMMANDS: dict[Command, Callable[[Device], object]] = {
    Command.ENTER_STANDBY: lambda device: device.sleep(True),
    Command.LEAVE_STANDBY: lambda device: device.sleep(False),
    Command.CLEAR_OVERRUN: lambda device: device.clear_overrun(),
    Command.SELF_RECEPTION_REQUEST: lambda device: device.change(loop_back=True),
    Command.LISTEN_ON: lambda device: device.change(listen=True),
    Command.LISTEN_OFF: lambda device: device.change(listen=False),
    Command.VIRTUALIZE_ON: lambda device: _virtualize(device, True),
    Command.VIRTUALIZE_OFF: lambda device: _virtualize(device, False),
}
"""The commands for the device; ABORT_TRANSMISSION is for a handle."""
