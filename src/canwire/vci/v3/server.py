"""VciServer, IVciDeviceManager and IVciDeviceList: a program begins with them.

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
    """VciServer, of which each process has one.

    Its boards are those of the hub given to `vci.initialize`, or of the default hub if that was not called.
    """

    _instance: ClassVar[VciServer | None] = None

    @classmethod
    def instance(cls) -> VciServer:
        """Instance: the server of this process."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    @staticmethod
    def get_device_manager() -> VciDeviceManager:
        """GetDeviceManager. Raises VciException with VCI_E_DISCONNECTED if no hub answers."""
        with exceptions():
            server.initialize()
            return VciDeviceManager(server.get_device_manager())

    @property
    def device_manager(self) -> VciDeviceManager:
        """DeviceManager: the same as `get_device_manager`."""
        return self.get_device_manager()

    @staticmethod
    def get_error_msg(code: int) -> str:
        """GetErrorMsg: name, number and meaning of a result code; ArgumentException if it is no 32-bit number."""
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
    """IVciDeviceList: the boards that are plugged in; each iteration is independent of others."""

    def __init__(self, manager: device.VciDeviceManager) -> None:
        """For IVciDeviceManager."""
        super().__init__()
        manager.add_ref()
        self._manager = self._hold(manager)
        self._changes = self._hold(manager.enum_devices())

    @net_call
    def get_enumerator(self) -> VciDeviceEnumerator:
        """GetEnumerator: a new, independent enumerator for each call."""
        return VciDeviceEnumerator(self._manager)

    @net_call
    def assign_event(self, event: Event | None) -> None:
        """AssignEvent: signal this event at each change of the list; it replaces the last one, None removes it."""
        self._changes.assign_event(event)

    def __iter__(self) -> Iterator[VciDevice]:
        with self.get_enumerator() as enumerator:
            while enumerator.move_next():
                yield enumerator.current


class VciDeviceEnumerator(Disposable):
    """IEnumerator over boards; at first it is before the first board."""

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
                pass  # removed at this moment
            except VciNoMoreItems:
                return False
        return True

    @property
    @net_call
    def current(self) -> VciDevice:
        """Current: the present board, a new object each time.

        Raises InvalidOperationException before the first board and after the last one.
        """
        if self._found is None:
            raise InvalidOperationException(
                VCI_E_INVALID_STATE, "the enumerator is before the first board or at the end"
            )
        return VciDevice(*self._found)

    @net_call
    def reset(self) -> None:
        """Reset: return to the position before the first board."""
        self._found = None
        self._devices.reset()
