"""What a handle of any access may ask and tell its device. All of it holds for every program that has it open.

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
    """Every failure is a CandrvError with Win32's code."""

    device: Device

    def check(self) -> None:
        """Raises ERROR_INVALID_HANDLE once it is closed."""
        raise NotImplementedError

    def abort(self) -> int:
        """CANBUS_CMD_ABORT_TRANSMISSION; how many messages were given up."""
        raise NotImplementedError

    @property
    def baud_rate(self) -> int:
        """bit/s. Setting it raises ERROR_INVALID_PARAMETER for a rate that the controller cannot make."""
        return self._tell(lambda device: device.state().rate)

    @baud_rate.setter
    def baud_rate(self, rate: int) -> None:
        self._tell(lambda device: device.change(rate=rate))

    @property
    def baud_rate_constant(self) -> int:
        """The rate by its index in the properties' table, 0xFFFFFFFF for one that is not there; raises alike."""
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
        """The format of messages that have none of their own."""
        return FrameFormat(self._tell(lambda device: device.state().format))

    @frame_format.setter
    def frame_format(self, format: int) -> None:
        self._tell(lambda device: device.change(format=format))

    @property
    def virtualize(self) -> bool:
        """Whether handles on this board receive what others on it send."""
        return self._tell(lambda device: device.virtualize)

    def command(self, number: int) -> None:
        """IOCTL_CAN_SET_COMMAND: a Command that the properties list."""
        self._tell(lambda device: self._command(device, number))

    def time(self) -> int:
        """CAN time now, in ms."""
        return self._tell(lambda device: device.time_ms())

    def properties(self) -> CAN_PROPERTIES:
        """What driver and controller can in the CAN mode of now."""
        return self._tell(lambda device: device.controller.properties(device.state().mode))

    def initialise(self) -> None:
        """IOCTL_CAN_INIT: set the controller up with its settings once more, as after a bus-off."""
        self._tell(lambda device: device.initialise())

    def in_configuration_mode(self) -> bool:
        """IOCTL_CAN_TEST_DEVICE."""
        return self._tell(lambda device: device.in_configuration_mode())

    def read_register(self, address: int, *, reset_mode: bool = False) -> int:
        """A register of the controller; in `reset_mode` as IOCTL_CAN_READ_REGISTER_RM does."""
        return self._tell(lambda device: device.read_register(address, reset_mode=reset_mode))

    def write_register(self, address: int, value: int, *, reset_mode: bool = False) -> None:
        """Write one, with whatever that does to the driver."""
        self._tell(lambda device: device.write_register(address, value, reset_mode=reset_mode))

    def _command(self, device: Device, number: int) -> None:
        command = device.controller.command(number)
        device.debug(f"command {command.name}")
        if command == Command.ABORT_TRANSMISSION:
            self.abort()
        else:
            COMMANDS[command](device)

    def _tell(self, call: Callable[[Device], T]) -> T:
        """The board was there when the handle was opened: where the hub does not know it any more, it was pulled."""
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
"""Those about the device; ABORT_TRANSMISSION is about a handle."""
