"""Writes docs/vci-map.md: every name of the two VCI manuals, and what it is in canwire.

    python docs/vci_map.py [DIRECTORY OF THE MANUALS]

The script reads the names from the manuals' text (in ../shared/seeds by default) or, without them, from the existing
page. It checks each counterpart in the running package, and fails with the names that have none.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

import name_map
from canwire import vci
from canwire.vci import v3
from name_map import NO_NAME, ROOT, ROW, TABLE, Missing, counterparts

PAGE = ROOT / "docs" / "vci-map.md"
V4_MANUAL, V3_MANUAL = "004_3482d6bb25e02c49.txt", "002_49fc4c60c6d60e35.txt"
V4, V3 = "V4, the C++ manual", "V3, the .NET manual"
KINDS = ["function", "interface", "method", "structure", "field", "constant", "macro", "error code"]
KINDS += ["type", "member", "parameter", NO_NAME]
HEAD = """# The names of VCI, and where they are here

Written by `python docs/vci_map.py` from the text of the two manuals: change that, not this page. {total} names.
[Porting a VCI program](porting-vci.md) shows how to port programs.
"""


class Name(NamedTuple):
    """A name as a manual prints it."""

    manual: str
    kind: str
    text: str


# names that no rule finds, each with the reason

TYPES = {  # of Windows, as the manual uses them
    **dict.fromkeys(("INT64", "LONG", "UINT8", "UINT16", "UINT32", "ULONG"), "`int`"),
    **dict.fromkeys(("PUINT8", "PUINT16", "PUINT32"), "`int`, returned"),
    **dict.fromkeys(("BOOL", "BOOL8", "BOOL32"), "`bool`"),
    **dict.fromkeys(("GUID", "REFCLSID", "REFGUID", "REFIID"), "`uuid.UUID`"),
    "CHAR": "`str`, `bytes`",
    "PCHAR": "`str`",
    "PTCHAR": "`str`, returned",
    "PGUID": "`uuid.UUID`, returned",
    "PVOID": "the result, returned",
    "LUID": "`canwire.vci.VciId`",
    "HANDLE": "`canwire.Event`",
    "HRESULT": "`canwire.vci.VciError`, raised, with its code",
}
MISPRINTS = {  # what is not in the package under the printed name
    "CANBPTABLE": "CANBTPTABLE",
    "CANBTp": "CANBTP",
    "CANCAPABILITIES1": "CANCAPABILITIES",
    "CAN_EXMODE": "CAN_EXMODE_",
    "CAN_OPMODE": "CAN_OPMODE_",
    "ICanChannel1": "ICanChannel",
    "VCI_VERSIONINFO": "VCIVERSIONINFO",
    "vciEnumDevice::Next": "IVciEnumDevice::Next",
    "RemoveMessage": "RemMessage",
    "SendMessage": "StartMessage",
}
PLACES = {  # fields whose union has one property here
    "VCIDEVICEINFO.AsChar": "VciDeviceInfo.hardware_id",
    "VCIDEVICEINFO.AsGuid": "VciDeviceInfo.hardware_id",
}
NOT_IN_THE_MANUAL = {
    "CanMsg2.reserved",  # CANMSG2's reserved word, which only the header has
    "CanMsgInfo.value",  # the union as one word
    "LinMsgInfo.value",
}
MACROS = {"VCI_BUS_CTRL", "VCI_BUS_TYPE", "VCI_CTL_TYPE"}
NO_NAMES = {  # words that look like names
    "CANFD": "CAN FD",
    "CANopen": "a protocol",
    "HKEY_LOCAL_MACHINE": "Windows' registry",
    "IClassFactory": "COM's, which VCI does without",
    "IDispatch": "COM's, which VCI does without",
    "VCI_API": "calling convention of C",
    "CreateEvent": "Windows' own; canwire.Event()",
    "CoInitialize": "COM's, which VCI does without",
}
IRREGULAR = {  # V3: places that follow from no spelling rule
    "CanBitrate.100KBit": "CanBitrate.KBIT_100",
    "CycleTime": "CanCyclicTXMsg.cycle_ticks",
    "CanMessage.Data": "CanMessage.__getitem__",
    "Data": "CanMessage.__getitem__",
    "IBalObject.Resources.Count": "BalResourceCollection.count",
}
V3_TYPES = {
    "Byte": "`int`",
    "GUID": "`uuid.UUID`",
    "UInt32": "`int`",
    "bool": "`bool`",
    "false": "`False`",
    "int": "`int`",
    "true": "`True`",
    "void": "`None`",
}
V3_NO_NAMES = {
    "AutoInitLine": "name of a sample",
    "DoMessages": "name of a sample",
    "Send": "name of a sample",
    "net2": "a directory",
    "vcinet2.chm": "a file",
    "message.Length": "of .NET's arrays; len()",
}


# reading the German V4 manual


def v4_names(text: str) -> Iterator[Name]:
    """Every name of the manual behind its contents; methods, structures and fields from chapters 6 and 7."""
    body = text[text.rindex("\n1 Benutzerführung\n") :]
    reference = body[body.rindex("\n6 Schnittstellenbeschreibung\n") :]
    yield from _signatures(reference)
    yield from _methods_in_prose(body)
    yield from _structures(reference)
    for word in re.findall(r"\bI(?:Unknown|(?:Vci|Fifo|Bal|Can|Lin)[A-Z]\w*)\b", body):
        yield Name(V4, "interface", word)
    for word in re.findall(r"\b\w*(?:CAN|LIN|VCI|BAL|CLSID|IID|HKEY)_\w+", body):
        yield Name(V4, _kind_of_capitals(word), word)
    for word in re.findall(r"\b(?:CAN|LIN|VCI|BAL)[A-Za-z0-9]{2,}\b", body):
        yield Name(V4, NO_NAME if word in NO_NAMES else "structure", word)
    windows = r"(?:P|REF)?(?:U?INT\d+|T?CHAR|GUID|CLSID|IID)|BOOL\d*|PVOID|LUID|HRESULT|U?LONG|HANDLE"
    for word in re.findall(rf"\b(?:(?:P|REF)(?:CAN|LIN|VCI|BAL)[A-Z0-9]+|{windows})\b", body):
        yield Name(V4, "type", word)


def _kind_of_capitals(word: str) -> str:
    if word in NO_NAMES:
        return NO_NAME
    if word == "VCI_OK" or word.startswith("VCI_E_"):
        return "error code"
    if MISPRINTS.get(word) in _STRUCTURES:
        return "structure"
    return "macro" if word in MACROS else "constant"


def _signatures(reference: str) -> Iterator[Name]:
    """`HRESULT Name (` below the heading of an interface, and the headings of methods themselves."""
    owner = ""
    for line in reference.splitlines():
        if heading := re.fullmatch(r"(?:6[.\d]+ )?(?:Schnittstelle )?(I[A-Z][a-z]\w+|IUnknown)", line):
            owner = heading[1]
        elif exported := re.match(r"HRESULT VCI_API (\w+) ?\(", line):
            yield Name(V4, "function", exported[1])
        elif method := re.match(r"(?:HRESULT|ULONG) (\w+) ?\(", line):
            yield Name(V4, "method", f"{owner}::{method[1]}")
        elif title := re.fullmatch(r"(?:6\.2\.\d )?([A-Z][a-z]+(?:[A-Z][a-z]*)+|Next|Skip|Lock|Reset)", line):
            yield Name(V4, "method", f"{owner}::{title[1]}")


def _methods_in_prose(body: str) -> Iterator[Name]:
    for owner, method in re.findall(r"\b(v?[Ii]?[A-Z]?\w+)::(\w+)", body):
        yield Name(V4, "method", f"{owner}::{method}")
    for word in re.findall(r"(?:Funktion|Methode|mit) [*`]([A-Z][a-z]+(?:[A-Z]\w*)?)(?:\(\))?[*`]", body):
        kind = "function" if word.startswith("Vci") else "method"
        yield Name(V4, NO_NAME if word in NO_NAMES else kind, word)


def _structures(reference: str) -> Iterator[Name]:
    """Fields between the braces of a structure, and in the table below it, under the heading of its section."""
    sections = re.split(r"^7\.\d\.\d+ (\w+)$", reference, flags=re.MULTILINE)[1:]
    for structure, text in zip(sections[::2], sections[1::2], strict=True):
        yield Name(V4, "structure", structure)
        block, _, table = text.partition("```\n")[2].partition("```")
        declared = (
            r"\b(?:UINT\d+|INT64|BOOL\d+|LUID|GUID|CHAR|VCIID|CAN\w+|LIN\w+) +(\w+) *(?:\[\w+\])? *(?::|;|\n)"
        )
        for field in re.findall(declared, block):
            yield Name(V4, "field", f"{structure}.{field}")
        for union in re.findall(r"\} (\w+)(?:\[\d+\])?;", block):
            yield Name(V4, "field", f"{structure}.{union}")
        for field in re.findall(r"^<i>([\w.-]+)</i>\t", table, re.MULTILINE):
            yield Name(V4, "field", f"{structure}.{field.replace('-', '')}")


# reading the English V3 manual


def v3_names(text: str) -> Iterator[Name]:
    """Words in italics, lists of properties, and what the samples use."""
    body = text[text.rindex("\n1 System overview\n") :]
    samples = re.findall(r"```\n(.*?)```", body, re.DOTALL)
    prose = re.sub(r"```\n.*?```", "", body, flags=re.DOTALL)
    prose = re.sub(r"(?<=[a-z])-(?=[A-Z][a-z]+[A-Z])", "", prose)  # Max-DelayedTXTicks, at the end of a line
    for pattern in (r"\*([^*\n]+)\*", r"<i>([^<\n]+)</i>", r"`([^`\n]+)`"):
        for words in re.findall(pattern, prose):
            yield from _v3_word(words)
    for word in re.findall(r"^([A-Z][A-Za-z]+): ", prose, re.MULTILINE):
        yield from _v3_word(word)
    for word in re.findall(r"\b[A-Z][a-z]+(?:[A-Z]+[a-z0-9]+)+\b(?:\.\w+)*", prose):
        yield from _v3_word(word)
    for sample in samples:
        code = re.sub(r"//.*|0x\w+", "", sample)
        for word in re.findall(r"(?<![\w.])[A-Za-z]\w*(?:(?:\[\d\])?\.[A-Z]\w*)*", code):
            yield from _v3_word(re.sub(r"\[\d\]", "", word), sample=True)


_VARIABLES = {"control", "data", "i", "id", "index", "message", "messages", "mode", "reader", "writer"}
_WORDS_OF_CODE = {"for", "if", "new", "out", "readCount", "return", "while"}


def _v3_word(words: str, *, sample: bool = False) -> Iterator[Name]:
    """The names in a phrase: `exclusive = false`, `Data[AutoIncrementIndex + 1]`, `Max-DelayedTXTicks`."""
    for word in re.findall(r"[A-Za-z_][\w.]*", words.replace("-", "")):
        owner, dot, member = word.partition(".")
        if word in _WORDS_OF_CODE or (sample and word in _VARIABLES):
            continue
        if sample and owner in _VARIABLES and dot and word not in V3_NO_NAMES:
            yield Name(V3, "member", member)
        elif dot and word in V3_NO_NAMES:
            yield Name(V3, NO_NAME, word)
        elif dot:
            yield Name(V3, "member", word)
            yield Name(V3, "type", owner)
        else:
            yield Name(V3, _v3_kind(word), word)


def _v3_kind(word: str) -> str:
    if word in V3_NO_NAMES:
        return NO_NAME
    if word in V3_TYPES or re.match(r"I?Lin[A-Z](?!ne)", word) or isinstance(getattr(v3, word, None), type):
        return "type"
    return "parameter" if word[0].islower() else "member"


# finding counterparts


def counterpart(name: Name) -> str:
    """What stands in the page's third column; raises Missing."""
    found = _v4(name) if name.manual == V4 else _v3(name)
    if not found:
        raise Missing(f"{name.manual}: {name.kind} {name.text} has no counterpart in canwire")
    return found


