"""Writes docs/acan-map.md: every name of the INduCAN104 manual, and what it is in canwire.

    python docs/acan_map.py [DIRECTORY OF THE MANUALS]

The script reads the names from the manual's text (in ../shared/seeds by default) or, without that, from the existing
page. The text is scanned: REPAIRS has the correct spelling of misread names. The script fails with the names that have
no counterpart; tests/docs/test_acan_map.py checks each counterpart in the running package.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import name_map
from name_map import NO_NAME, ROOT, Missing, Name, names_of_page, ordered

PAGE = ROOT / "docs" / "acan-map.md"
MANUAL = "001_da5ff3b4467419d6.txt"
KINDS = ["function", "parameter", "structure", "field", "constant", "type", "register", "interrupt"]
KINDS += ["service", "assembly name", "program", "switch", "setting", "menu", "key", "file", NO_NAME]
HEAD = """# The names of ACAN, and where they are here

Written by `python docs/acan_map.py` from the text of the INduCAN104 manual: change that, not this page.
{total} names.

"""


# what scanning made of letters, blanks taken out

REPAIRS = {
    "ACAN_AIIocFixedMemory": "ACAN_AllocFixedMemory",
    "ACAN_BusContral": "ACAN_BusControl",
    "ACAN_GetlInitStatus": "ACAN_GetInitStatus",
    "ACAN_GetlnitStatus": "ACAN_GetInitStatus",
    "ACAN_GETVERSION1": "ACAN_GET_VERSION_1",
    "ACRO": "ACR0",
    "AMRO": "AMR0",
    "SIW": "SJW",
    "BUS_CFF": "BUS_OFF",
    "BUSON": "BUS_ON",
    "HW\\D": "HWND",
    "IDA_CHANRCYV": "IDA_CHANRCV",
    "UlNT": "UINT",
    "LPVOD": "LPVOID",
    "PACAND": "PACANID",
    "tACANH": "tACANHI",
    "bReservedO": "bReserved0",
    "dwReservedO": "dwReserved0",
    "dwReservedl": "dwReserved1",
    "dwReserved?2": "dwReserved2",
    "dwiXor": "dwXor",
    "dwid": "dwID",
    "hi_bimand": "hi_bim",
    "hi_mm": "hi_mim",
    "hi_mv": "hi_miv",
    "hi_nim": "hi_mim",
    "hi_nsi": "hi_msi",
    "hi_tsl": "hi_ts1",
    "hwhd": "hwnd",
    "th_sca": "tb_sca",
    "wrTid": "wTid",
    "wRMBCccupation": "wRMBOccupation",
    "WRMBCccupation": "wRMBOccupation",
    "WRMBSIze": "wRMBSize",
    "WRIndex": "wRIndex",
    "WWndex": "wWIndex",
    "WWindex": "wWIndex",
    "WWIndex": "wWIndex",
    "lpRVB": "lpRMB",
    "Irgq": "Irq",
    "IrgRoutines": "IrqRoutines",
    "/l": "/I",
    "IR": "/R",
}
CONSTANTS = r"(?:SC|TBS|TBNT|IDA|FF|BUS|CANC)[_ ] ?[A-Z0-9]+"
TYPES = r"DWORD|WORD|BYTE|LPVOI?D|LPBYTE|HWND|HW\\D|HANDLE|U[Il]NT|BOOL|ACANCBFN"


# reading the manual


def names_of_manual(seeds: Path) -> list[Name]:
    """In the order of the page: by kind and spelling."""
    text = (seeds / MANUAL).read_text(encoding="utf-8")
    text = re.sub(r"<\|.*?\|>", "\n", text)  # between pages
    text = re.sub(r"(?<=M) (?=essage|emory|sg\b)|(?<=\bL) (?=PACAN)", "", text).replace("Ack-\n", "Ack")
    programming = text[text.index("\nDATA STRUCTURES\n") :]
    found = {
        *_structures(programming),
        *_constants(programming),
        *_functions(text),
        *_types(programming),
        *_registers(programming),
        *_assembly(text[text.index("ANNEX A :") :]),
        *_programs(text),
    }
    return ordered(found, KINDS)


def repaired(raw: str) -> str:
    """The name without the blanks and the mistakes of scanning."""
    compact = re.sub(r"\s", "", raw)
    compact = re.sub(r"^(?:\|D|lD)(?=A_)", "ID", compact)
    compact = re.sub(r"^[I|]p(?=[A-Z])", "lp", compact)
    compact = re.sub(r"^(SC|TBS|TBNT|IDA|BUS)(?=[A-Z]{2,}$)", r"\1_", compact.replace("|", "I"))
    return REPAIRS.get(compact, compact)


def _structures(text: str) -> Iterator[Name]:
    declaration = r"typedef struct (t ?\w+) \{(.*?)\} ([\w ]+), \* ?([\w ]+) ?;"
    for tag, block, structure, pointer in re.findall(declaration, text, re.DOTALL):
        yield Name("structure", repaired(structure))
        yield Name("type", repaired(tag))
        yield Name("type", repaired(pointer))
        for type_, field in _fields(block):
            yield Name("field", f"{repaired(structure)}.{repaired(field)}")
            yield Name("type", repaired(type_))


def _fields(block: str) -> Iterator[tuple[str, str]]:
    """Type and name line by line; they may be on separate lines, and semicolons may be missing."""
    type_ = ""
    for line in re.sub(r"/\* (?=ACANI)", "", block).splitlines():
        code = re.sub(r"\s|;|\[.*|/\*.*", "", line)
        found = re.match(rf"({TYPES}|ACANID(?=id))(.*)", code)
        if line.startswith("#") or not code or code[0] in "<*":
            continue
        type_, code = (found[1], found[2]) if found else (type_, code)
        if code:
            yield type_, code


def _constants(text: str) -> Iterator[Name]:
    value = r"(?:0x[0-9A-F]+|\d\b|si ?zeof|hi_hsb)"
    for raw in re.findall(rf"^#\s*def[ i]*ne\s+(.+?)\s+{value}", text, re.MULTILINE):
        name = repaired(raw)
        yield Name("field", f"ACANHI.{name}") if name.startswith("hi_") else Name("constant", name)
    for raw in re.findall(rf"^({CONSTANTS})\s*=? ?{value}", text, re.MULTILINE):
        yield Name("constant", repaired(raw))
    for raw in re.findall(r"\b(?:SC|TBS|TBNT|IDA|FF|CANC)_ ?[A-Z0-9]{2,}\b|\bBUS ?_O(?:N|FF)\b", text):
        yield Name("constant", repaired(raw))
    for raw in re.findall(r"\bhi_\w+", text):
        yield Name("field", f"ACANHI.{repaired(raw)}")


def _functions(text: str) -> Iterator[Name]:
    for raw in re.findall(r"ACAN_ ?[A-Z][A-Z]?[a-z]\w+", text):
        if raw != "ACAN_Xxx":
            yield Name("function", repaired(raw))
    for raw, parameters in re.findall(r"ACANAPI (ACAN_ ?\w+) ?\(([^)]*)\)", text):
        for one in parameters.split(","):
            if one.strip() != "void":
                yield Name("parameter", f"{repaired(raw)}({repaired(one.split()[-1])})")


def _types(text: str) -> Iterator[Name]:
    listed = text[text.index("following definitions:") : text.index("\nACAN_Init\n")]
    for raw in re.findall(r"^((?!XXX)[A-Z]{2,})\s", listed, re.MULTILINE):
        yield Name("type", raw)
    for raw in re.findall(rf"\b(?:L?PACAN\w+|{TYPES})\b", text):
        yield Name("type", repaired(raw))
    for raw in re.findall(r"^\} (\w+);$", text, re.MULTILINE):
        yield Name("type", raw)


def _registers(text: str) -> Iterator[Name]:
    table = text[text.index("\nRegister | Programming") : text.index("\nFollowing checks")]
    for raw in re.findall(r"^([A-Z]{3,4}[0-9O]?) ", table, re.MULTILINE):
        yield Name("register", repaired(raw))
    for raw in re.findall(r"^[0-7] ?\| ?([A-Z]+IE)\b", text, re.MULTILINE):
        yield Name("interrupt", raw)


def _assembly(text: str) -> Iterator[Name]:
    for raw in re.findall(r"^# ?(ACAN_[A-Z_]+)(?=[ ,])|(ACAN_GET VERSION 1)", text, re.MULTILINE):
        yield Name("service", repaired("".join(raw)))
    for number in re.findall(r"^INT 2D, AH = multiplex, AL ?= ?(\d+)", text, re.MULTILINE):
        yield Name("service", f"INT 2D, AL = {number}")
    for raw in re.findall(r"\bt[bh]_[a-z]+\b|\b(?:his|tbs|ambs)\b", text):
        yield Name("assembly name", repaired(raw))


def _programs(text: str) -> Iterator[Name]:
    for stem, ending in re.findall(r"\b([A-Z][A-Z0-9]+) ?\.(EXE|DLL|LIB|INI|BAT|386|VXD|INC|H)\b", text):
        name = Name("file", f"{stem}.{ending}")
        yield Name(NO_NAME, name.text) if name.text in NO_NAMES else name
        if ending == "EXE" and stem != "ADTM":
            yield Name("program", stem)
    options = text[text.index("CANTERM options are:") : text.index("<clock> can be used")]
    for raw in re.findall(r"^(/\w|IR)[: ]", options, re.MULTILINE):
        yield Name("switch", f"CANTERM {repaired(raw)}")
    for program, words in re.findall(r"^(WCT|ACAN|SETUP)((?: [/\[]*[/<]\S+)+)", text, re.MULTILINE):
        for raw in re.findall(r"<\w+>" if program == "SETUP" else r"/\w(?=:|$)", words):
            yield Name("switch", f"{program} {repaired(raw).replace('irg', 'irq')}")
    for section, lines in re.findall(r"^\[(WCT|ACAN)\]\n\s*((?:[\w ]+=.*\s+)+)", text, re.MULTILINE):
        for raw in re.findall(r"^([\w ]+)=", lines, re.MULTILINE):
            yield Name("setting", f"[{section}] {repaired(raw)}")
    for raw in re.findall(r"^(Ir[gq]\w+)=\d", text, re.MULTILINE):
        yield Name(NO_NAME, repaired(raw))
    for raw in re.findall(r"\b(?:File|Control|Options)/[A-Z][A-Za-z]+(?: to\.\.\.)?", text):
        yield Name("menu", raw)
    for raw in re.findall(r"\bCTRL-[A-Z]\b", text):
        yield Name("key", raw)
    for raw in re.findall(r"\bADTM ?_[a-z_]+", text):
        yield Name(NO_NAME, repaired(raw))


# counterparts: by rule where the name is the same, by table elsewhere

NO_NAMES = {
    "ADTM.EXE": "another product: canwire has threads in place of its MS-DOS tasks",
    "ADTM.INI": "belongs to ADTM",
    "SYSTEM.INI": "belongs to Windows; ACAN's section in it: `canwire.acan.install.Installation.from_ini`",
    "IrqRoutines": "belongs to ADTM",
    "Irqs": "belongs to ADTM",
    "ADTM_get_tid": "belongs to ADTM; any number will do",
    "ADTM_notify_event": "belongs to ADTM; `canwire.acan.Int2d` calls its `notify_event`",
    "ADTM_start_task": "belongs to ADTM; a thread",
    "ADTM_wait_event": "belongs to ADTM; `canwire.acan.task_block.TaskBlock.wait`",
}
TABLES = {
    "type": {
        "tACANHI": "`canwire.acan.ACANHI`",
        "tACANMB": "`canwire.acan.ACANMB`",
        "tACANID": "`canwire.acan.ACANID`",
        "tACANTB": "`canwire.acan.ACANTB`",
        "ACANID": "`canwire.acan.ACANID`",
        "PXXX": "the object itself",
        "FPXXX": "the object itself; in `canwire.acan.ByteMemory` a `canwire.acan.FarPointer`",
        "LPXXX": "the object itself; in `canwire.acan.ByteMemory` a `canwire.acan.FarPointer`",
        "ACANAPI": "calling convention of C",
        "CALLBACK": "calling convention of C",
    },
    "service": {
        "INT 2D, AL = 00": "`canwire.acan.Int2d.interrupt`",
        "INT 2D, AL = 01": "`canwire.acan.Int2d.interrupt`",
        "INT 2D, AL = 02": "`canwire.acan.Int2d.interrupt`",
        "INT 2D, AL = 04": "`canwire.acan.Int2d.interrupt`",
    },
    "assembly name": {
        "his": "`canwire.acan.ACANHI.pack`",
        "tbs": "`canwire.acan.ACANTB.pack`",
        "ambs": "`canwire.acan.ACANMB.pack`",
        "tb_wsta": "`canwire.acan.ACANTB.wStatus`",
        "tb_sta": "`canwire.acan.ACANTB.wStatus`, low byte: `canwire.acan.BlockStatus`",
        "tb_sca": "`canwire.acan.ACANTB.wStatus`, high byte: `canwire.acan.Condition`",
    },
    "program": {
        "ACAN": "`canwire acan install`",
        "SETUP": "`canwire acan setup`",
        "CANTERM": "`canwire acan term`",
        "WCT": "`canwire acan wct`",
        "WCT32": "`canwire acan wct`",
        "CANSPY": "`canwire acan spy`",
        "CANSPY32": "`canwire acan spy`",
    },
    "switch": {
        **{f"CANTERM /{letter}": f"`canwire acan term /{letter}`" for letter in "CREIL"},
        **{f"WCT /{letter}": f"`canwire acan wct /{letter}`" for letter in "CR"},
        **{f"ACAN /{letter}": f"`canwire acan install /{letter}`" for letter in "PIU"},
        **dict.fromkeys(("SETUP <port>", "SETUP <irq>", "SETUP <directory>"), "`canwire acan setup`"),
    },
    "setting": {
        **{
            f"[WCT] {name}": f"`canwire.commands.acan.wct.Settings.{name.lower()}`"
            for name in ("Clock", "Rate", "Local", "Target", "Echo", "Loop")
        },
        "[ACAN] Base": "`canwire.acan.install.Installation.from_ini`",
        "[ACAN] Irq": "`canwire.acan.install.Installation.from_ini`",
    },
    "menu": {
        "Options/CAN": "`canwire.commands.acan.wct.Wct.apply`",
        "File/Quit": "`canwire.commands.acan.wct.Wct.stop`",
        "File/Redirect to...": "`canwire.commands.acan.spy.Trace.redirect`",
        "Control/Trace": "`canwire.commands.acan.spy.Spy.toggle`",
        "Control/Clear": "`canwire.commands.acan.spy.Trace.clear`",
        "Control/Send": "`canwire.commands.acan.spy.Spy.send`",
    },
    "key": dict.fromkeys(("CTRL-C", "CTRL-T", "CTRL-U"), "`canwire acan term`, `canwire acan wct`"),
    "file": {
        "ACAN.H": "`canwire.acan`",
        "ACAN.INC": "`canwire.acan.int2d`",
        **dict.fromkeys(("ACAN.EXE", "VACAND.386", "VACAND.VXD"), "`canwire.acan.driver`"),
        **dict.fromkeys(
            ("ACAN.LIB", "ACANN.LIB", "ACANF.LIB", "ACANX.LIB", "ACAN32.LIB", "ACAN.DLL", "ACAN32.DLL"),
            "`canwire.acan.api`",
        ),
        "CANTERM.EXE": "`canwire acan term`",
        **dict.fromkeys(("WCT.EXE", "WCT32.EXE"), "`canwire acan wct`"),
        **dict.fromkeys(("CANSPY.EXE", "CANSPY32.EXE"), "`canwire acan spy`"),
        "WCT.INI": "`canwire.commands.acan.wct.read_settings`",
        **dict.fromkeys(("SETUP.EXE", "SETUP.BAT", "START.BAT", "STOP.BAT"), "`canwire acan setup`"),
    },
    NO_NAME: NO_NAMES,
}
FUNCTIONS = {
    *("ACAN_Init", "ACAN_GetDriverVersion", "ACAN_GetInitStatus", "ACAN_SetHardConfig", "ACAN_GetHardConfig"),
    *("ACAN_BusControl", "ACAN_Register", "ACAN_AckEvent", "ACAN_AckEventCheck", "ACAN_Deregister"),
    *(
        "ACAN_SendMessage",
        "ACAN_RetrieveMessages",
        "ACAN_AllocFixedMemory",
        "ACAN_FreeFixedMemory",
        "ACAN_Exit",
    ),
}
REGISTERS = {"TSEG1", "TSEG2", "SJW", "SAM", "BRP", "OCR", "IER"}
REGISTERS |= {f"{name}{number}" for name in ("ACR", "AMR") for number in range(4)}


def counterpart(name: Name) -> str:
    """What stands in the page's third column; raises Missing."""
    from canwire import acan

    kind, text = name
    if text in TABLES.get(kind, {}):
        return TABLES[kind][text]
    if kind in ("function", "parameter") and text.partition("(")[0] in FUNCTIONS:
        return f"`canwire.acan.api.{text}`"
    if kind == "register" and text in REGISTERS:
        return "`canwire.acan.HardConfig.registers`"
    if kind == "interrupt" and text in acan.Interrupt.__members__:
        return f"`canwire.acan.Interrupt.{text}`"
    structure, dot, field = text.partition(".")
    there = getattr(acan, structure, None)
    named = kind in ("structure", "constant", "type", "service", "field") and there is not None
    if named and (not dot or hasattr(there, field)):
        return f"`canwire.acan.{text}`"
    raise Missing(f"{kind} {text} has no counterpart in canwire")


# the page


def page(names: Iterable[Name]) -> str:
    """The page for these names; raises Missing with all that have no counterpart."""
    return name_map.page(HEAD, names, counterpart)


if __name__ == "__main__":
    sys.exit(name_map.write(PAGE, names_of_manual, names_of_page, page))
