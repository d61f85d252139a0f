"""docs/candrv-map.md has every name of the CANDRV manual, and what it says of each is true."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import name_map
from canwire import candrv
from canwire.candrv import win32
from canwire.candrv.registry.settings import ROWS as ENTRIES
from canwire.candrv.text import WORDS
from docs import candrv_map
from tests.cases import each

TEXT: str = candrv_map.PAGE.read_text(encoding="utf-8")
ROWS = [row for line in TEXT.splitlines() if (row := name_map.ROW.match(line))]
PLACES = sorted({place for row in ROWS for place in re.findall(r"`([^`]+)`", row[3])})
MODULE = re.compile(r"canwire\.candrv(?:\.[a-z]\w*)?")
with_manual = pytest.mark.skipif(not name_map.SEEDS.is_dir(), reason="the manual is not here")


def named(*kinds: str) -> list[str]:
    return [row[1] for row in ROWS if row[2] in kinds]


def test_the_page_is_what_the_script_writes() -> None:
    names = candrv_map.names_of_page(TEXT)
    assert len(names) == len(ROWS) > 200
    assert candrv_map.page(names) == TEXT, "run: python docs/candrv_map.py"


@pytest.mark.finding("dialects 7")
@with_manual
@pytest.mark.conforms("FS-13")
def test_the_page_has_every_name_of_the_manual() -> None:
    assert candrv_map.page(candrv_map.names_of_manual(name_map.SEEDS)) == TEXT, (
        "run: python docs/candrv_map.py"
    )


@pytest.mark.conforms("FS-13")
def test_every_row_names_a_counterpart() -> None:
    assert all("`" in row[3] for row in ROWS)


@pytest.mark.conforms("FS-13")
def test_every_counterpart_exists() -> None:
    source = source_of_commands()

    def there(place: str) -> bool:
        if not place.startswith("canwire candrv "):
            return exists(place)
        verb, _, switch = place.removeprefix("canwire candrv ").partition(" ")
        return bool(re.search(rf"canwire candrv (?:\w+\|)*{verb}\b", source)) and switch in source

    assert len(PLACES) > 100
    assert [place for place in PLACES if not there(place)] == []


def source_of_commands() -> str:
    """All files of the command; skipped while it is not there yet."""
    command = pytest.importorskip("canwire.commands.candrv.verb")
    folder = Path(command.__file__ or "").parent
    return "".join(path.read_text(encoding="utf-8") for path in sorted(folder.rglob("*.py")))


def exists(place: str) -> bool:
    """A dotted name, imported and walked; `name(parameter)`, too. Modules that are not there yet are skipped."""
    path, _, parameter = place.rstrip(")").partition("(")
    found = MODULE.match(path)
    assert found, place
    there: Any = pytest.importorskip(found[0])
    for step in path.removeprefix(found[0]).strip(".").split("."):
        if step and not hasattr(there, step):
            return False
        there = getattr(there, step) if step else there
    return not parameter or parameter in inspect.signature(there).parameters


@pytest.mark.conforms("FS-13")
def test_constants_and_structures_have_their_own_names() -> None:
    names = named("structure", "constant", "error")
    assert [name for name in names if name not in candrv.__all__ or getattr(candrv, name) is None] == []


@pytest.mark.conforms("FS-13")
def test_functions_have_their_own_names() -> None:
    assert inspect.isfunction(candrv.CTL_CODE)
    ours = [name for name in named("function") if name != "CTL_CODE"]
    assert [name for name in ours if not inspect.isfunction(getattr(win32, name, None))] == []


@pytest.mark.conforms("FS-13")
def test_the_other_way_round_nothing_is_made_up() -> None:
    told = {row[1] for row in ROWS}
    structures = [getattr(candrv, name) for name in named("structure")]
    assert len(structures) == 6
    for structure in structures:
        assert {f"{structure.__name__}.{field}" for field in structure.OFFSETS} <= told
    constants = importlib.import_module("canwire.candrv.constants")
    ours = {name for name in vars(constants) if re.fullmatch(r"[A-Z][A-Z0-9_]+", name)}
    made_up = {name for name in ours - told if not name.startswith("ERROR_")}
    win32 = {"CREATE_NEW", "OPEN_ALWAYS", "TRUNCATE_EXISTING"}  # what CreateFile refuses, and takes besides
    assert made_up == {"EVERY_EVENT", "MESSAGE_EVENTS", "NOT_IN_TABLE"} | win32
    assert {name for name, row in ENTRIES.items() if not row.ours} == set(named("registry entry")) - {"IoCtl"}
    assert {*WORDS.values(), "unknown event"} == set(named("event word"))


@with_manual
def test_the_script_reads_all_of_them() -> None:
    """Counted another way."""
    text = (name_map.SEEDS / candrv_map.MANUAL).read_text(encoding="utf-8")
    listed = text[text.index("Function Description ") : text.index("Table 8:")]
    assert len(re.findall(r"^\w+\(\) ", listed, re.MULTILINE)) == 10
    assert len(named("function")) == 10 + 2  # GetLastError, CTL_CODE
    assert len(re.findall(r"^#define IOCTL_CAN_", text, re.MULTILINE)) == 19
    assert len([name for name in named("constant") if name.startswith("IOCTL_CAN_")]) == 19
    assert len(re.findall(r"\bCANBUS_EVENT_\w+ = 0x", text)) == 11
    assert len([name for name in named("constant") if name.startswith("CANBUS_EVENT_")]) == 11
    assert len(named("field")) == 2 + 2 + 5 + 5 + 10 + 5
    assert len(named("registry entry")) == 23 + 2  # UseTxIRQ, and IoCtl is Ioctl


@each(
    ("kind", "text"),
    [
        ("function", "SetColour"),
        ("parameter", "SetColour(hDevice)"),
        ("structure", "CAN_COLOUR"),
        ("field", "CAN_EVENT.colour"),
        ("constant", "CANBUS_CMD_COLOUR"),
        ("error", "ERROR_COLOUR"),
        ("type", "PCAN_COLOUR"),
        ("event word", "coloured"),
        ("registry entry", "Colour"),
        ("program", "CanColour"),
        ("switch", "CanWrite -c"),
        ("file", "colour.h"),
        ("no name", "Colour"),
    ],
)
def test_a_name_without_counterpart_stops_the_script(kind: str, text: str) -> None:
    with pytest.raises(name_map.Missing, match=re.escape(text)):
        candrv_map.page([*candrv_map.names_of_page(TEXT), name_map.Name(kind, text)])


@with_manual
@pytest.mark.parametrize(
    ("before", "after", "missing"),
    [
        ("CAN_UINT arbitration;", "CAN_UINT arbitration;\n CAN_UINT colour;", "CAN_EVENT.colour"),
        (" CANBUS_EVENT_OVERRUN = 0x040,", " CANBUS_EVENT_COLOUR = 0x800,", "CANBUS_EVENT_COLOUR"),
        ("#define IOCTL_CAN_INIT", "#define IOCTL_CAN_COLOUR", "IOCTL_CAN_COLOUR"),
        ("CloseHandle() Closes", "SetColour() Closes", "SetColour"),
        ("HANDLE hDevice, LPVOID lpBuffer,", "HANDLE hDevice, LPVOID lpColour,", None),
        ("ERROR_TIMEOUT", "ERROR_COLOUR", "ERROR_COLOUR"),
        ("Virtualize DWOR", "Colour DWOR", "Colour"),
        ("overrun\\t<time_high>", "coloured\\t<time_high>", "coloured"),
        ('_T("  -f <name>', '_T("  -c <name>', "CanWrite -c"),
        ("CanMon Command line tool", "CanColour Command line tool", "CanColour"),
    ],
)
def test_a_name_new_in_the_manual_is_found(
    before: str, after: str, missing: str | None, tmp_path: Path
) -> None:
    text = (name_map.SEEDS / candrv_map.MANUAL).read_text(encoding="utf-8")
    place = re.search(r"\s+".join(map(re.escape, before.split(" "))), text) if " " in before else None
    found = place[0] if place else before
    assert found in text
    (tmp_path / candrv_map.MANUAL).write_text(text.replace(found, after, 1), encoding="utf-8")
    if missing is None:
        assert name_map.Name("parameter", "WriteFile(lpColour)") in candrv_map.names_of_manual(tmp_path)
        return
    with pytest.raises(name_map.Missing, match=re.escape(missing)):
        candrv_map.page(candrv_map.names_of_manual(tmp_path))
