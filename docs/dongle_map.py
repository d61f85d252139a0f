"""Writes docs/dongle-map.md: every command, rate, flag and answer of the CANBUS manual, and what it is in canwire.

    python docs/dongle_map.py [DIRECTORY OF THE MANUALS]

The names are read from the manual's text (../shared/seeds unless told otherwise) or, without it, from the page as it
stands. A name without a counterpart ends the script, naming it; tests/docs/test_dongle_map.py gives each command to an
emulated dongle.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

import name_map
from name_map import ROOT, Missing, Name, names_of_page, ordered

PAGE = ROOT / "docs" / "dongle-map.md"
MANUAL = "003_18a6c0cc1d4d221f.txt"
KINDS = ["command", "rate", "flag", "register", "answer"]
HEAD = """# The names of the CANBUS dongle, and what they are here

Written by `python docs/dongle_map.py` from the text of the CANBUS manual: change that, not this page.
{total} names. A program sends the commands as they are, to the place that `canwire slcan` prints;
`canwire.slcan.Dongle` answers them in Python.

"""

_COMMANDS = {
    "Sn": "`canwire.slcan.Setup.timing`, one of the nine rates",
    "sxxyy": "`canwire.slcan.Setup.timing`, by BTR0 and BTR1",
    "O": "`canwire.slcan.HubPort.open`",
    "C": "`canwire.slcan.HubPort.close`",
    "tiiildd": "`canwire.slcan.HubPort.send`, 11 bits",
    "Tiiiiiiidd": "`canwire.slcan.HubPort.send`, 29 bits in eight digits",
    "F": "`canwire.slcan.HubPort.events`, what they make of the flags since F was read last",
    "Mxxxxxxx": "`canwire.slcan.Setup.code`, eight digits",
    "mxxxxxxx": "`canwire.slcan.Setup.mask`, eight digits",
    "V": "`canwire.slcan.Settings.version`",
    "N": "`canwire.slcan.Settings.serial_number`",
    "Zn": "`canwire.slcan.Dongle.stamps`, kept in `canwire.slcan.Eeprom`",
}
_FLAGS = {
    0: "`canwire.slcan.RECEIVE_QUEUE`: that many frames wait",
    1: "`canwire.slcan.TRANSMIT_QUEUE`: that many frames wait",
    2: "`canwire.EventKind.STATE`, into error warning or bus-off, and back",
    3: "`canwire.EventKind.OVERRUN`",
    4: "never set, as in `canwire.slcan.Dongle`",
    5: "`canwire.EventKind.STATE`, into error passive, and back",
    6: "`canwire.EventKind.ARBITRATION_LOST`",
    7: "`canwire.EventKind.ERROR`",
}
_REGISTERS = {
    "AC": "`canwire.slcan.Setup.code`",
    "AM": "`canwire.slcan.Setup.mask`",
    "BT": "`canwire.slcan.Setup.timing`",
}
_ANSWERS = {
    "CR": "done, or nothing to say, in `canwire.slcan.Dongle.output`",
    "BELL": "refused; `canwire.slcan.Settings` has what depends on the firmware",
    "z": "queued: `canwire.slcan.TRANSMIT_QUEUE`",
    "Z": "queued: `canwire.slcan.TRANSMIT_QUEUE`",
}


def names_of_manual(seeds: Path) -> list[Name]:
    """In the order of the page: by kind and spelling."""
    text = (seeds / MANUAL).read_text(encoding="utf-8")
    found = {
        Name("command", _command(raw))
        for raw in re.findall(r"^([A-Za-z]+)(?:\.\.\.)?\[CR\]", text, re.MULTILINE)
    }
    found |= {Name("rate", name) for name in re.findall(r"^\| (S\d) \|", text, re.MULTILINE)}
    found |= {Name("flag", f"Bit {bit}") for bit in re.findall(r"^\| Bit (\d) \|", text, re.MULTILINE)}
    found |= {Name("register", name) for name in re.findall(r"\b(A[CM][0-3]|BTR[01])\b", text)}
    answers = re.findall(r"Returns: ([zZ])?\[?(CR)\b.*?(BELL)", text)
    found |= {Name("answer", name) for answer in answers for name in answer if name}
    return ordered(found, KINDS)


def _command(raw: str) -> str:
    """The document leaves the length digit of t out of its head, and lists it below."""
    return "tiiildd" if raw == "tiiidd" else raw


def counterpart(name: Name) -> str:
    """What it is here; raises Missing."""
    kind, text = name
    if kind == "rate":
        rates = ("10", "20", "50", "100", "125", "250", "500", "800", "1000")
        return f"{rates[int(text[1:])]} kbit/s: `canwire.slcan.Dongle.bit_rate`"
    found = {
        "command": _COMMANDS.get(text),
        "flag": _FLAGS.get(int(text[-1])) if kind == "flag" else None,
        "register": _REGISTERS.get(text[:2]),
        "answer": _ANSWERS.get(text),
    }[kind]
    if found is None:
        raise Missing(f"{kind} {text} has no counterpart")
    return found


def page(names: Iterable[Name]) -> str:
    """The page for these names; raises Missing."""
    return name_map.page(HEAD, names, counterpart)


if __name__ == "__main__":
    sys.exit(name_map.write(PAGE, names_of_manual, names_of_page, page))
