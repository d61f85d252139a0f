"""IVciDeviceManager, IVciEnumDevice and IVciDevice: the boards that are plugged in.

Source: VCI V4 manual chapter 3, 6.3, 7.1.3 and 7.1.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar
from uuid import UUID

from canwire import NoSuchBoard
from canwire.vci.arguments import UINT32, instance, within
from canwire.vci.bal import BalObject
from canwire.vci.bus_line import bus_ctrl_of
from canwire.vci.structures.devices import VciDeviceCaps, VciDeviceInfo, VciId
from canwire.vci.structures.errors import (
    VCI_E_DEVICE_NOT_CONNECTED,
    VCI_E_NO_MORE_ITEMS,
    VCI_E_NO_SUCH_DEVICE,
    VCI_E_NOT_IMPLEMENTED,
    VciError,
)
from canwire.vci.structures.guids import (
    CLSID_VCIBAL,
    IID_IUnknown,
    IID_IVciDevice,
    IID_IVciDeviceManager,
    IID_IVciEnumDevice,
)
from canwire.vci.translation import meaning
from canwire.vci.unknown import Unknown, no_interface, vci_call

if TYPE_CHECKING:
    from canwire import BoardInfo, Event, Hub


class VciDeviceManager(Unknown):
    """IVciDeviceManager: the list of all boards. Source: manual 6.3.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IVciDeviceManager})

    def __init__(self, hub: Hub) -> None:
        super().__init__()
        self._hub = hub

    @vci_call
    def enum_devices(self) -> VciEnumDevice:
        """EnumDevices: a new enumeration of the boards, independent of all others."""
        return VciEnumDevice(self._hub)

    @vci_call
    def open_device(self, vciid: VciId) -> VciDevice:
        """OpenDevice: the board with this `vci_object_id`; raises VciNoSuchDevice."""
        wanted = instance(vciid, VciId).as_int64
        found = next((board for board in vci_boards(self._hub) if board.id == wanted), None)
        if found is None:
            raise VciError.of(
                VCI_E_NO_SUCH_DEVICE, f"no device with the identifier {wanted:#x} is plugged in"
            )
        return VciDevice(self._hub, found)


class VciEnumDevice(Unknown):
    """IVciEnumDevice: enumerates the boards that are plugged in at each call; iterable. Source: manual 6.3.2."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IVciEnumDevice})

    def __init__(self, hub: Hub) -> None:
        super().__init__()
        self._hub = hub
        self._seen: set[int] = set()
        self._event: Event | None = None

    @vci_call
    def next(self, count: int = 1) -> list[VciDeviceInfo]:
        """Next: the next boards, up to `count`; raises VciNoMoreItems when none is left.

        A later call finds a board that is plugged in after that.
        """
        boards = self._ahead(within("count", count, 0, UINT32))
        if count and not boards:
            raise VciError.of(VCI_E_NO_MORE_ITEMS, "reset starts again at the first device")
        return [device_info(board) for board in boards]

    @vci_call
    def skip(self, count: int) -> None:
        """Skip: skip `count` boards, or as many as are left."""
        self._ahead(within("count", count, 0, UINT32))

    @vci_call
    def reset(self) -> None:
        """Reset: start again at the first board."""
        self._seen.clear()

    @vci_call
    def assign_event(self, event: Event | None) -> None:
        """AssignEvent: signal this event when a board comes or goes; it replaces the last one, None removes it."""
        self._forget_event()
        if event is not None:
            self._hub.watch(event)
            self._event = event

    def __iter__(self) -> Iterator[VciDeviceInfo]:
        """Yields the boards that `next` would return, up to the end of the list."""
        while found := self._one():
            yield found[0]

    def _close(self) -> None:
        self._forget_event()

    def _forget_event(self) -> None:
        event, self._event = self._event, None
        if event is not None:
            self._hub.unwatch(event)

    @vci_call
    def _one(self) -> list[VciDeviceInfo]:
        return [device_info(board) for board in self._ahead(1)]

    def _ahead(self, count: int) -> list[BoardInfo]:
        boards = [board for board in vci_boards(self._hub) if board.id not in self._seen][:count]
        self._seen.update(board.id for board in boards)
        return boards


class VciDevice(Unknown):
    """IVciDevice: one board. Each call raises VciDeviceNotConnected once it is removed. Source: manual 6.3.3."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IVciDevice})

    def __init__(self, hub: Hub, board: BoardInfo) -> None:
        super().__init__()
        self._hub = hub
        self._board = board

    @vci_call
    def get_device_info(self) -> VciDeviceInfo:
        """GetDeviceInfo: identifiers, versions and names."""
        return device_info(self._plugged())

    @vci_call
    def get_device_caps(self) -> VciDeviceCaps:
        """GetDeviceCaps: number and types of the connectors."""
        types = [bus_ctrl_of(line) for line in self._plugged().lines]
        return VciDeviceCaps(len(types), types)

    @vci_call
    def open_component(self, clsid: UUID, iid: UUID) -> BalObject:
        """OpenComponent: CLSID_VCIBAL with IID_IBalObject or IID_IUnknown.

        Raises VciAccessDenied while another access layer of the board is open, VciNotImplemented for another
        component, VciNoInterface for another interface.
        """
        if clsid != CLSID_VCIBAL:
            raise VciError.of(VCI_E_NOT_IMPLEMENTED, f"component {clsid}: the only one is CLSID_VCIBAL")
        if iid not in BalObject.interfaces:
            raise no_interface(self, iid)
        with meaning(VCI_E_DEVICE_NOT_CONNECTED, NoSuchBoard):
            return BalObject.open(self._hub, self._plugged())

    def _plugged(self) -> BoardInfo:
        if all(board.id != self._board.id for board in self._hub.boards()):
            board = self._board
            raise VciError.of(
                VCI_E_DEVICE_NOT_CONNECTED, f"{board.hardware_id} ({board.description}) was pulled out"
            )
        return self._board


def vci_boards(hub: Hub) -> list[BoardInfo]:
    """The boards of VCI: those that have a device class."""
    return [board for board in hub.boards() if board.device_class]


def device_info(board: BoardInfo) -> VciDeviceInfo:
    """VCIDEVICEINFO of a board."""
    driver_major, driver_minor, driver_release, driver_build = board.driver_version
    major, minor, branch, build = board.hardware_version
    info = VciDeviceInfo(
        vci_object_id=VciId(board.id),
        device_class=UUID(board.device_class),
        driver_major_version=driver_major,
        driver_minor_version=driver_minor,
        driver_release_version=driver_release,
        driver_build_version=driver_build,
        hardware_branch_version=branch,
        hardware_major_version=major,
        hardware_minor_version=minor,
        hardware_build_version=build,
        description=board.description,
        manufacturer=board.manufacturer,
    )
    info.hardware_id = board.hardware_id
    return info
