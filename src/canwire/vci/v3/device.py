"""IVciDevice: a board.

Source: VCI V3 .NET manual 2.2 and 2.3; reference/vci.md section 7a.
"""

from __future__ import annotations

from uuid import UUID

from canwire.vci import device
from canwire.vci.structures.devices import VciDeviceInfo
from canwire.vci.structures.guids import CLSID_VCIBAL, IID_IBalObject
from canwire.vci.v3.bal import BalObject
from canwire.vci.v3.device_info import VciCtrlInfo, Version
from canwire.vci.v3.disposable import Disposable, net_call


class VciDevice(Disposable):
    """IVciDevice: the properties of a board when it was found; `equipment` and opening need the board plugged in."""

    def __init__(self, found: device.VciDevice, info: VciDeviceInfo) -> None:
        """For IVciDeviceList."""
        super().__init__()
        found.add_ref()
        self._device = self._hold(found)
        self._info = info

    @property
    @net_call
    def vci_object_id(self) -> int:
        """VciObjectId: a new number each time the board is plugged in."""
        return self._info.vci_object_id.as_int64

    @property
    @net_call
    def device_class(self) -> UUID:
        """DeviceClass: the same for all boards of a kind."""
        return self._info.device_class

    @property
    @net_call
    def unique_hardware_id(self) -> str | UUID:
        """UniqueHardwareId: it never changes; text if it starts with HW ("HW123456"), else a GUID."""
        return self._info.hardware_id

    @property
    @net_call
    def description(self) -> str:
        """Description: the name of the board."""
        return self._info.description

    @property
    @net_call
    def manufacturer(self) -> str:
        """Manufacturer."""
        return self._info.manufacturer

    @property
    @net_call
    def driver_version(self) -> Version:
        """DriverVersion: major, minor, release, build."""
        info = self._info
        return Version(
            info.driver_major_version,
            info.driver_minor_version,
            info.driver_release_version,
            info.driver_build_version,
        )

    @property
    @net_call
    def hardware_version(self) -> Version:
        """HardwareVersion: major, minor, branch, build."""
        info = self._info
        return Version(
            info.hardware_major_version,
            info.hardware_minor_version,
            info.hardware_branch_version,
            info.hardware_build_version,
        )

    @property
    @net_call
    def equipment(self) -> list[VciCtrlInfo]:
        """Equipment: the connectors, number 0 first."""
        caps = self._device.get_device_caps()
        return [VciCtrlInfo.of(word) for word in caps.bus_ctrl_types[: caps.bus_ctrl_count]]

    @net_call
    def open_bus_access_layer(self) -> BalObject:
        """OpenBusAccessLayer; raises VciException while another access layer of the board is open."""
        return BalObject(self._device.open_component(CLSID_VCIBAL, IID_IBalObject))

    def __eq__(self, other: object) -> bool:
        """Two objects with the same VciObjectId are equal."""
        return (
            self._info.vci_object_id == other._info.vci_object_id
            if isinstance(other, VciDevice)
            else NotImplemented
        )

    def __hash__(self) -> int:
        return hash(self._info.vci_object_id.as_int64)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._info.hardware_id} ({self._info.description})>"
