"""`from MODULE import *` of the interfaces: what it brings, and what it leaves alone."""

from __future__ import annotations

import builtins
import importlib

import pytest

from tests.cases import each

MODULES = (
    "canwire",
    "canwire.acan",
    "canwire.acan.api",
    "canwire.candrv",
    "canwire.candrv.win32",
    "canwire.slcan",
    "canwire.vci",
    "canwire.vci.v3",
)


def starred(module: str) -> dict[str, object]:
    """The names that a star import brings."""
    found: dict[str, object] = {}
    exec(f"from {module} import *", found)
    del found["__builtins__"]
    return found


@each("module", MODULES)
@pytest.mark.finding("dialects 5")
def test_nothing_of_python_is_replaced(module: str) -> None:
    assert not starred(module).keys() & vars(builtins).keys()


@pytest.mark.parametrize("module", ["canwire.acan", "canwire.candrv"])
def test_open_is_there_all_the_same(module: str) -> None:
    assert callable(importlib.import_module(module).open)


@pytest.mark.finding("dialects 5")
def test_a_star_import_of_acans_library_is_its_header() -> None:
    found = starred("canwire.acan.api")
    names = {
        "ACAN_Init",
        "BUS_ON",
        "SC_BUSOFF",
        "TBS_MB",
        "IDA_QUEUEMSG",
        "TBNT_EVENT",
        "ACANTB",
        "ACANMBSZ",
        "DWORD",
    }
    assert names <= found.keys()
    assert found["BUS_ON"] == 1
