"""The arguments of VCI's methods in the form that the program sends: packed without gaps.

Sources: VCI V4 manual chapter 6; vcisdk.h of VCI 4.1 (reference/vci.md).
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple
from uuid import UUID

from canwire import vci
from canwire.vci import (
    CanBtpTable,
    CanBtrTable,
    CanCyclicTxMsg,
    CanCyclicTxMsg2,
    CanInitLine,
    CanInitLine2,
    LinInitLine,
    LinMsg,
    VciId,
)


class Argument(NamedTuple):
    """The number of bytes of an argument, and the function that converts them."""

    size: int
    made: Callable[[bytes], Any]


def _number(form: str) -> Argument:
    packed = struct.Struct("<" + form)
    return Argument(packed.size, lambda data: packed.unpack(data)[0])


def _structure(kind: type[Any]) -> Argument:
    return Argument(kind.SIZE, kind.from_bytes)


U8, U16, U32 = _number("B"), _number("H"), _number("I")
BOOL = Argument(4, lambda data: any(data))
GUID = Argument(16, lambda data: UUID(bytes_le=data))
VCIID = _structure(VciId)
PATTERN = (U8, U32, U32)

FUNCTIONS: Mapping[str, tuple[Argument, ...]] = {
    "get_version": (),
    "create_luid": (),
    "get_device_manager": (),
    "query_device_by_hwid": (GUID,),
    "query_device_by_class": (GUID, U32),
    "create_fifo": (U16, U16, GUID),
    "access_fifo": (VCIID, GUID),
}

METHODS: Mapping[str, tuple[Argument, ...]] = {
    "FifoReader.check": (),
    "FifoReader.query_interface": (GUID,),
    "FifoWriter.check": (),
    "FifoWriter.query_interface": (GUID,),
    "VciFifo2.query_interface": (GUID,),
    "VciFifo2.get_capacity": (),
    "VciFifo2.get_entry_size": (),
    "VciFifo2.get_free_count": (),
    "VciFifo2.get_fill_count": (),
    "VciFifo2.get_fill_level": (),
    "VciFifo2.reset": (),
    "VciDeviceManager.enum_devices": (),
    "VciDeviceManager.open_device": (VCIID,),
    "VciEnumDevice.next": (U32,),
    "VciEnumDevice.skip": (U32,),
    "VciEnumDevice.reset": (),
    "VciDevice.get_device_info": (),
    "VciDevice.get_device_caps": (),
    "VciDevice.open_component": (GUID, GUID),
    "BalObject.get_features": (),
    "BalObject.open_socket": (U32, GUID),
    "CanSocket.create_channel": (BOOL,),
    "CanSocket2.create_channel": (BOOL,),
    "CanChannel.initialize": (U16, U16),
    "CanChannel2.initialize": (U32, U32, U32, U8),
    "CanChannel2.get_control": (),
    "CanControl.detect_baud": (U16, _structure(CanBtrTable)),
    "CanControl2.detect_baud": (U8, U8, U16, _structure(CanBtpTable)),
    "CanControl.init_line": (_structure(CanInitLine),),
    "CanControl2.init_line": (_structure(CanInitLine2),),
    "CanScheduler.add_message": (_structure(CanCyclicTxMsg),),
    "CanScheduler2.add_message": (_structure(CanCyclicTxMsg2),),
    "LinSocket.create_monitor": (BOOL,),
    "LinMonitor.initialize": (U16,),
    "LinControl.init_line": (_structure(LinInitLine),),
    "LinControl.write_message": (BOOL, _structure(LinMsg)),
    **{
        f"{kind}.{method}": ()
        for kinds, methods in {
            ("CanSocket", "CanSocket2", "LinSocket"): (
                "get_socket_info",
                "get_capabilities",
                "get_line_status",
            ),
            ("CanChannel", "CanChannel2"): (
                "activate",
                "deactivate",
                "get_reader",
                "get_writer",
                "get_status",
            ),
            ("LinMonitor",): ("activate", "deactivate", "get_reader", "get_status"),
            ("CanControl", "CanControl2", "LinControl"): (
                "reset_line",
                "start_line",
                "stop_line",
                "get_line_status",
            ),
            ("CanScheduler", "CanScheduler2"): ("resume", "suspend", "reset", "get_status"),
        }.items()
        for kind in kinds
        for method in methods
    },
    **{
        f"{kind}.{method}": PATTERN
        for kind in ("CanControl", "CanControl2", "CanChannel2")
        for method in ("set_acc_filter", "add_filter_ids", "rem_filter_ids")
    },
    **{f"{kind}.get_filter_mode": (U8,) for kind in ("CanControl2", "CanChannel2")},
    **{f"{kind}.set_filter_mode": (U8, U8) for kind in ("CanControl2", "CanChannel2")},
    **{f"{kind}.rem_message": (U32,) for kind in ("CanScheduler", "CanScheduler2")},
    **{f"{kind}.start_message": (U32, U32) for kind in ("CanScheduler", "CanScheduler2")},
    **{f"{kind}.stop_message": (U32,) for kind in ("CanScheduler", "CanScheduler2")},
}


def unpacked(arguments: tuple[Argument, ...], data: bytes) -> Iterator[Any]:
    """Yield the arguments in this data; raises VciInvalidArgument if its size is wrong."""
    wanted = sum(argument.size for argument in arguments)
    if len(data) != wanted:
        raise vci.VciError.of(vci.VCI_E_INVALIDARG, f"{len(data)} bytes of arguments instead of {wanted}")
    at = 0
    for argument in arguments:
        yield argument.made(data[at : at + argument.size])
        at += argument.size