def _v4(name: Name) -> str:
    text = MISPRINTS.get(name.text, name.text)
    if name.kind == NO_NAME:
        return NO_NAMES[text]
    if name.kind == "type" and text in TYPES:
        return TYPES[text]
    found = _V4_RULES[name.kind](text)
    return f"{found} (misprint of {text})" if found and text != name.text else found


def _function(text: str) -> str:
    return _shown(vci, _snake(text.removeprefix("Vci")))


def _interface(text: str) -> str:
    return _shown(vci, text.removeprefix("I"))


def _method(text: str) -> str:
    owner, _, method = text.rpartition("::")
    if owner:
        return _shown(vci, f"{owner.removeprefix('I')}.{_snake(method)}")
    return _owners(vci, _snake(text))


def _structure(text: str) -> str:
    cls = _STRUCTURES.get(text)
    return f"`canwire.vci.{cls.__name__}`" if cls else ""


def _field(text: str) -> str:
    if text in PLACES:
        return _shown(vci, PLACES[text])
    structure, _, field = text.partition(".")
    return _listed(
        f"canwire.vci.{cls.__name__}.{attribute}"
        for name, cls in _STRUCTURES.items()
        if name.partition(".")[0] == structure
        for c_name, attribute in cls.FIELDS
        if _same_field(c_name, field)
    )


