"""Windows' .reg files: reads the entries of CANDRV's devices, as a remote registry editor exports them.

    Windows Registry Editor Version 5.00

    [HKEY_LOCAL_MACHINE\\Drivers\\BuiltIn\\CID1]
    "Baudrate"=dword:0007a120
    "FriendlyName"="PicoCOM CAN driver"

A line `"Entry"=-` restores the default; `[-HKEY_LOCAL_MACHINE\\...\\CID1]` removes the device.
Source: CANDRV manual, 6.2; Microsoft, "How to add, modify, or delete registry subkeys and values by using
a .reg file".
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from canwire import BadConfig, BadValue
from canwire.candrv.registry.file import Value
from canwire.candrv.registry.settings import DEVICE, row_of

_HEADS = ("Windows Registry Editor Version 5.00", "REGEDIT4")
_KEY = re.compile(r"\[[^\]]*\]")
_DEVICE = re.compile(
    r"\[(-?)(?:HKEY_LOCAL_MACHINE|HKLM)\\Drivers\\BuiltIn\\([A-Za-z0-9_-]+)\]", re.IGNORECASE
)
_ENTRY = re.compile(r'"((?:[^"\\]|\\.)*)"\s*=\s*(.*)')
_DWORD = re.compile(r"dword:([0-9A-Fa-f]{1,8})", re.IGNORECASE)
_TEXT = re.compile(r'"((?:[^"\\]|\\.)*)"')


class _Entry(NamedTuple):
    """`"name"=value` under a key; `place` is its file and line."""

    name: str
    value: str
    place: str


class Imported(NamedTuple):
    """`devices`: the values to store, by table and entry (None: the default); None for a device to remove.

    `skipped`: the keys and entries that do not belong to CANDRV.
    """

    devices: dict[str, dict[str, Value | None] | None]
    skipped: list[str]


def load(path: Path) -> Imported:
    """Reads a file; raises BadConfig, with the line, if it is no .reg file or a CANDRV entry has an invalid value."""
    found, key, entries = Imported({}, []), "", list[_Entry]()
    for number, line in enumerate(_lines(path), 2):
        place = f"{path}:{number}"
        if _KEY.fullmatch(line):
            _store(found, key, entries)
            key, entries = line, []
        elif entry := _ENTRY.fullmatch(line):
            entries.append(_Entry(_unescaped(entry[1]), entry[2], place))
        elif line and not line.startswith((";", "@")):
            raise BadConfig(f"{place}: {line!r:.60} is neither a key nor an entry of one")
    _store(found, key, entries)
    return found


def _lines(path: Path) -> list[str]:
    """The lines after the first, which is the file's signature; continued lines are joined."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BadConfig(f"{path}: {error.strerror}") from None
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = data.decode("utf-16") if wide else data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    lines = [line.strip() for line in text.replace("\\\r\n", "").replace("\\\n", "").splitlines()]
    if not lines or lines[0] not in _HEADS:
        raise BadConfig(f"{path}:1: a .reg file begins with {' or '.join(map(repr, _HEADS))}")
    return lines[1:]


def _store(found: Imported, key: str, entries: list[_Entry]) -> None:
    """Store the entries under a key, if it is a device of CANDRV."""
    device = _DEVICE.fullmatch(key)
    if device is None or not _is_candrv(device[2], entries):
        if key:
            found.skipped.append(key)
        return
    table = device[2].upper()
    if device[1]:
        found.devices[table] = None
        return
    stored = found.devices.get(table) or {}
    found.devices[table] = stored
    for name, value, place in entries:
        try:
            row = row_of(name)
        except BadValue:
            found.skipped.append(f"{table} {name}={value}")
            continue
        try:
            stored[row.name] = None if value == "-" else row.checked(_value(value))
        except BadValue as error:
            raise BadConfig(f"{place}: {error}") from None


def _is_candrv(key: str, entries: list[_Entry]) -> bool:
    """Whether a key is a device of CANDRV: by its entry Dll, or without that by its name, like CID1."""
    for name, value, _ in entries:
        if name.lower() == "dll":
            return "candrv" in value.lower()
    return DEVICE.fullmatch(key.upper()) is not None


def _value(text: str) -> Value:
    if number := _DWORD.fullmatch(text):
        return int(number[1], 16)
    if string := _TEXT.fullmatch(text):
        return _unescaped(string[1])
    raise BadValue(f"{text!r:.60}: write a text in quotes, dword: and a hex number, or - for the default")


def _unescaped(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text)
