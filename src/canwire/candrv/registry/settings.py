"""The registry entries of chapter 6, each declared once, and the settings of a device.

Source: CANDRV manual, chapter 6.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from typing import Any

from canwire import BadValue
from canwire.candrv.registry.file import Value

DWORD = 0xFFFF_FFFF
PRE_INSTALLED = "CID1"
DEVICE = re.compile(r"[A-Z]{3}[0-9]")


@dataclasses.dataclass(frozen=True, slots=True)
class Row:
    """An entry: `default` applies if the entry is not stored; `pattern` limits strings, `low` and `high` numbers.

    `ours` marks an entry that is not in the manual.
    """

    name: str
    type: str
    default: Value | None
    effect: str
    low: int = 0
    high: int = DWORD
    pattern: str = ".*"
    ours: bool = False

    @property
    def range(self) -> str:
        """The allowed values, in words."""
        if self.type == "DWORD":
            return f"{self.low} to {self.high:#x}" if self.high > 0xFFFF else f"{self.low} to {self.high}"
        return "any text" if self.pattern == ".*" else f"text like {self.pattern}"

    def checked(self, value: Any) -> Value:
        """The value, if it is allowed; raises BadValue otherwise."""
        if self.type == "DWORD":
            fits = isinstance(value, int) and not isinstance(value, bool) and self.low <= value <= self.high
        else:
            fits = isinstance(value, str) and bool(re.fullmatch(self.pattern, value, re.DOTALL))
        if not fits:
            raise BadValue(f"{self.name} = {value!r:.60}: it must be a {self.type}, {self.range}")
        return value

    def parsed(self, text: str) -> Value:
        """Parses a value as a user types it: a number is decimal, or hex with 0x; raises BadValue."""
        if self.type != "DWORD":
            return self.checked(text)
        if not re.fullmatch(r"0[xX][0-9A-Fa-f]{1,16}|[0-9]{1,20}", text):
            raise BadValue(f"{self.name} = {text!r:.60}: write a number, decimal or hex with 0x")
        return self.checked(int(text, 16 if text[:2] in ("0x", "0X") else 10))


def _number(
    name: str, default: int | None, effect: str, low: int = 0, high: int = DWORD, used: int | None = None
) -> Any:
    row = Row(name, "DWORD", default, effect, low, high)
    return dataclasses.field(default=default if used is None else used, metadata={"row": row})


def _text(name: str, default: str, effect: str, pattern: str = ".*", *, ours: bool = False) -> Any:
    row = Row(name, "String", default, effect, pattern=pattern, ours=ours)
    return dataclasses.field(default=default, metadata={"row": row})


@dataclasses.dataclass(frozen=True, slots=True)
class Settings:
    """The settings of a device: the stored entries, and the defaults of all others."""

    dll: str = _text("Dll", "candrv.dll", "driver library; the virtual board has none and ignores it")
    friendly_name: str = _text("FriendlyName", "PicoCOM CAN driver", "description")
    prefix: str = _text("Prefix", "CID", "device name: three upper-case letters before Index", "[A-Z]{3}")
    index: int = _number("Index", 1, "device name: the digit after Prefix", 0, 9)
    order: int = _number("Order", 20, "a higher number is loaded later; in canwire it only sorts this list")
    device_array_index: int = _number("DeviceArrayIndex", 0, "CAN port of the board that it drives", 0, 9)
    ioctl: int = _number(
        "Ioctl", 4, "code called once after the driver is loaded; the virtual board ignores it"
    )
    tx_mode: int = _number(
        "TxMode",
        7,
        "1 send buffer (else single message) | 2 TRANSMITTED events | 4 sent when on the wire (else when loaded)",
        0,
        7,
    )
    use_tx_irq: int | None = _number(
        "UseTxIRQ", None, "obsolete: 0 is TxMode 0, 1 is TxMode 7; TxMode wins", 0, 1
    )
    send_buffer_size: int = _number("SendBufferSize", 100, "messages in the send buffer", 1, 65535)
    event_queue_size: int = _number("EventQueueSize", 200, "events in the event queue", 1, 65535)
    priority: int = _number(
        "Priority256",
        103,
        "priority of the service thread; the virtual board has none and ignores it",
        0,
        255,
    )
    debug: int = _number("Debug", 0, "not 0: the driver prints diagnostic lines on the debug channel")
    baudrate: int = _number("Baudrate", 1_000_000, "bit/s", 1, 1_000_000)
    can_mode_2b: int = _number(
        "CanMode2B", 0, "0 CAN2.0A, standard frames; 1 CAN2.0B, extended ones too", 0, 1
    )
    format: int = _number(
        "Format",
        0,
        "frames sent: 0 set by CanMode2B, 1 standard, 2 extended; with CanMode2B both are received",
        0,
        2,
    )
    virtualize: int = _number(
        "Virtualize", 0, "1: handles on this board receive what other handles on it send", 0, 1
    )
    acceptance_code: int = _number("AcceptanceCode", 0, "code of a new receive channel's filter")
    acceptance_mask: int = _number("AcceptanceMask", 0, "mask of a new receive channel's filter")
    mask_active: int = _number(
        "MaskActive", 0, "meaning of a 1 in a mask: 0 the bit is not compared, 1 it must match", 0, 1
    )
    align: int = _number(
        "Align", 0, "alignment of identifiers and filters in 32 bits: table 6 of the manual", 0, 3
    )
    irq: int = _number("IRQ", 30, "interrupt of the controller; the virtual board ignores it", 0, 255)
    direct_interface: int = _number(
        "DirectInterface", 0, "0 shares the SPI port through SPIDevice, 1 uses it alone", 0, 1
    )
    spi_device: str = _text("SPIDevice", "SPI3:", "SPI port of the controller", "[A-Z]{3}[0-9]:")
    board: str = _text(
        "Board", "", "only in canwire: hardware id or kind of the board; empty: the first one", ours=True
    )

    @classmethod
    def of(cls, stored: Mapping[str, Any], device: str = PRE_INSTALLED) -> Settings:
        """The settings for stored values; raises BadValue for an unknown entry or an invalid value."""
        values = {row_of(name).name: row_of(name).checked(value) for name, value in stored.items()}
        named: dict[str, Any] = {}
        if DEVICE.fullmatch(device):
            named = {"Prefix": device[:3], "Index": int(device[3])}
        if "UseTxIRQ" in values:
            named["TxMode"] = 7 if values["UseTxIRQ"] else 0
        return cls(**{FIELDS[name]: value for name, value in {**named, **values}.items()})

    @property
    def device(self) -> str:
        """The device's name for CreateFile."""
        return f"{self.prefix}{self.index}:"

    @property
    def send_buffer_mode(self) -> bool:
        """Whether a send function puts messages into the send buffer and returns."""
        return bool(self.tx_mode & 1)

    @property
    def transmitted_events(self) -> bool:
        """Whether the driver reports TRANSMITTED events."""
        return bool(self.tx_mode & 2)

    @property
    def sent_on_wire(self) -> bool:
        """Whether a message counts as sent once it has been on the bus, not once the controller has loaded it."""
        return bool(self.tx_mode & 4)


FIELDS = {field.metadata["row"].name: field.name for field in dataclasses.fields(Settings)}
"""Attribute of Settings by the entry's name."""
ROWS: dict[str, Row] = {
    field.metadata["row"].name: field.metadata["row"] for field in dataclasses.fields(Settings)
}
"""The entries by their names, in the manual's order."""
IDENTITY = ("Prefix", "Index", "Order", "DeviceArrayIndex", "Board")
"""The entries that identify a device; `RegistryStore.defaults` keeps them."""
_BY_LOWER = {name.lower(): row for name, row in ROWS.items()}


def row_of(name: str) -> Row:
    """The entry with this name, in upper or lower case as in Windows; raises BadValue, which lists all names."""
    row = _BY_LOWER.get(str(name).lower())
    if row is None:
        raise BadValue(f"no registry entry {name!r:.40}; there are {', '.join(ROWS)}")
    return row