def _same_field(declared: str, printed: str) -> bool:
    """`Bits.srr` is printed as `srr` too, and `Bits` and `AsLuid` mean all of their fields; SLineStatus happens."""
    declared, printed = declared.lower(), printed.lower()
    return printed in (declared, declared.rpartition(".")[2], declared.partition(".")[0])


def _constant(text: str) -> str:
    if text.endswith("_"):  # the manual's way to mean all that begin so
        return f"`canwire.vci.{text}*`" if any(name.startswith(text) for name in vars(vci)) else ""
    return _shown(vci, text)


def _macro(text: str) -> str:
    return _shown(vci, text.lower())


def _type(text: str) -> str:
    base = re.sub(r"^(?:REF|P)", "", text)
    interfaces = {name.upper(): name for name in vars(vci)}
    return _structure(base) or (_shown(vci, interfaces[base]) if base in interfaces else "")


_STRUCTURES: dict[str, Any] = {
    cls.NAME: cls
    for cls in vars(vci).values()
    if isinstance(cls, type) and issubclass(cls, vci.Structure) and cls is not vci.Structure
}
_V4_RULES: dict[str, Callable[[str], str]] = {
    "function": _function,
    "interface": _interface,
    "method": _method,
    "structure": _structure,
    "field": _field,
    "constant": _constant,
    "macro": _macro,
    "error code": _constant,
    "type": _type,
}


