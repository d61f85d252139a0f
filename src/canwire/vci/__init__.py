"""VCI V4: the CAN and LIN programming interface of IXXAT's boards, implemented on canwire's.

>>> from canwire import connect, vci
>>> with connect(time="fast") as hub:
...     vci.initialize(hub)
...     with vci.get_device_manager() as manager, manager.enum_devices() as devices:
...         [device.description for device in devices]
['USB-to-CAN FD (simulated)', 'USB-to-CAN V2 (simulated)']

Functions and methods have C's names in Python's spelling. They return what C returns through pointers, and raise
VciError if C returns an HRESULT other than VCI_OK. Constants keep their names.
Source: VCI V4 manual.
"""

from __future__ import annotations

from canwire.vci.bal import BalObject
from canwire.vci.can.channel import CanChannel, CanChannel2
from canwire.vci.can.control import CanControl, CanControl2
from canwire.vci.can.dtypes import canmsg2_dtype, canmsg_dtype, canmsg_view_dtype
from canwire.vci.can.message import CanCyclicTxMsg, CanCyclicTxMsg2, CanMsg, CanMsg2
from canwire.vci.can.msg_info import CanMsgInfo
from canwire.vci.can.presets import *  # noqa: F403
from canwire.vci.can.scheduler import CanScheduler, CanScheduler2
from canwire.vci.can.socket import CanSocket, CanSocket2
from canwire.vci.can.structures import (
    CanBtp,
    CanBtpPair,
    CanBtpTable,
    CanBtrTable,
    CanCapabilities,
    CanCapabilities2,
    CanChanStatus,
    CanChanStatus2,
    CanInitLine,
    CanInitLine2,
    CanLineStatus,
    CanLineStatus2,
    CanRtInfo,
    CanSchedulerStatus,
    CanSchedulerStatus2,
)
from canwire.vci.controller_types import *  # noqa: F403
from canwire.vci.device import VciDevice, VciDeviceManager, VciEnumDevice
from canwire.vci.fifo.block import FifoBlock
from canwire.vci.fifo.fifo import FifoReader, FifoWriter
from canwire.vci.fifo.whole import VciFifo, VciFifo2
from canwire.vci.lin.constants import *  # noqa: F403
from canwire.vci.lin.control import LinControl
from canwire.vci.lin.dtypes import linmsg_dtype, linmsg_view_dtype
from canwire.vci.lin.message import LinMsg
from canwire.vci.lin.monitor import LinMonitor
from canwire.vci.lin.msg_info import LinMsgInfo
from canwire.vci.lin.socket import LinSocket
from canwire.vci.lin.structures import LinCapabilities, LinInitLine, LinLineStatus, LinMonitorStatus
from canwire.vci.server import (
    access_fifo,
    create_fifo,
    create_luid,
    get_device_manager,
    get_version,
    initialize,
    query_device_by_class,
    query_device_by_hwid,
)
from canwire.vci.structures.constants import *  # noqa: F403
from canwire.vci.structures.devices import (
    BalFeatures,
    BalSocketInfo,
    VciDeviceCaps,
    VciDeviceInfo,
    VciId,
    VciVersionInfo,
)
from canwire.vci.structures.errors import *  # noqa: F403
from canwire.vci.structures.guids import *  # noqa: F403
from canwire.vci.structures.structure import Structure
from canwire.vci.text import char_to_guid, char_to_luid, guid_to_char, luid_to_char
from canwire.vci.unknown import Unknown

__all__ = [
    "BalFeatures",
    "BalObject",
    "BalSocketInfo",
    "CanBtp",
    "CanBtpPair",
    "CanBtpTable",
    "CanBtrTable",
    "CanCapabilities",
    "CanCapabilities2",
    "CanChanStatus",
    "CanChanStatus2",
    "CanChannel",
    "CanChannel2",
    "CanControl",
    "CanControl2",
    "CanCyclicTxMsg",
    "CanCyclicTxMsg2",
    "CanInitLine",
    "CanInitLine2",
    "CanLineStatus",
    "CanLineStatus2",
    "CanMsg",
    "CanMsg2",
    "CanMsgInfo",
    "CanRtInfo",
    "CanScheduler",
    "CanScheduler2",
    "CanSchedulerStatus",
    "CanSchedulerStatus2",
    "CanSocket",
    "CanSocket2",
    "FifoBlock",
    "FifoReader",
    "FifoWriter",
    "LinCapabilities",
    "LinControl",
    "LinInitLine",
    "LinLineStatus",
    "LinMonitor",
    "LinMonitorStatus",
    "LinMsg",
    "LinMsgInfo",
    "LinSocket",
    "Structure",
    "Unknown",
    "VciDevice",
    "VciDeviceCaps",
    "VciDeviceInfo",
    "VciDeviceManager",
    "VciEnumDevice",
    "VciFifo",
    "VciFifo2",
    "VciId",
    "VciVersionInfo",
    "access_fifo",
    "canmsg2_dtype",
    "canmsg_dtype",
    "canmsg_view_dtype",
    "char_to_guid",
    "char_to_luid",
    "create_fifo",
    "create_luid",
    "get_device_manager",
    "get_version",
    "guid_to_char",
    "initialize",
    "linmsg_dtype",
    "linmsg_view_dtype",
    "luid_to_char",
    "query_device_by_class",
    "query_device_by_hwid",
]

_BORROWED = {
    "Any",
    "CanwireError",
    "FrozenInstanceError",
    "Mapping",
    "Self",
    "UUID",
    "annotations",
    "cast",
    "operator",
}
__all__ += sorted(name for name in set(globals()) - set(__all__) - _BORROWED if name[0] != "_")
