"""Every name of Ixxat.Vci4's published contract has its counterpart, spelled by V3's rule, and its value."""

from __future__ import annotations

import re
from enum import Enum
from typing import Any

import pytest

from canwire.vci import net4, v3
from tests.cases import hold_for_each
from tests.vci.v3.test_names import snake

SOCKET = """ControllerType BusCoupling Features LineStatus TimeStampCounterDivisor CyclicMessageTimerDivisor
    MaxCyclicMessageTicks DelayedTXTimerDivisor MaxDelayedTXTicks SupportsStdOrExtFrames SupportsStdAndExtFrames
    SupportsRemoteFrames SupportsErrorFrames SupportsBusLoadComputation SupportsExactMessageFilter
    SupportsListenOnlyMode SupportsCyclicMessageScheduler SupportsErrorFrameGeneration SupportsDelayedTransmission
    BusPort BusType BusName Dispose"""
SOCKET2 = f"""{SOCKET} CanClockFrequency MinimumArbitrationBitrate MaximumArbitrationBitrate MinimumFastDataBitrate
    MaximumFastDataBitrate TimeStampCounterClockFrequency CyclicMessageTimerClockFrequency
    DelayedTXTimerClockFrequency SupportsSingleShotMessages SupportsHighPriorityMessages
    SupportsAutoBaudrateDetection SupportsExtendedDataLength SupportsFastDataRate SupportsIsoCanFdFrames
    SupportsNonIsoCanFdFrames Supports64BitTimeStamps"""
CHANNEL = "ChannelStatus GetMessageReader GetMessageWriter Initialize Activate Deactivate"
FILTERS = "SetAccFilter AddFilterIds RemFilterIds"
CONTROL = f"DetectBaud InitLine ResetLine StartLine StopLine {FILTERS}"
SCHEDULER = "Suspend Resume Reset UpdateStatus AddMessage"
MESSAGE = """TimeStamp Identifier FrameType AcceptReason DataLength PossibleOverrun SelfReceptionRequest
    RemoteTransmissionRequest ExtendedFrameFormat SingleShotMode HighPriorityMsg ExtendedDataLength FastDataRate
    ErrorStateIndicator Clear"""
CYCLIC = f"{MESSAGE} Status CycleTicks AutoIncrementMode AutoIncrementIndex Start Stop Reset"
FIFO = "Capacity Threshold Lock Unlock AssignEvent Dispose"
STATUS = """OperatingMode Bitrate ControllerStatus Busload IsListenOnly IsLowSpeedEnabled IsTransmitPending
    IsAutomaticBitrateDetectionEnabled HasDataOverrun HasErrorOverrun IsBusOff IsInInitMode IsBusCErr"""