def _v3(name: Name) -> str:
    text = name.text
    if name.kind == NO_NAME:
        return V3_NO_NAMES[text]
    if text in V3_TYPES:
        return V3_TYPES[text]
    if text in IRREGULAR:
        return _shown(v3, IRREGULAR[text])
    if name.kind == "type":
        return _shown(v3, text)
    if name.kind == "parameter":
        return _listed(_parameters(_snake(text)))
    owner, dot, member = text.rpartition(".")
    if dot:
        return next((found for one in _spellings(member) if (found := _shown(v3, f"{owner}.{one}"))), "")
    return next((found for one in _spellings(text) if (found := _owners(v3, one))), "")


def _parameters(name: str) -> Iterator[str]:
    for cls in _classes(v3):
        for method, function in vars(cls).items():
            if (
                inspect.isfunction(function)
                and name in inspect.signature(function).parameters
                and method[0] != "_"
            ):
                yield f"canwire.vci.v3.{cls.__name__}.{method}({name})"


def _owners(module: Any, attribute: str) -> str:
    """The classes of a module that have an attribute, for a name without its owner."""
    classes = _classes(module)
    return _listed(
        f"{module.__name__}.{cls.__name__}.{attribute}"
        for cls in classes
        if hasattr(cls, attribute)
        and not any(hasattr(base, attribute) for base in cls.__mro__[1:] if base in classes)
    )


def _classes(module: Any) -> list[type]:
    ours = (cls for cls in vars(module).values() if isinstance(cls, type))
    return [cls for cls in dict.fromkeys(ours) if cls.__module__.startswith("canwire.vci")]


def _spellings(member: str) -> list[str]:
    """As a property or method, and as a constant or member of an enumeration."""
    constant = re.sub(r"(?<=[a-z])(?=\d)", "_", re.sub("KBit|Kbit", "Kbit", member))
    return [_snake(member), _snake(constant).upper()]


