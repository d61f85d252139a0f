"""docs/acan-map.md has every name of the INduCAN104 manual, and what it says of each is true."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import name_map
from canwire import acan
from docs import acan_map
from tests.cases import each

TEXT: str = acan_map.PAGE.read_text(encoding="utf-8")
ROWS = [row for line in TEXT.splitlines() if (row := name_map.ROW.match(line))]
PLACES = sorted({place for row in ROWS for place in re.findall(r"`([^`]+)`", row[3])})
MODULE = re.compile(r"canwire\.(?:commands\.acan\.\w+|acan(?:\.[a-z]\w*)?)")
with_manual = pytest.mark.skipif(not name_map.SEEDS.is_dir(), reason="the manual is not here")


def test_the_page_is_what_the_script_writes() -> None:
    names = acan_map.names_of_page(TEXT)
    assert len(names) == len(ROWS) > 200
    assert acan_map.page(names) == TEXT, "run: python docs/acan_map.py"


@with_manual
@pytest.mark.conforms("AC-37")
def test_the_page_has_every_name_of_the_manual() -> None:
    assert acan_map.page(acan_map.names_of_manual(name_map.SEEDS)) == TEXT, "run: python docs/acan_map.py"


@pytest.mark.conforms("AC-37")
def test_every_row_names_a_counterpart_or_says_why_not() -> None:
    for row in ROWS:
        said = (
            "`" in row[3]
            or row[2] == name_map.NO_NAME
            or row[3] in {"the object itself", "calling convention of C"}
        )
        assert said, row[0]


@pytest.mark.conforms("AC-37")
def test_every_counterpart_exists() -> None:
    assert len(PLACES) > 50
    assert [place for place in PLACES if not there(place)] == []


def there(place: str) -> bool:
    if place == "notify_event":
        return place in inspect.signature(acan.Int2d).parameters
    if place.startswith("canwire acan "):
        verb, _, switch = place.removeprefix("canwire acan ").partition(" ")
        command = importlib.import_module("canwire.commands.acan.verb")
        return any(switch in line for line in re.findall(rf"canwire acan {verb} .*", command.__doc__))
    return exists(place)


def exists(place: str) -> bool:
    """A dotted name, imported and walked; `name(parameter)`, too. Modules that are not there yet are skipped."""
    path, _, parameter = place.rstrip(")").partition("(")
    found = MODULE.match(path)
    assert found, place
    there: Any = importlib.import_module(found[0])
    for step in path.removeprefix(found[0]).strip(".").split("."):
        if step and not hasattr(there, step) and step not in getattr(there, "__dataclass_fields__", ()):
            return False
        there = getattr(there, step, None) if step else there
    return not parameter or parameter in inspect.signature(there).parameters


@pytest.mark.conforms("AC-37")
def test_constants_and_structures_have_their_own_names() -> None:
    names = [row[1] for row in ROWS if row[2] in ("structure", "constant")]
    assert [name for name in names if name not in acan.__all__ or getattr(acan, name) is None] == []


@pytest.mark.conforms("AC-37")
def test_functions_have_their_own_names() -> None:
    api = importlib.import_module("canwire.acan.api")
    names = [row[1] for row in ROWS if row[2] == "function"]
    assert [name for name in names if not inspect.isfunction(getattr(api, name, None))] == []


@pytest.mark.conforms("AC-37")
def test_the_other_way_round_nothing_is_made_up() -> None:
    told = {row[1] for row in ROWS}
    for structure in (acan.ACANHI, acan.ACANMB, acan.ACANID, acan.ACANTB):
        assert {f"{structure.__name__}.{field}" for field in structure.OFFSETS} <= told
    constants = importlib.import_module("canwire.acan.constants")
    ours = {name for name in vars(constants) if re.fullmatch(r"[A-Z][A-Z0-9_]+", name)}
    assert {name for name in ours - told if not name.startswith("DEFAULT_")} == set()


@with_manual
def test_the_script_reads_all_signatures() -> None:
    """Counted another way: one signature for each function, ACANAPI before its name."""
    text = (name_map.SEEDS / acan_map.MANUAL).read_text(encoding="utf-8")
    functions = [row for row in ROWS if row[2] == "function"]
    assert len(re.findall(r"ACANAPI ACAN_", text)) == len(functions) == 15
    assert len(re.findall(r"# ?ACAN_[A-Z_]+.*\(", text)) + 1 == len(
        [row for row in ROWS if row[1] in vars(acan) and row[2] == "service"]
    )


@each(
    ("kind", "text"),
    [
        ("function", "ACAN_SetColour"),
        ("parameter", "ACAN_SetColour(lpHI)"),
        ("structure", "ACANCOLOUR"),
        ("field", "ACANTB.bColour"),
        ("constant", "SC_COLOUR"),
        ("type", "LPCOLOUR"),
        ("register", "COLR"),
        ("interrupt", "CIE"),
        ("service", "ACAN_COLOUR"),
        ("assembly name", "tb_col"),
        ("program", "COLOUR"),
        ("switch", "CANTERM /X"),
        ("setting", "[WCT] Colour"),
        ("menu", "Options/Colour"),
        ("key", "CTRL-X"),
        ("file", "COLOUR.EXE"),
        ("no name", "Colour"),
    ],
)
def test_a_name_without_counterpart_stops_the_script(kind: str, text: str) -> None:
    with pytest.raises(name_map.Missing, match=re.escape(text)):
        acan_map.page([*acan_map.names_of_page(TEXT), name_map.Name(kind, text)])


@with_manual
@pytest.mark.parametrize(
    ("before", "after", "missing"),
    [
        ("WORD wCount ;", "WORD wCount ;\nWORD wCol our ;", "ACANTB.wColour"),
        ("#define FF_RTR", "#defi ne FF_COL 0x20\n#define FF_RTR", "FF_COL"),
        ("WORD ACANAPI ACAN_Init(void);", "WORD ACANAPI ACAN_Colour(void);", "ACAN_Colour"),
        ("# ACAN_REGISTER (", "# ACAN_COLOUR (x)\n# ACAN_REGISTER (", "ACAN_COLOUR"),
        ("/E echo mode", "/E echo mode\n/X colour", "CANTERM /X"),
    ],
)
def test_a_name_new_in_the_manual_is_found(before: str, after: str, missing: str, tmp_path: Path) -> None:
    text = (name_map.SEEDS / acan_map.MANUAL).read_text(encoding="utf-8")
    assert before in text or re.sub(" ;", ";", before) in text
    changed = text.replace(before if before in text else re.sub(" ;", ";", before), after, 1)
    (tmp_path / acan_map.MANUAL).write_text(changed, encoding="utf-8")
    with pytest.raises(name_map.Missing, match=re.escape(missing)):
        acan_map.page(acan_map.names_of_manual(tmp_path))
