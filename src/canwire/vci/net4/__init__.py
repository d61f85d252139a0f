"""Ixxat.Vci4: today's .NET interface to IXXAT's boards, in Python's spelling, over the same objects as `canwire.vci`.

    for device in VciServer.instance().device_manager.get_device_list():
        with device.open_bus_access_layer() as bal:
            channel = bal.open_socket(0, ICanChannel2)

Names follow PEP 8, as in `canwire.vci.v3`; a class that is the same in both interfaces exists once. The differences
from V3: features, modes and errors have V4's numbers; the cyclic list makes its messages and runs immediately;
messages can be CAN FD.
"""

from canwire.vci.net4.bitrate import CanBitrate2, CanFdBitrate
from canwire.vci.net4.channel import CanChannel, CanChannel2
from canwire.vci.net4.control import CanControl, CanControl2
from canwire.vci.net4.enums import (
    CanBitrateMode,
    CanExtendedOperatingModes,
    CanFeatures,
    CanFilterModes,
    CanMsgError,
    CanOperatingModes,
    VciBusType,
)
from canwire.vci.net4.lin import LinMonitor
from canwire.vci.net4.message import CanCyclicTXMsg, CanCyclicTXMsg2, CanMessage, CanMessage2
from canwire.vci.net4.reader_writer import CanMessageReader, CanMessageWriter
from canwire.vci.net4.scheduler import CanScheduler, CanScheduler2
from canwire.vci.net4.server import MessageFactory, VciServer
from canwire.vci.net4.socket import CanSocket, CanSocket2
from canwire.vci.net4.status import CanLineStatus, CanLineStatus2
from canwire.vci.v3 import (
    ArgumentException,
    ArgumentOutOfRangeException,
    AutoResetEvent,
    BalObject,
    BalResource,
    BalResourceCollection,
    CanAccCode,
    CanAccMask,
    CanBitrate,
    CanBusCouplings,
    CanChannelStatus,
    CanCtrlStatus,
    CanCtrlType,
    CanCyclicTXIncMode,
    CanCyclicTXStatus,
    CanFilter,
    CanMsgAccReason,
    CanMsgFrameType,
    CanMsgInfoValue,
    Disposable,
    IBalObject,
    IBalResource,
    IDisposable,
    IEnumerator,
    ILinControl,
    ILinMessageReader,
    ILinSocket,
    InvalidOperationException,
    IVciDevice,
    IVciDeviceList,
    IVciDeviceManager,
    LinBitrate,
    LinControl,
    LinCtrlStatus,
    LinFeatures,
    LinInitLine,
    LinLineStatus,
    LinMessage,
    LinMessageReader,
    LinMessageType,
    LinMonitorStatus,
    LinMsgError,
    LinMsgInfoValue,
    LinOperatingModes,
    LinSocket,
    ManualResetEvent,
    NotImplementedException,
    ObjectDisposedException,
    VciCtrlInfo,
    VciDevice,
    VciDeviceEnumerator,
    VciDeviceList,
    VciDeviceManager,
    VciError,
    VciException,
    Version,
    WaitHandle,
)

# the interfaces as .NET names them
ICanChannel = CanChannel
ICanChannel2 = CanChannel2
ICanControl = CanControl
ICanControl2 = CanControl2
ICanCyclicTXMsg = CanCyclicTXMsg
ICanCyclicTXMsg2 = CanCyclicTXMsg2
ICanMessage = CanMessage
ICanMessage2 = CanMessage2
ICanMessageReader = CanMessageReader
ICanMessageWriter = CanMessageWriter
ICanScheduler = CanScheduler
ICanScheduler2 = CanScheduler2
ICanSocket = CanSocket
ICanSocket2 = CanSocket2
ILinMessage = LinMessage
ILinMonitor = LinMonitor
IMessageFactory = MessageFactory
IVciCtrlInfo = VciCtrlInfo
IVciServer = VciServer

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
    "CanBitrate2",
    "CanBitrateMode",
    "CanBusCouplings",
    "CanChannel",
    "CanChannel2",
    "CanChannelStatus",
    "CanControl",
    "CanControl2",
    "CanCtrlStatus",
    "CanCtrlType",
    "CanCyclicTXIncMode",
    "CanCyclicTXMsg",
    "CanCyclicTXMsg2",
    "CanCyclicTXStatus",
    "CanExtendedOperatingModes",
    "CanFdBitrate",
    "CanFeatures",
    "CanFilter",
    "CanFilterModes",
    "CanLineStatus",
    "CanLineStatus2",
    "CanMessage",
    "CanMessage2",
    "CanMessageReader",
    "CanMessageWriter",
    "CanMsgAccReason",
    "CanMsgError",
    "CanMsgFrameType",
    "CanMsgInfoValue",
    "CanOperatingModes",
    "CanScheduler",
    "CanScheduler2",
    "CanSocket",
    "CanSocket2",
    "Disposable",
    "IBalObject",
    "IBalResource",
    "ICanChannel",
    "ICanChannel2",
    "ICanControl",
    "ICanControl2",
    "ICanCyclicTXMsg",
    "ICanCyclicTXMsg2",
    "ICanMessage",
    "ICanMessage2",
    "ICanMessageReader",
    "ICanMessageWriter",
    "ICanScheduler",
    "ICanScheduler2",
    "ICanSocket",
    "ICanSocket2",
    "IDisposable",
    "IEnumerator",
    "ILinControl",
    "ILinMessage",
    "ILinMessageReader",
    "ILinMonitor",
    "ILinSocket",
    "IMessageFactory",
    "IVciCtrlInfo",
    "IVciDevice",
    "IVciDeviceList",
    "IVciDeviceManager",
    "IVciServer",
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
    "MessageFactory",
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
