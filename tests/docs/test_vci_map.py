"""docs/vci-map.md has every name of the two VCI manuals, and what it says of each is true."""

from __future__ import annotations

import importlib
import inspect
import re
from typing import Any

import pytest

import name_map
from docs import vci_map
from tests.cases import each

TEXT: str = vci_map.PAGE.read_text(encoding="utf-8")
ROWS = [row for line in TEXT.splitlines() if (row := name_map.ROW.match(line))]
with_manuals = pytest.mark.skipif(not name_map.SEEDS.is_dir(), reason="the manuals are not here")


def test_the_page_is_what_the_script_writes() -> None:
    names = vci_map.names_of_page(TEXT)
    assert len(names) == len(ROWS) > 800
    assert vci_map.page(names) == TEXT, "run: python docs/vci_map.py"


@with_manuals
@pytest.mark.conforms("X3-42", "X4-48")
def test_the_page_has_every_name_of_the_manuals() -> None:
    assert vci_map.page(vci_map.names_of_manuals(name_map.SEEDS)) == TEXT, "run: python docs/vci_map.py"


@pytest.mark.conforms("X3-42", "X4-48")
def test_every_counterpart_exists() -> None:
    for row in ROWS:
        if row[2] != name_map.NO_NAME:
            places = re.findall(r"`([^`]+)`", row[3])
            assert places or row[3] == "the result, returned", row[0]
            for place in places:
                assert exists(place), row[0]


def exists(place: str) -> bool:
    """A dotted name, imported and walked; `name(parameter)`, `prefix*` and Python's own names, too."""
    path, _, parameter = place.rstrip(")").partition("(")
    module = next(
        (name for name in ("canwire.vci.v3", "canwire.vci", "canwire", "uuid") if under(path, name)), ""
    )
    there: Any = importlib.import_module(module or "builtins")
    for step in path.removeprefix(f"{module}.").split("."):
        if step.endswith("*"):
            return any(name.startswith(step[:-1]) for name in vars(there))
        if step in ("None", "True", "False"):
            return True
        if not hasattr(there, step) and step not in getattr(there, "__annotations__", ()):
            return False
        there = getattr(there, step, None)
    return not parameter or parameter in inspect.signature(there).parameters


def under(path: str, module: str) -> bool:
    return path.startswith(f"{module}.")


@with_manuals
def test_the_script_reads_all_signatures_and_structures() -> None:
    """Counted another way: by the manual's own headings in its table of contents."""
    text = (name_map.SEEDS / vci_map.V4_MANUAL).read_text(encoding="utf-8")
    contents = text[: text.rindex("\n1 Benutzerführung\n")]
    names = {name.text for name in vci_map.names_of_manuals(name_map.SEEDS)}
    titles = re.findall(r"^[67](?:\.\d+)+\s+(\w+?)\.*\s+\d+$", contents, re.MULTILINE)
    assert len(titles) == 61
    assert {title for title in titles if f"IUnknown::{title}" not in names} <= names


@each(
    ("manual", "kind", "text"),
    [
        ("V4", "constant", "CAN_OPMODE_SILENT"),
        ("V4", "function", "VciCloseEverything"),
        ("V4", "method", "ICanSocket::GetSocketColour"),
        ("V4", "field", "CANMSG.dwColour"),
        ("V4", "interface", "ICanColour"),
        ("V4", "type", "PCANCOLOUR"),
        ("V3", "member", "CanMessage.Colour"),
        ("V3", "type", "CanColour"),
        ("V3", "parameter", "colour"),
    ],
)
def test_a_name_without_counterpart_stops_the_script(manual: str, kind: str, text: str) -> None:
    name = vci_map.Name(getattr(vci_map, manual), kind, text)
    with pytest.raises(name_map.Missing, match=text):
        vci_map.page([*vci_map.names_of_page(TEXT), name])


def test_a_field_that_the_manual_does_not_have_stops_the_script() -> None:
    names = [name for name in vci_map.names_of_page(TEXT) if name.text != "CANMSG.dwTime"]
    with pytest.raises(name_map.Missing, match=r"CanMsg.time \(dwTime\) is no field"):
        vci_map.page(names)
