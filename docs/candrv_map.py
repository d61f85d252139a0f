"""Writes docs/candrv-map.md: every name of the CANDRV manual, and what it is in canwire.

    python docs/candrv_map.py [DIRECTORY OF THE MANUALS]

The script reads the names from the manual's text (in ../shared/seeds by default) or, without that, from the existing
page. It fails with the names that have no counterpart; tests/docs/test_candrv_map.py checks each counterpart in the
running package.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import name_map
from name_map import NO_NAME, ROOT, Missing, Name, names_of_page, ordered

PAGE = ROOT / "docs" / "candrv-map.md"
MANUAL = "000_c4a7ca42d189c1e6.txt"
KINDS = ["function", "parameter", "structure", "field", "constant", "error", "type", "event word"]
KINDS += ["registry entry", "program", "switch", "file", NO_NAME]
HEAD = """# The names of CANDRV, and where they are here

Written by `python docs/candrv_map.py` from the text of the CANDRV manual: change that, not this page.
{total} names.

"""


# reading the manual

REPAIRS = {
    "CANBUS_EVENT_CHANGED": "CANBUS_EVENT_DEVICE_CHANGED",  # the table of icons
    "CANBUS_EVENT_TRANSMIT": "CANBUS_EVENT_TRANSMITTED",  # a drawing breaks it
    "CAN_ACCEPTANCE_MASK": "CAN_ACCEPTANCE_FILTER",  # 8.12
    "QueuePriority256": "Priority256",  # the line above ends the description of another entry
    "DescriptionPrefix": "Prefix",
}
STRUCTURES = r"CAN_(?:ACCEPTANCE_(?:FILTER|MASK)|EVENT|PROPERTIES|TIME|TRANSMIT_DATA)"
TYPES = r"CAN_(?:DWORD|BYTE|UINT|INT)|LPSECURITY_ATTRIBUTES"
CONSTANTS = r"(?:CANBUS|IOCTL_CAN|CAN|GENERIC|FILE|METHOD|MAX|OPEN|CREATE|INVALID|VK)_\w+|INFINITE"


def names_of_manual(seeds: Path) -> list[Name]:
    """In the order of the page: by kind and spelling."""
    raw = re.sub(r"<\|.*?\|>", "\n", (seeds / MANUAL).read_text(encoding="utf-8"))
    text = re.sub(r"(\w) ?\s*\n\s*(_[A-Z])", r"\1\2", raw)  # tables break names before underscores
    found = {
        *_structures(text),
        *_constants(text),
        *_functions(text),
        *_words(text),
        *_entries(raw),
        *_programs(text),
    }
    return ordered(found, KINDS)


def repaired(raw: str) -> str:
    """The name as it is meant."""
    return REPAIRS.get(raw, raw)


def _structures(text: str) -> Iterator[Name]:
    declaration = r"typedef struct (\w+)\s*\{(.*?)\}(?: (\w+), \*(\w+);)?"
    for tag, block, name, pointer in re.findall(declaration, text, re.DOTALL):
        structure = name or tag.removeprefix("tag")  # 8.22 leaves the name away
        yield Name("structure", structure)
        yield Name("type", tag)
        if pointer:
            yield Name("type", pointer)
        for field in re.findall(r"^\s*(?!/)\w+ (\w+)(?:\[\w+\])?;", block, re.MULTILINE):
            yield Name("field", f"{structure}.{field}")
    for raw in re.findall(rf"\b{STRUCTURES}\b", text):
        yield Name("structure", repaired(raw))
    for raw in re.findall(rf"\benum (\w+)|\b({TYPES})\b", text):
        yield Name("type", "".join(raw))


def _constants(text: str) -> Iterator[Name]:
    for raw in re.findall(rf"\b(?:{CONSTANTS})\b", text):
        name = repaired(raw)
        if name.endswith("_") or re.fullmatch(rf"{STRUCTURES}|{TYPES}", name):
            continue
        yield Name(NO_NAME if name in NO_NAMES else "constant", name)
    for raw in re.findall(r"\bERROR_\w+", text):
        yield Name("error", raw)


def _functions(text: str) -> Iterator[Name]:
    signature = r"Signature: \n(?:BOOL|HANDLE|int) (\w+)\((.*?)\);"
    for name, parameters in re.findall(signature, text, re.DOTALL):
        yield Name("function", name)
        for parameter in re.findall(r"\w+ (\w+)\s*(?:,|$)", parameters.strip()):
            yield Name("parameter", f"{name}({parameter})")
    listed = text[text.index("Function Description \n") : text.index("Table 8:")]
    for raw in re.findall(r"^(\w+)\(\) ", listed, re.MULTILINE):
        yield Name("function", raw)
    for raw in re.findall(r"\b(Get(?:LastError|AsyncKeyState)|CTL_CODE)\b", text):
        yield Name(NO_NAME if raw in NO_NAMES else "function", raw)


def _words(text: str) -> Iterator[Name]:
    listed = text[text.index("Event Format: \n") : text.index("Here the fields have the following meaning")]
    for raw in re.findall(r"^([a-z][a-z ]+?)(?: <ev>)?\\t<time_high>", listed, re.MULTILINE):
        yield Name("event word", raw)


def _entries(text: str) -> Iterator[Name]:
    """The table of 6.2, where a name may go over two lines, and what 6.3 adds."""
    table = text[
        text.index("Entry Type Value Description") : text.index("(*) Registry entry available since")
    ]
    lines = "\n".join(line.strip() for line in table.splitlines() if line.strip())
    for first, second in re.findall(
        r"^(?:([A-Z][A-Za-z]+)-?\n)?(\w+)\s(?:String|DWOR)\b", lines, re.MULTILINE
    ):
        yield Name("registry entry", repaired(first + second))
    details = text[text.index("6.3 Detailed Description of") : text.index("7 Using the CAN Driver")]
    for raw in re.findall(r"^(\w+)(?: \(obsolete\))? ?\n(?:\n)?(?=[A-Z])", details, re.MULTILINE):
        if raw in ("IoCtl", "UseTxIRQ"):
            yield Name("registry entry", raw)


def _programs(text: str) -> Iterator[Name]:
    listed = text[text.index("Program Description \n") : text.index("Table 12:")]
    for raw in re.findall(r"^(Can[A-Z][a-z]+) ", listed, re.MULTILINE):
        yield Name(NO_NAME if raw in NO_NAMES else "program", raw)
    for program in ("CanWrite", "CanRead"):
        source = text[text.index(f'_T("{program} V3.0') :]
        source = source[: source.index("return 0;")]
        for raw in re.findall(r'_T\("  -(\w)', source) + re.findall(r"\(\*p == '(.)'\)", source):
            yield Name("switch", f"{program} -{raw}")
    for raw in ("canbusio.h", "candrv.cab", "candrv.dll"):
        if raw in text:
            yield Name("file", raw)


# counterparts: by rule where the name is the same, by table elsewhere

NO_NAMES = {
    "CanCheck": "its dialogs are a window's; what they set and show: `canwire candrv registry`, `canwire candrv mon`",
    "GetAsyncKeyState": "the console's; Ctrl-C ends `canwire candrv read`",
    "VK_CONTROL": "the console's; Ctrl-C ends `canwire candrv read`",
}
PROGRAMS = {"CanWrite": "write", "CanRead": "read", "CanSend": "send", "CanMon": "mon"}
TABLES = {
    "type": {
        "t_canbus_events": "`canwire.candrv.CanbusEvent`",
        "t_canbus_commands": "`canwire.candrv.Command`",
        "_COMMTIMEOUTS": "`canwire.candrv.COMMTIMEOUTS`",
        "LPSECURITY_ATTRIBUTES": "any object: `canwire.candrv.win32.CreateFile(lpSecurity)`, which means nothing",
    },
    "program": {name: f"`canwire candrv {verb}`" for name, verb in PROGRAMS.items()},
    "switch": {
        f"{name} -{letter}": f"`canwire candrv {PROGRAMS[name]} -{letter}`"
        for name in ("CanWrite", "CanRead")
        for letter in "dbfh?"
    },
    "file": {
        "canbusio.h": "`canwire.candrv`",
        "candrv.cab": "`canwire.candrv.RegistryStore.install`",
        "candrv.dll": "`canwire.candrv.Settings.dll`",
    },
    NO_NAME: NO_NAMES,
}
WIN32 = {
    *("CreateFile", "CloseHandle", "ReadFile", "WriteFile", "DeviceIoControl", "SetCommTimeouts"),
    *("GetCommTimeouts", "SetCommMask", "GetCommMask", "WaitCommEvent", "GetLastError"),
}


def counterpart(name: Name) -> str:
    """The text of the page's third column; raises Missing."""
    from canwire import candrv
    from canwire.candrv.registry.settings import FIELDS, row_of
    from canwire.candrv.text import WORDS

    kind, text = name
    if text in TABLES.get(kind, {}):
        return TABLES[kind][text]
    if kind in ("function", "parameter") and text.partition("(")[0] in WIN32:
        return f"`canwire.candrv.win32.{text}`"
    if kind == "event word" and text in {*WORDS.values(), "unknown event"}:
        return "`canwire.candrv.text.WORDS`"
    if kind == "registry entry" and text.lower() in map(str.lower, FIELDS):
        return f"`canwire.candrv.Settings.{FIELDS[row_of(text).name]}`"
    there = getattr(candrv, text.removeprefix("tag").partition(".")[0], None)
    named = kind in ("structure", "constant", "error", "type", "field", "function") and there is not None
    if named and ("." not in text or hasattr(there, text.partition(".")[2])):
        return f"`canwire.candrv.{text.removeprefix('tag')}`"
    raise Missing(f"{kind} {text} has no counterpart in canwire")


# the page


def page(names: Iterable[Name]) -> str:
    """The page for these names; raises Missing with all that have no counterpart."""
    return name_map.page(HEAD, names, counterpart)


if __name__ == "__main__":
    sys.exit(name_map.write(PAGE, names_of_manual, names_of_page, page))