def _snake(name: str) -> str:
    """PEP 8's spelling: GetDataEntry get_data_entry, DelayedTXTimer delayed_tx_timer, operatingMode operating_mode."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def _shown(module: Any, path: str) -> str:
    """The dotted name of something that exists, else nothing."""
    there: Any = module
    for step in path.split("."):
        if step not in getattr(there, "_member_map_", ()) and not hasattr(there, step):
            return ""
        there = getattr(there, step)
    return f"`{module.__name__}.{path}`"


def _listed(places: Iterable[str]) -> str:
    return ", ".join(f"`{place}`" for place in sorted(set(places)))


# the page


def names_of_manuals(seeds: Path) -> list[Name]:
    """In the order of the page: by manual, kind and spelling."""
    read = [
        *v4_names((seeds / V4_MANUAL).read_text(encoding="utf-8")),
        *v3_names((seeds / V3_MANUAL).read_text(encoding="utf-8")),
    ]
    methods = {name.text.rpartition("::")[2] for name in read if "::" in name.text}
    bare = {name for name in read if name.kind == "method" and name.text in methods}  # said of a method above
    return sorted(set(read) - bare, key=_order)


def _order(name: Name) -> tuple[Any, ...]:
    return name.manual == V3, KINDS.index(name.kind), name.text.lower(), name.text


def names_of_page(text: str) -> list[Name]:
    """The names as the page lists them."""
    manual, found = "", []
    for line in text.splitlines():
        if line.startswith("## "):
            manual = line.removeprefix("## ")
        elif row := ROW.match(line):
            kind = _KINDS_OF_V3.get(row[2], row[2]) if manual == V3 else row[2]
            found.append(Name(manual, kind, row[1]))
    return found


def page(names: list[Name]) -> str:
    """The page for these names; raises Missing with all that have no counterpart."""
    rows = counterparts(names, counterpart)
    if untold := _untold(names):
        raise Missing("\n".join(untold))
    lines = [HEAD.format(total=len(rows))]
    for manual in (V4, V3):
        lines += [f"## {manual}", "", *TABLE.splitlines()]
        lines += [
            f"| `{name.text}` | {_shown_kind(name, found)} | {found} |"
            for name, found in rows
            if name.manual == manual
        ]
        lines += [""]
    return "\n".join(lines[:-1]) + "\n"


_KINDS_OF_V3 = {
    "property": "member",
    "method": "member",
    "constant": "member",
    "interface": "type",
    "class": "type",
    "enumeration": "type",
}


def _shown_kind(name: Name, found: str) -> str:
    """What a V3 name is, by its counterpart; V4's names tell themselves."""
    if name.manual == V4 or not found.startswith("`canwire.vci.v3.") or name.kind == "parameter":
        return name.kind
    owner: Any = None
    there: Any = v3
    for step in found.split("`")[1].removeprefix("canwire.vci.v3.").split("."):
        owner, there = there, inspect.getattr_static(there, step)
    if isinstance(there, type):
        kind = "enumeration" if issubclass(there, Enum) else "class"
        return "interface" if re.match("I[A-Z][a-z]", name.text) else kind
    if inspect.isfunction(there) or isinstance(there, classmethod | staticmethod):
        return "method"
    return "constant" if isinstance(there, owner) or not hasattr(type(there), "__get__") else "property"


def _untold(names: list[Name]) -> list[str]:
    """The other way round: fields of the manual's structures that no name on the page leads to."""
    told = {
        place
        for name in names
        if name.kind == "field"
        for place in re.findall(r"`([^`]+)`", counterpart(name))
    }
    printed = {name.text for name in names if name.kind == "structure"}
    return [
        f"{cls.__name__}.{attribute} ({c_name}) is no field of the manual's {name}"
        for name, cls in _STRUCTURES.items()
        if name.partition(".")[0] in printed
        for c_name, attribute in cls.FIELDS
        if f"canwire.vci.{cls.__name__}.{attribute}" not in told
        and f"{cls.__name__}.{attribute}" not in NOT_IN_THE_MANUAL
    ]


if __name__ == "__main__":
    sys.exit(name_map.write(PAGE, names_of_manuals, names_of_page, page))
