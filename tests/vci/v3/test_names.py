"""Every name of the manual that is not about LIN has its counterpart; the map is made by the rules of naming."""

from __future__ import annotations

import re

from canwire.vci import v3
from tests.cases import each

# in the manual's own spelling, misprints included; a class of .NET's own stands where V3 has one of that name
NAMES = {
    "VciServer": ["GetDeviceManager"],
    "IVciDeviceManager": ["GetDeviceList"],
    "IVciDeviceList": ["GetEnumerator", "AssignEvent"],
    "IEnumerator": ["Current", "MoveNext", "Reset"],
    "IVciDevice": [
        "Description",
        "VciObjectId",
        "DeviceClass",
        "UniqueHardwareId",
        "DriverVersion",
        "HardwareVersion",
        "Equipment",
        "OpenBusAccessLayer",
    ],
    "VciCtrlInfo": [],
    "IBalObject": ["FirmwareVersion", "Resources", "OpenSocket"],
    "BalResourceCollection": ["Count"],
    "ICanSocket": [
        "LineStatus",
        "SupportsDelayedTransmission",
        "MaxDelayedTXTicks",
        "ClockFrequency",
        "DelayedTXTimerDivisor",
        "MaxCyclicMsgTicks",
        "CyclicMessageTimeDivisor",
    ],
    "ICanChannel": ["Initialize", "Activate", "Deactivate", "GetMessageReader", "GetMessageWriter"],
    "ICanMessageReader": [
        "GetMessage",
        "GetMessages",
        "ReadMessage",
        "ReadMessages",
        "AssignEvent",
        "Threshold",
    ],
    "ICanMessageWriter": [
        "WriteMessage",
        "WriteMessages",
        "SendMessage",
        "SendMessages",
        "AssignEvent",
        "Threshold",
    ],
    "ICanControl": [
        "InitLine",
        "DetectBaud",
        "StartLine",
        "StopLine",
        "ResetLine",
        "SetAccFilter",
        "AddFilterIds",
        "RemFilterIds",
    ],
    "ICanScheduler": [
        "AddMessage",
        "RemoveMessage",
        "StartMessage",
        "StopMessage",
        "UpdateStatus",
        "Resume",
        "Suspend",
        "Reset",
    ],
    "CanMessage": [
        "TimeStamp",
        "Identifier",
        "FrameType",
        "SelfReceptionRequest",
        "RemoteTransmissionRequest",
        "ExtendedFrameFormat",
        "DataLength",
    ],
    "CanCyclicTXMsg": ["CycleTicks", "AutoIncrementMode", "AutoIncrementIndex", "Status", "Identifier"],
    "CanBitrate": [
        "Btr0",
        "Btr1",
        "Cia10KBit",
        "Cia20KBit",
        "Cia50KBit",
        "Cia125KBit",
        "Cia250KBit",
        "Cia500KBit",
        "Cia800KBit",
        "Cia1000Kbit",
        "100KBit",
        "CiaBitRates",
    ],
    "CanOperatingModes": ["Standard", "ErrFrame"],
    "CanMsgFrameType": ["Data"],
    "CanAccCode": ["All", "None"],
    "CanAccMask": ["All", "None"],
    "CanCyclicTXIncMode": ["NoInc", "Inc1", "Inc8", "Inc16"],
    "AutoResetEvent": ["WaitOne", "WaitAll"],
    "ManualResetEvent": ["WaitOne", "WaitAll"],
    "IDisposable": ["Dispose"],
    "VciException": [],
    "NotImplementedException": [],
}
CONSTANTS = {"CanOperatingModes", "CanMsgFrameType", "CanAccCode", "CanAccMask", "CanCyclicTXIncMode"}


def snake(name: str) -> str:
    """`_` between a lower-case letter or digit and a capital, and before the last capital of an acronym."""
    split = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return split.lower()


def counterpart(kind: str, name: str) -> str:
    rate = re.fullmatch(r"(Cia)?(\d+)K[Bb]it", name)
    if rate:
        return f"CIA_{rate[2]}_KBIT" if rate[1] else f"KBIT_{rate[2]}"
    if kind in CONSTANTS:
        return re.sub(r"(?<=[a-z])(?=\d)", "_", snake(name)).upper()
    return snake(name).upper() if name == "CiaBitRates" else snake(name)


MAP = [(kind, name, counterpart(kind, name)) for kind, names in NAMES.items() for name in names]


@each("kind", NAMES)
def test_every_class_has_its_counterpart(kind: str) -> None:
    assert kind in v3.__all__
    assert isinstance(getattr(v3, kind), type)


@each(("kind", "name", "python"), MAP, ids=lambda part: str(part))
def test_every_member_has_its_counterpart(kind: str, name: str, python: str) -> None:
    assert hasattr(getattr(v3, kind), python)


@each(
    ("name", "python"),
    [
        ("MaxDelayedTXTicks", "max_delayed_tx_ticks"),
        ("DelayedTXTimerDivisor", "delayed_tx_timer_divisor"),
        ("VciObjectId", "vci_object_id"),
        ("Btr0", "btr0"),
    ],
)
def test_the_rule(name: str, python: str) -> None:
    assert snake(name) == python


def test_all_is_what_there_is() -> None:
    assert sorted(v3.__all__, key=str.lower) == sorted(set(v3.__all__), key=str.lower)
    missing = [name for name in v3.__all__ if not hasattr(v3, name)]
    assert missing == []
