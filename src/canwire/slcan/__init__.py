"""An emulation of the CARTFT CANBUS dongle: the ASCII protocol of serial CAN adapters over a line of the hub.

`canwire slcan` serves one on a pseudo terminal, on TCP or on a serial port. Source: CANBUS manual; rulings 26 to 29.
"""

from __future__ import annotations

from canwire.slcan.can_side import ACCEPT_ALL, TRANSMIT_QUEUE, CanSide, Setup
from canwire.slcan.dialects import CANABLE, CANBUS, DIALECTS, Dialect, State
from canwire.slcan.dongle import Dongle
from canwire.slcan.eeprom import Eeprom, FileEeprom, MemoryEeprom
from canwire.slcan.host_side import RECEIVE_QUEUE
from canwire.slcan.hub_port import HubPort, plug_dongle
from canwire.slcan.leds import LedEvent, Leds, Red
from canwire.slcan.plugged import PluggedDongle
from canwire.slcan.serving import Service
from canwire.slcan.settings import DongleCounters, Settings
from canwire.slcan.tcp_wire import TcpWire
from canwire.slcan.wires import PtyWire, SerialWire, Wire

__all__ = [
    "ACCEPT_ALL",
    "CANABLE",
    "CANBUS",
    "DIALECTS",
    "RECEIVE_QUEUE",
    "TRANSMIT_QUEUE",
    "CanSide",
    "Dialect",
    "Dongle",
    "DongleCounters",
    "Eeprom",
    "FileEeprom",
    "HubPort",
    "LedEvent",
    "Leds",
    "MemoryEeprom",
    "PluggedDongle",
    "PtyWire",
    "Red",
    "SerialWire",
    "Service",
    "Settings",
    "Setup",
    "State",
    "TcpWire",
    "Wire",
    "plug_dongle",
]
