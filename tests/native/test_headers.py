"""Our headers say what canwire.vci's tables say: names, values, sizes, and who is exported."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from canwire import vci
from canwire.native import include_directory, library_directory
from canwire.vci.structures.structure import Structure
from tests.missing import find_program
from tests.native.conftest import Native

HEADERS = ("cantype.h", "lintype.h", "baltype.h", "vcitype.h", "vcierr.h", "vciguid.h")
_PREFIXES = ("CAN_", "LIN_", "VCI_E_", "VCI_BUS_", "BAL_MAX")


def text(header: str) -> str:
    return (Path(include_directory()) / header).read_text("utf-8")


def test_constants_and_sizes(native: Native) -> None:
    """A program that asserts them all compiles."""
    constants = {
        name: value
        for name, value in vars(vci).items()
        if name.startswith(_PREFIXES) and isinstance(value, int) and "_667KB" not in name
    }
    structures = {
        kind.NAME: kind.SIZE
        for kind in vars(vci).values()
        if isinstance(kind, type)
        and issubclass(kind, Structure)
        and kind is not Structure
        and "." not in kind.NAME
    }
    structures = {
        name: size
        for name, size in structures.items()
        if re.search(rf"\}} {name},", "".join(map(text, HEADERS)))
    }
    assert len(constants) > 200
    assert len(structures) > 25
    lines = [
        f"static_assert((unsigned){name} == {value & 0xFFFFFFFF}u);" for name, value in constants.items()
    ]
    lines += [f"static_assert(sizeof({name}) == {size});" for name, size in structures.items()]
    (native.home / "constants.cpp").write_text("\n".join(["#include <vcisdk.h>", *lines, "int main() {}"]))
    native.build("constants.cpp", options=("-fsyntax-only",))


@pytest.mark.conforms("N-39", "N-40")
@pytest.mark.parametrize(
    ("header", "library"), [("vcisdk.h", "vciapi"), ("vcinpl.h", "vcinpl"), ("vcinpl2.h", "vcinpl2")]
)
def test_every_function_of_a_header_is_exported(native: Native, header: str, library: str) -> None:
    declared = set(re.findall(r"^EXTERN_C \w+ VCIAPI (\w+)\(", text(header), re.MULTILINE))
    assert len(declared) > 20
    listed = subprocess.run(
        [find_program("nm"), "-D", "--defined-only", f"{library_directory()}/lib{library}.so"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert declared <= {line.split()[-1] for line in listed.splitlines()}
