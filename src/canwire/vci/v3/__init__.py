"""VCI V3: the .NET interface to IXXAT's boards, in Python's spelling, over the same objects as `canwire.vci`.

    for device in VciServer.get_device_manager().get_device_list():
        with device.open_bus_access_layer() as bal:
            channel = bal.open_socket(0, CanChannel)

Names follow PEP 8: GetDeviceList is `get_device_list`, CanBitrate.Cia125KBit is `CanBitrate.CIA_125_KBIT`. A method
with an `out` parameter returns it. The name of a class is that of its interface without the I; the name with the I
exists, too.
"""

from canwire.vci.structures.errors import VciError
from canwire.vci.v3.bal import BalObject
from canwire.vci.v3.bus_type import VciBusType
from canwire.vci.v3.can.bitrate import CanBitrate
from canwire.vci.v3.can.channel import CanChannel
from canwire.vci.v3.can.control import CanControl
from canwire.vci.v3.can.enums import (
    CanAccCode,
    CanAccMask,
    CanBusCouplings,
    CanCtrlStatus,
    CanCtrlType,
    CanCyclicTXIncMode,
    CanCyclicTXStatus,
    CanCyclicTXTaskStatus,
    CanFeatures,
    CanFilter,
    CanMsgAccReason,
    CanMsgError,
    CanMsgFrameType,
    CanMsgInfoValue,
    CanOperatingModes,
)
from canwire.vci.v3.can.message import CanCyclicTXMsg, CanMessage
from canwire.vci.v3.can.reader_writer import CanMessageReader, CanMessageWriter
from canwire.vci.v3.can.scheduler import CanScheduler
from canwire.vci.v3.can.socket import CanSocket
from canwire.vci.v3.can.status import CanChannelStatus, CanLineStatus
from canwire.vci.v3.device import VciDevice
from canwire.vci.v3.device_info import VciCtrlInfo, Version
from canwire.vci.v3.disposable import Disposable
from canwire.vci.v3.errors import (
    ArgumentException,
    ArgumentOutOfRangeException,
    InvalidOperationException,
    NotImplementedException,
    ObjectDisposedException,
    VciException,
)
from canwire.vci.v3.events import AutoResetEvent, ManualResetEvent, WaitHandle
from canwire.vci.v3.lin.bitrate import LinBitrate
from canwire.vci.v3.lin.control import LinControl
from canwire.vci.v3.lin.enums import (
    LinCtrlStatus,
    LinFeatures,
    LinMessageType,
    LinMsgError,
    LinMsgInfoValue,
    LinOperatingModes,
)
from canwire.vci.v3.lin.init import LinInitLine
from canwire.vci.v3.lin.message import LinMessage
from canwire.vci.v3.lin.monitor import LinMonitor
from canwire.vci.v3.lin.reader import LinMessageReader
from canwire.vci.v3.lin.socket import LinSocket
from canwire.vci.v3.lin.status import LinLineStatus, LinMonitorStatus
from canwire.vci.v3.resource import BalResource, BalResourceCollection
from canwire.vci.v3.server import VciDeviceEnumerator, VciDeviceList, VciDeviceManager, VciServer

# the interfaces as the manual names them
IBalObject = BalObject
IBalResource = BalResource
ICanChannel = CanChannel
ICanControl = CanControl
ICanMessageReader = CanMessageReader
ICanMessageWriter = CanMessageWriter
ICanScheduler = CanScheduler
ICanSocket = CanSocket
IDisposable = Disposable
IEnumerator = VciDeviceEnumerator
ILinControl = LinControl
ILinMessageReader = LinMessageReader
ILinMonitor = LinMonitor
ILinSocket = LinSocket
IVciDevice = VciDevice
IVciDeviceList = VciDeviceList
IVciDeviceManager = VciDeviceManager

__all__ = [
    "ArgumentException",
    "ArgumentOutOfRangeException",
    "AutoResetEvent",
    "BalObject",
    "BalResource",
    "BalResourceCollection",
    "CanAccCode",
    "CanAccMask",
    "CanBitrate",
    "CanBusCouplings",
    "CanChannel",
    "CanChannelStatus",
    "CanControl",
    "CanCtrlStatus",
    "CanCtrlType",
    "CanCyclicTXIncMode",
    "CanCyclicTXMsg",
    "CanCyclicTXStatus",
    "CanCyclicTXTaskStatus",
    "CanFeatures",
    "CanFilter",
    "CanLineStatus",
    "CanMessage",
    "CanMessageReader",
    "CanMessageWriter",
    "CanMsgAccReason",
    "CanMsgError",
    "CanMsgFrameType",
    "CanMsgInfoValue",
    "CanOperatingModes",
    "CanScheduler",
    "CanSocket",
    "Disposable",
    "IBalObject",
    "IBalResource",
    "ICanChannel",
    "ICanControl",
    "ICanMessageReader",
    "ICanMessageWriter",
    "ICanScheduler",
    "ICanSocket",
    "IDisposable",
    "IEnumerator",
    "ILinControl",
    "ILinMessageReader",
    "ILinMonitor",
    "ILinSocket",
    "IVciDevice",
    "IVciDeviceList",
    "IVciDeviceManager",
    "InvalidOperationException",
    "LinBitrate",
    "LinControl",
    "LinCtrlStatus",
    "LinFeatures",
    "LinInitLine",
    "LinLineStatus",
    "LinMessage",
    "LinMessageReader",
    "LinMessageType",
    "LinMonitor",
    "LinMonitorStatus",
    "LinMsgError",
    "LinMsgInfoValue",
    "LinOperatingModes",
    "LinSocket",
    "ManualResetEvent",
    "NotImplementedException",
    "ObjectDisposedException",
    "VciBusType",
    "VciCtrlInfo",
    "VciDevice",
    "VciDeviceEnumerator",
    "VciDeviceList",
    "VciDeviceManager",
    "VciError",
    "VciException",
    "VciServer",
    "Version",
    "WaitHandle",
]
