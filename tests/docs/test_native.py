"""docs/native.md: its programs are compiled and run, and its counts are those of the headers."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from canwire.native import include_directory, library_directory
from tests.docs.blocks import ROOT, run_console
from tests.missing import find_program, supported

PAGE = ROOT / "docs" / "native.md"


@pytest.mark.conforms("N-39", "N-40")
def test_its_programs_run(tmp_path: Path) -> None:
    if sys.platform != "linux":
        pytest.skip("the libraries for C are Linux's")
    find_program("g++")
    supported(library_directory)
    shown = run_console(PAGE, tmp_path)
    assert "USB-to-CAN FD (simulated): 123 CAFE\n" in shown
    assert "321 5A\n" in shown


def test_its_counts_are_the_headers() -> None:
    page = PAGE.read_text("utf-8")
    rows = (
        ("vcisdk.h", r"(\d+) functions, "),
        ("vcinpl.h", r"(\d+) functions for CANMSG"),
        ("vcinpl2.h", r"with CAN FD: (\d+) functions"),
    )
    for header, counted in rows:
        text = (Path(include_directory()) / header).read_text("utf-8")
        declared = set(re.findall(r"^EXTERN_C \w+ VCIAPI (\w+)\(", text, re.MULTILINE))
        found = re.search(counted, page)
        assert found is not None
        assert int(found[1]) == len(declared), header
    interfaces = re.findall(
        r"^DECLARE_INTERFACE_\(", (Path(include_directory()) / "vcisdk.h").read_text("utf-8"), re.M
    )
    assert f"{len(interfaces)} interfaces" in page