NAMES = {
    "ICanSocket": f"{SOCKET} ClockFrequency",
    "ICanSocket2": SOCKET2,
    "ICanChannel": f"{SOCKET} {CHANNEL}",
    "ICanChannel2": f"{SOCKET2} {CHANNEL} GetFilterMode SetFilterMode {FILTERS}",
    "ICanControl": f"{SOCKET} {CONTROL}",
    "ICanControl2": f"{SOCKET2} {CONTROL}",
    "ICanScheduler": f"{SOCKET} {SCHEDULER}",
    "ICanScheduler2": f"{SOCKET2} {SCHEDULER}",
    "ICanMessage": MESSAGE,
    "ICanMessage2": MESSAGE,
    "ICanCyclicTXMsg": CYCLIC,
    "ICanCyclicTXMsg2": CYCLIC,
    "ICanMessageReader": f"{FIFO} FillCount ReadMessage ReadMessages",
    "ICanMessageWriter": f"{FIFO} FreeCount SendMessage",
    "IMessageFactory": "CreateMsg",
    "IVciServer": "Version DeviceManager MsgFactory GetErrorMsg Instance",
    "IVciDeviceManager": "GetDeviceList Dispose",
    "IVciDeviceList": "AssignEvent GetEnumerator Dispose",
    "IEnumerator": "Current MoveNext Reset",
    "IVciDevice": """VciObjectId DeviceClass DriverVersion HardwareVersion UniqueHardwareId Description Manufacturer
        Equipment OpenBusAccessLayer Dispose""",
    "IBalObject": "FirmwareVersion Resources OpenSocket Dispose",
    "IBalResource": "BusPort BusType BusName Dispose",
    "CanLineStatus": f"{STATUS} IsModeUndefined IsModeStandard IsModeExtended IsErrorFramesEnabled",
    "CanLineStatus2": f"""{STATUS} ExtendedOperatingMode FastBitrate IsStdModeEnabled IsExtModeEnabled
        IsErrModeEnabled IsExtendedDataLengthEnabled IsFastDataEnabled IsNonIsoCanFdEnabled""",
    "CanBitrate2": """Mode Prescaler TimeSegment1 TimeSegment2 Sjw TransmitterDelay Name Empty Cia10KBit Cia20KBit
        Cia50KBit Cia125KBit Cia250KBit Cia500KBit Cia800KBit Cia1000KBit IFI833KBit IFI1000KBit IFI2000KBit
        IFI4000KBit IFI5000KBit IFI6667KBit IFI8000KBit IFI10000KBit CANFD250KBit CANFD500KBit CANFD833KBit
        CANFD1000KBit CANFD1538KBit CANFD2000KBit CANFD4000KBit CANFD5000KBit CANFD6667KBit CANFD8000KBit
        CANFD10000KBit CanFdIFIBitRates CanFdBitRates CiaBitRates CANopenArb1000KBit CANopenArb800KBit
        CANopenArb500KBit CANopenArb250KBit CANopenArb125KBit CANopen1000KBit CANopen2000KBit CANopen4000KBit
        CANopen5000KBit""",
    "CanFdBitrate": "StdBitrate FastBitrate CiaBitRates ShortLineCANFDBitRates LongLineCANFDBitRates",
}
VALUES: dict[type[Enum], str] = {
    net4.VciBusType: "Unknown=0 Can=1 Lin=2 FlexRay=4",
    net4.CanMsgError: "Stuff=1 Form=2 Acknowledge=3 Bit=4 Fdb=5 Crc=6 Dlc=7 Other=8",
    net4.CanBitrateMode: "None=0 Raw=1 TripleSampling=2",
    net4.CanFilterModes: "Invalid=0 Lock=1 Pass=2 Inclusive=3 Exclusive=4 PassSelfReceptions=128",
    net4.CanOperatingModes: "Undefined=0 Standard=1 Extended=2 ModeMask=3 ErrFrame=4 ListenOnly=8 LowSpeed=16 "
    "AutoBaudrate=32",
    net4.CanExtendedOperatingModes: "Undefined=0 ExtendedDataLength=1 FastDataRate=2 NonIsoCanFd=4",
    net4.CanFeatures: """StdOrExt=1 StdAndExt=2 RemoteFrame=4 ErrFrame=8 Busload=16 IdFilter=32 ListOnly=64
        Scheduler=128 GenErrFrame=256 DelayedTX=512 SingleShot=1024 HighPriorityMsg=2048 AutoBaudrate=4096
        ExtendedDataLength=8192 FastDataRate=16384 IsoCanFd=32768 NonIsoCanFd=65536 LongBitTimeStamp=131072""",
}
OTHERS_ARE_V3S = ["CanMsgFrameType", "CanMsgAccReason", "CanMsgInfoValue", "CanCtrlStatus", "CanCtrlType",
                  "CanBusCouplings", "CanFilter", "CanAccMask", "CanAccCode", "CanCyclicTXIncMode",
                  "CanCyclicTXStatus", "LinMessage", "LinControl", "AutoResetEvent", "VciDevice"]  # fmt: skip


def counterpart(name: str) -> str:
    rate = re.fullmatch(r"([A-Za-z]+?)(Arb)?(\d+)KBit", name)
    if rate:
        return "_".join(part.upper() for part in (*rate.groups(), "KBIT") if part)
    return snake(name).upper() if name.endswith("BitRates") or name == "Empty" else snake(name)


@pytest.mark.finding("dialects 9")
def test_every_name_has_its_counterpart() -> None:
    def check(case: tuple[str, str]) -> None:
        interface, name = case
        kind: Any = getattr(net4, interface)
        fields = getattr(kind, "__dataclass_fields__", {})
        assert hasattr(kind, counterpart(name)) or counterpart(name) in fields, counterpart(name)

    hold_for_each([(interface, name) for interface, names in NAMES.items() for name in names.split()], check)


@pytest.mark.finding("vendor 11")
def test_every_value_is_the_contracts() -> None:
    for kind, values in VALUES.items():
        wanted = {
            snake(name).upper(): int(value) for name, value in (one.split("=") for one in values.split())
        }
        assert {name: member.value for name, member in kind.__members__.items()} == wanted, kind


def test_what_is_alike_is_v3s() -> None:
    assert [name for name in OTHERS_ARE_V3S if getattr(net4, name) is not getattr(v3, name)] == []


def test_everything_is_exported() -> None:
    assert [name for name in net4.__all__ if not hasattr(net4, name)] == []
    assert set(NAMES) <= set(net4.__all__)
