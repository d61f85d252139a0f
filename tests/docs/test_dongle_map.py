"""docs/dongle-map.md has every name of the CANBUS manual, and what it says of each is true."""

from __future__ import annotations

import importlib
import re
from typing import Any

import pytest

import name_map
from docs import dongle_map
from tests.cases import each
from tests.slcan.bench import Bench
from tests.slcan.conftest import bench

__all__ = ["bench"]  # the fixture

TEXT: str = dongle_map.PAGE.read_text(encoding="utf-8")
ROWS = [row for line in TEXT.splitlines() if (row := name_map.ROW.match(line))]
PLACES = sorted({place for row in ROWS for place in re.findall(r"`([^`]+)`", row[3])})
SENT = {
    "Sn": "S4",
    "sxxyy": "s031C",
    "O": "O",
    "C": "C",
    "tiiildd": "t100133",
    "Tiiiiiiidd": "T00000100133",
    "F": "F",
}
SENT |= {"Mxxxxxxx": "M00006000", "mxxxxxxx": "m00001FF0", "V": "V", "N": "N", "Zn": "Z1"}
OPEN = {"C", "tiiildd", "Tiiiiiiidd", "F"}
SET_UP = {"O", "Mxxxxxxx", "mxxxxxxx"}
pytestmark = pytest.mark.finding("dialects 7")


def test_the_page_is_what_the_script_writes() -> None:
    names = dongle_map.names_of_page(TEXT)
    assert len(names) == len(ROWS) > 40
    assert dongle_map.page(names) == TEXT, "run: python docs/dongle_map.py"


@pytest.mark.skipif(not name_map.SEEDS.is_dir(), reason="the manual is not here")
def test_the_page_has_every_name_of_the_manual() -> None:
    assert dongle_map.page(dongle_map.names_of_manual(name_map.SEEDS)) == TEXT, (
        "run: python docs/dongle_map.py"
    )


@each("place", PLACES)
def test_every_counterpart_exists(place: str) -> None:
    package = "canwire.slcan" if place.startswith("canwire.slcan.") else "canwire"
    there: Any = importlib.import_module(package)
    for step in place.removeprefix(f"{package}.").split("."):
        there = (
            there.__dataclass_fields__[step]
            if step in getattr(there, "__dataclass_fields__", ())
            else getattr(there, step)
        )


@pytest.mark.parametrize("command", [row[1] for row in ROWS if row[2] == "command"])
def test_every_command_is_answered(command: str, bench: Bench) -> None:
    before = b"S4\rO\r" if command in OPEN else b"S4\r" if command in SET_UP else b""
    assert b"\a" not in bench.ask(before + SENT[command].encode() + b"\r")


def test_a_name_without_a_counterpart_is_told() -> None:
    with pytest.raises(name_map.Missing, match="command Qx"):
        dongle_map.page([name_map.Name("command", "Qx")])
