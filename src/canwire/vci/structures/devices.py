"""Structures of VCI itself and of the bus access layer: devices, versions, sockets.

Source: VCI V4 manual 7.1 and 7.2; vcitype.h and baltype.h of VCI 4.1;
reference/vci.md section 5.
"""

from __future__ import annotations

from uuid import UUID

from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.members import guid, i64, nested, octets, text, u8, u16, u32, words, x16
from canwire.vci.structures.structure import Structure, structure

_SERIAL_NUMBER = b"HW"


@structure("VCIID", also=(("AsLuid.LowPart", "low_part"), ("AsLuid.HighPart", "high_part")))
class VciId(Structure):
    """An identifier that is unique while the system runs, as one number or as the two parts of a LUID.

    `as_int64` is -2**63 to 2**63 - 1, `low_part` 0 to 2**32 - 1, `high_part` -2**31 to 2**31 - 1.
    Source: manual 7.1.1.
    """

    as_int64: int = i64("AsInt64")

    @property
    def low_part(self) -> int:
        return self.as_int64 & 0xFFFF_FFFF

    @low_part.setter
    def low_part(self, value: int) -> None:
        self.as_int64 = self.high_part << 32 | _ranged("LowPart", value, 0, 0xFFFF_FFFF)

    @property
    def high_part(self) -> int:
        return self.as_int64 >> 32

    @high_part.setter
    def high_part(self, value: int) -> None:
        self.as_int64 = _ranged("HighPart", value, -(1 << 31), (1 << 31) - 1) << 32 | self.low_part


def _ranged(part: str, value: int, low: int, high: int) -> int:
    if not isinstance(value, int) or not low <= value <= high:
        raise VciError(VCI_E_INVALIDARG, f"VCIID.AsLuid.{part} must be a whole number from {low} to {high}")
    return value


@structure("VCIVERSIONINFO", also=(("VciReleaseNumber", "vci_rev_number"),))
class VciVersionInfo(Structure):
    """Version of VCI and of the operating system. Source: manual 7.1.2."""

    vci_major_version: int = u32("VciMajorVersion")
    vci_minor_version: int = u32("VciMinorVersion")
    vci_rev_number: int = u32("VciRevNumber")
    vci_build_number: int = u32("VciBuildNumber")
    os_major_version: int = u32("OsMajorVersion")
    os_minor_version: int = u32("OsMinorVersion")
    os_build_number: int = u32("OsBuildNumber")
    os_platform_id: int = u32("OsPlatformId")


@structure("VCIDEVICEINFO", also=(("Beschreibung", "description"), ("Hersteller", "manufacturer")))
class VciDeviceInfo(Structure):
    """A device: identifier, class, versions, serial number, names.

    `vci_object_id` is valid while the system runs; `unique_hardware_id` (16 bytes) never changes. Texts are Latin-1:
    `description` has up to 127 characters, `manufacturer` up to 125.
    Source: manual 7.1.3.
    """

    vci_object_id: VciId = nested("VciObjectId", VciId)
    device_class: UUID = guid("DeviceClass")
    driver_major_version: int = u8("DriverMajorVersion")
    driver_minor_version: int = u8("DriverMinorVersion")
    driver_build_version: int = u16("DriverBuildVersion")
    hardware_branch_version: int = u8("HardwareBranchVersion")
    hardware_major_version: int = u8("HardwareMajorVersion")
    hardware_minor_version: int = u8("HardwareMinorVersion")
    hardware_build_version: int = u8("HardwareBuildVersion")
    unique_hardware_id: bytes = octets("UniqueHardwareId", 16)
    description: str = text("Description", 128)
    manufacturer: str = text("Manufacturer", 126)
    driver_release_version: int = u16("DriverReleaseVersion")

    @property
    def hardware_id(self) -> str | UUID:
        """`unique_hardware_id` as text if it starts with HW ("HW123456"), as a GUID otherwise."""
        raw = self.unique_hardware_id[:16].ljust(16, b"\0")
        if raw.startswith(_SERIAL_NUMBER):
            return raw.partition(b"\0")[0].decode("latin-1")
        return UUID(bytes_le=raw)

    @hardware_id.setter
    def hardware_id(self, value: str | UUID) -> None:
        raw = value.bytes_le if isinstance(value, UUID) else value.encode("latin-1", "replace")
        if not isinstance(value, UUID) and not (raw.startswith(_SERIAL_NUMBER) and len(raw) <= 16):
            raise VciError(
                VCI_E_INVALIDARG, "a serial number must start with HW and have at most 16 characters"
            )
        self.unique_hardware_id = raw.ljust(16, b"\0")


@structure("VCIDEVICECAPS")
class VciDeviceCaps(Structure):
    """The controllers of a device: the number of valid entries among the 32, and the type of each.

    A type is a word of controller_types.py. Source: manual 7.1.4.
    """

    bus_ctrl_count: int = u16("BusCtrlCount")
    bus_ctrl_types: list[int] = words("BusCtrlTypes", 32)


@structure("BALFEATURES")
class BalFeatures(Structure):
    """Version of the firmware, and the sockets: the number of valid entries among the 32, and the type of each.

    A type is a word of controller_types.py. Source: manual 7.2.1.
    """

    fw_major_version: int = u16("FwMajorVersion")
    fw_minor_version: int = u16("FwMinorVersion")
    bus_socket_count: int = u16("BusSocketCount")
    bus_socket_type: list[int] = words("BusSocketType", 32)


@structure("BALSOCKETINFO", also=(("Obid", "object_id"), ("Type", "bus_type"), ("BusNo", "socket_no")))
class BalSocketInfo(Structure):
    """An opened socket: its identifier, its type (a word of controller_types.py), its number from 0.

    Source: manual 7.2.2, whose names for them are Obid, Type and BusNo.
    """

    object_id: VciId = nested("ObjectId", VciId)
    bus_type: int = x16("BusType")
    socket_no: int = u16("SocketNo")
