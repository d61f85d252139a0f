"""VciServer, IVciDeviceManager and IVciDeviceList: where everything starts.

Source: VCI V3 .NET manual 2.1 and 2.2; reference/vci.md section 7a.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

from canwire.vci import device, server
from canwire.vci.structures.errors import VCI_E_INVALID_STATE, VciNoMoreItems, VciNoSuchDevice, format_error
from canwire.vci.v3.device import VciDevice
from canwire.vci.v3.disposable import Disposable, net_call
from canwire.vci.v3.errors import InvalidOperationException, exceptions

if TYPE_CHECKING:
    from canwire import Event
    from canwire.vci.structures.devices import VciDeviceInfo


class VciServer:
    """VciServer: there is one.

    Its boards are those of `vci.initialize`, of the usual hub if nobody called that.
    """

    _instance: ClassVar[VciServer | None] = None

    @classmethod
    def instance(cls) -> VciServer:
        """Instance."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    @staticmethod
    def get_device_manager() -> VciDeviceManager:
        """GetDeviceManager. Raises VciException with VCI_E_DISCONNECTED if there is no hub."""
        with exceptions():
            server.initialize()
            return VciDeviceManager(server.get_device_manager())

    @property
    def device_manager(self) -> VciDeviceManager:
        """DeviceManager: the same."""
        return self.get_device_manager()

    @staticmethod
    def get_error_msg(code: int) -> str:
        """GetErrorMsg: name, number and meaning of a result code; raises ArgumentException if it is no 32 bits."""
        with exceptions():
            return format_error(code)


class VciDeviceManager(Disposable):
    """IVciDeviceManager."""

    def __init__(self, manager: device.VciDeviceManager) -> None:
        """For VciServer."""
        super().__init__()
        self._manager = self._hold(manager)

    @net_call
    def get_device_list(self) -> VciDeviceList:
        """GetDeviceList."""
        return VciDeviceList(self._manager)


class VciDeviceList(Disposable):
    """IVciDeviceList: the boards that are plugged in; each `iter` goes through them by itself."""

    def __init__(self, manager: device.VciDeviceManager) -> None:
        """For IVciDeviceManager."""
        super().__init__()
        manager.add_ref()
        self._manager = self._hold(manager)
        self._changes = self._hold(manager.enum_devices())

    @net_call
    def get_enumerator(self) -> VciDeviceEnumerator:
        """GetEnumerator: one of its own for every call."""
        return VciDeviceEnumerator(self._manager)

    @net_call
    def assign_event(self, event: Event | None) -> None:
        """AssignEvent: signal this event at every change of the list, in place of one before; None: no event."""
        self._changes.assign_event(event)

    def __iter__(self) -> Iterator[VciDevice]:
        with self.get_enumerator() as enumerator:
            while enumerator.move_next():
                yield enumerator.current


class VciDeviceEnumerator(Disposable):
    """IEnumerator over boards; it stands before the first one."""

    def __init__(self, manager: device.VciDeviceManager) -> None:
        """For IVciDeviceList."""
        super().__init__()
        manager.add_ref()
        self._manager = self._hold(manager)
        self._devices = self._hold(manager.enum_devices())
        self._found: tuple[device.VciDevice, VciDeviceInfo] | None = None

    @net_call
    def move_next(self) -> bool:
        """MoveNext: go to the next board; False at the end."""
        self._found = None
        while self._found is None:
            try:
                info = self._devices.next(1)[0]
                self._found = self._manager.open_device(info.vci_object_id), info
            except VciNoSuchDevice:
                pass  # pulled out in this very moment
            except VciNoMoreItems:
                return False
        return True

    @property
    @net_call
    def current(self) -> VciDevice:
        """Current: the board it stands at, a new object each time.

        Raises InvalidOperationException before the first board and behind the last one.
        """
        if self._found is None:
            raise InvalidOperationException(
                VCI_E_INVALID_STATE, "the enumerator stands before the first board or at the end"
            )
        return VciDevice(*self._found)

    @net_call
    def reset(self) -> None:
        """Reset: back before the first board."""
        self._found = None
        self._devices.reset()
