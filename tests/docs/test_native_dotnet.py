"""native-dotnet.md: its program runs as native.svg shows it, its sed makes C# fit for mcs, its counts are right."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from canwire.native import dotnet, library_directory
from tests import warm
from tests.docs.blocks import ROOT, blocks
from tests.missing import find_program, supported

PAGE, PICTURE = ROOT / "docs" / "native-dotnet.md", ROOT / "docs" / "native.svg"
TYPE = re.compile(
    r"^    (?:\[.*\] )?public (?:sealed |partial )*(?:class|struct|enum|interface) (\w+)", re.MULTILINE
)
NULLABLE = """
using System.Collections.Generic;
static class Program
{
    static string? name = null;
    static List<int?>? numbers;
    static int[]? Some(string? text, object? other) { return text == null ? null : new int[text!.Length]; }
    static string? Text { get; set; }
    static bool Out(out string? text) { text = "x"; return true; }
    static void Main()
    {
        string? found = Text ?? name;
        int? none = null;
        foreach (int? one in numbers ?? new List<int?>()) { }
        if (none == null && Out(out string? made) && made! != "y" && !(found != null))
            System.Console.WriteLine(Some(made, null)![0]);
    }
}
"""


def fenced(language: str) -> list[str]:
    return [block.text for block in blocks(PAGE) if block.language == language]


def needs_libraries() -> None:
    if sys.platform != "linux":
        pytest.skip("the libraries for C are Linux's")
    supported(library_directory)
    find_program("mcs")
    find_program("mono")


@pytest.mark.conforms("N-39", "N-43")
def test_its_program_one_in_cpp_candump_and_pytest_on_one_bus(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The picture native.svg, whose commands are the pages'."""
    pytest.importorskip("can")
    needs_libraries()
    for program in ("g++", "candump"):
        find_program(program)
    import shared_picture
    from tests.native.dotnet.state import state_of_this_run

    state = str(state_of_this_run(tmp_path_factory))
    tools = os.pathsep.join((str(tmp_path), str(Path(sys.executable).parent), os.environ["PATH"]))
    for name, value in {"PATH": tools, "XDG_STATE_HOME": state, "CANWIRE_HUB": ""}.items():
        monkeypatch.setenv(name, value)
    warm.write_script(tmp_path / "canwire")
    shown = shared_picture.picture(shared_picture.native())
    assert shown == PICTURE.read_text(encoding="utf-8")


@pytest.mark.conforms("N-43")
def test_marks_of_nullable_references_are_taken_out(tmp_path: Path) -> None:
    needs_libraries()
    (command,) = fenced("sh")
    warm.write_script(tmp_path / "canwire")
    (tmp_path / "CanConNet.cs").write_text(NULLABLE, encoding="utf-8")
    (tmp_path / "build").mkdir()
    settings = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run(["bash", "-e", "-c", command], cwd=tmp_path, env=settings, check=True)
    built = tmp_path / "program.exe"
    subprocess.run(["mcs", "-warn:0", f"-out:{built}", str(tmp_path / "build" / "CanConNet.cs")], check=True)
    assert subprocess.run(["mono", str(built)], capture_output=True, text=True, check=True).stdout == "0\n"


def test_its_count_is_the_contracts() -> None:
    sources = (Path(dotnet.source_directory()) / "contract").rglob("*.cs")
    found = [name for source in sources for name in TYPE.findall(source.read_text("utf-8"))]
    v3_alone = {"VciCtrlInfo"}  # a structure there
    counted = re.search(r"(\d+) public types", PAGE.read_text("utf-8"))
    assert counted is not None
    assert int(counted[1]) == len(set(found) - v3_alone)
