"""The functions that VCI exports: a program begins with them.

Source: VCI V4 manual 6.1; rulings.md 2, 12 and 13.
"""

from __future__ import annotations

import os
import re
import sys
from typing import TYPE_CHECKING
from uuid import UUID

import canwire
from canwire.vci.arguments import UINT16, UINT32, instance, within
from canwire.vci.device import VciDevice, VciDeviceManager, vci_boards
from canwire.vci.fifo.fifo import FifoReader, FifoWriter
from canwire.vci.fifo.whole import VciFifo2, open_fifo, role_of
from canwire.vci.structures.devices import VciId, VciVersionInfo
from canwire.vci.structures.errors import (
    VCI_E_INVALIDARG,
    VCI_E_NO_SUCH_DEVICE,
    VCI_E_NOT_INITIALIZED,
    VciError,
)
from canwire.vci.structures.guids import IID_IVciFifo2
from canwire.vci.translation import translated

if TYPE_CHECKING:
    from canwire import Hub

AnyFifo = VciFifo2 | FifoReader[bytes] | FifoWriter[bytes]
_MANUAL = (4, 0)  # the version of VCI in the manual that this package follows
_VER_PLATFORM_WIN32_NT = 2
_HARDWARE_ID = 16
_process: dict[str, Hub] = {}  # "hub": the one that `initialize` found


def initialize(hub: Hub | str | None = None) -> None:
    """VciInitialize: connect this process to the boards. All functions except texts and versions need it first.

    `hub` is a connection, the address of a hub, or None for the default hub (`canwire.connect`). A second call without
    `hub` does nothing while the connection exists; with `hub`, objects opened afterwards use that hub.
    Raises VciDisconnected if no hub answers.
    """
    with translated():
        if hub is None:
            if "hub" not in _process or _process["hub"].lost:
                _process["hub"] = canwire.connect()
        else:
            _process["hub"] = canwire.connect(hub) if isinstance(hub, str) else hub


def get_version() -> VciVersionInfo:
    """VciGetVersion: 4.0, the version of VCI in the manual, then canwire's version, and the system's version.

    `vci_rev_number` is canwire's major * 100 + minor, `vci_build_number` is canwire's last number.
    """
    major, minor, build = _numbers(canwire.__version__)
    if sys.platform == "win32":
        system, windows = _numbers(".".join(map(str, sys.getwindowsversion()[:3]))), _VER_PLATFORM_WIN32_NT
    else:
        system, windows = _numbers(os.uname().release), 0
    return VciVersionInfo(*_MANUAL, major * 100 + minor, build, *system, windows)


def create_luid() -> VciId:
    """VciCreateLuid: an identifier that is unique while the hub runs."""
    with translated():
        return VciId(_hub().create_luid())


def get_device_manager() -> VciDeviceManager:
    """VciGetDeviceManager: the list of devices."""
    return VciDeviceManager(_hub())


def query_device_by_hwid(hwid: UUID | bytes | str) -> VciDevice:
    """VciQueryDeviceByHwid: the device with this `unique_hardware_id`: a GUID, its 16 bytes, or text like "HW123456".

    Raises VciNoSuchDevice.
    """
    wanted = _hardware_id(hwid)
    with translated():
        for board in vci_boards(_hub()):
            if _hardware_id(board.hardware_id) == wanted:
                return VciDevice(_hub(), board)
    raise VciError.of(VCI_E_NO_SUCH_DEVICE, f"no device with the hardware id {hwid!r} is plugged in")


def query_device_by_class(device_class: UUID, instance: int = 0) -> VciDevice:
    """VciQueryDeviceByClass: the device with index `instance`, from 0, in a device class; raises VciNoSuchDevice."""
    within("instance", instance, 0, UINT32)
    with translated():
        boards = [board for board in vci_boards(_hub()) if UUID(board.device_class) == device_class]
    if instance >= len(boards):
        raise VciError.of(
            VCI_E_NO_SUCH_DEVICE, f"{len(boards)} devices of class {device_class} are plugged in"
        )
    return VciDevice(_hub(), boards[instance])


def create_fifo(capacity: int, element_size: int, iid: UUID = IID_IVciFifo2) -> tuple[VciId, AnyFifo]:
    """VciCreateFifo: make a FIFO; returns its identifier for `access_fifo` in any process, and one of its interfaces.

    It has at least `capacity` elements, 1 to 65535, of `element_size` bytes, 1 to 65535; whole pages of memory are
    used, up to 65535 elements. The FIFO exists while any program holds one of its interfaces.
    Raises VciInvalidArgument, VciNoInterface.
    """
    hub = _hub()
    role_of(iid)
    within("capacity", capacity, 1, UINT16)
    within("element_size", element_size, 1, UINT16)
    with (
        translated(),
        hub.create_fifo(capacity, element_size) as made,
    ):
        vciid = VciId(made.id)
        return vciid, open_fifo(hub, made.id, iid)


def access_fifo(vciid: VciId, iid: UUID = IID_IVciFifo2) -> AnyFifo:
    """VciAccessFifo: another interface of an existing FIFO.

    Raises VciAccessDenied if IID_IFifoReader or IID_IFifoWriter is open already, VciError with
    VCI_E_OBJECTID_NOT_FOUND if no FIFO has this identifier, VciNoInterface.
    """
    with translated():
        return open_fifo(_hub(), instance(vciid, VciId).as_int64, iid)


def _hub() -> Hub:
    hub = _process.get("hub")
    if hub is None:
        raise VciError.of(VCI_E_NOT_INITIALIZED, "call initialize first")
    return hub


def _hardware_id(hwid: UUID | bytes | str) -> bytes:
    """The 16 bytes of VCIDEVICEINFO.UniqueHardwareId."""
    if isinstance(hwid, UUID):
        return hwid.bytes_le
    raw = hwid.encode("latin-1", "replace") if isinstance(hwid, str) else bytes(hwid)
    if not 0 < len(raw) <= _HARDWARE_ID:
        raise VciError.of(VCI_E_INVALIDARG, f"a hardware id has up to {_HARDWARE_ID} bytes, not {len(raw)}")
    return raw.ljust(_HARDWARE_ID, b"\0")


def _numbers(version: str) -> tuple[int, int, int]:
    """The first three numbers of a version, 0 for missing ones."""
    found = [int(digits) & UINT32 for digits in re.findall(r"\d+", version)[:3]]
    major, minor, build = [*found, 0, 0, 0][:3]
    return major, minor, build
