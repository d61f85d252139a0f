"""What `canwire native dotnet` tells a build, and how the assemblies come to be."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from canwire import Unsupported
from canwire.native import dotnet
from tests.hubs import status_of
from tests.missing import find_program
from tests.native.dotnet.conftest import PROGRAMS, Mono


@pytest.fixture
def state(mono: Mono, monkeypatch: pytest.MonkeyPatch) -> None:
    """The assemblies that were compiled for this run are the user's."""
    monkeypatch.setenv("XDG_STATE_HOME", str(mono.state))


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Nothing is compiled yet, and nothing but what a test puts here is found as a program."""
    if not os.path.exists(os.path.join(dotnet.source_directory(), "..", "lib", "libvciapi.so")):
        pytest.skip("the libraries for C are not here")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


def compiler(home: Path, *lines: str) -> None:
    """A program in mcs' place."""
    shell = shutil.which("sh", path="/bin:/usr/bin")
    (home / "mcs").write_text("\n".join([f"#!{shell}", *lines, ""]))
    (home / "mcs").chmod(0o755)


@pytest.mark.conforms("N-43")
@pytest.mark.usefixtures("state")
def test_what_a_build_is_told(mono: Mono, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status_of("native", "dotnet", "--libs") == 0
    references = capsys.readouterr().out.split()
    made = tmp_path / "errors.exe"
    sources = [str(PROGRAMS / name) for name in ("Errors.cs", "Boards.cs")]
    subprocess.run([find_program("mcs"), *sources, *references, f"-out:{made}"], check=True)
    assert status_of("native", "dotnet", "--libraries", "--includes") == 0
    assert capsys.readouterr().out.split() == [dotnet.source_directory(), mono.assemblies]


def test_what_dotnet_has_not(capsys: pytest.CaptureFixture[str]) -> None:
    assert status_of("native", "dotnet", "--cmake") == 2
    assert "dotnet has --libs" in capsys.readouterr().err
    assert status_of("native", "dotnet") == 2
    assert "say what to print" in capsys.readouterr().err


@pytest.mark.usefixtures("state")
def test_they_are_compiled_once(mono: Mono, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nonexistent")
    assert dotnet.assembly_directory() == mono.assemblies
    assert sorted(os.listdir(mono.assemblies)) == sorted(dotnet.NAMES)


@pytest.mark.usefixtures("fresh")
def test_no_compiler() -> None:
    with pytest.raises(Unsupported, match=r"apt-get install mono-mcs.*dotnet build .*Ixxat\.Vci4\.csproj"):
        dotnet.assembly_directory()


def test_a_compiler_that_refuses_leaves_nothing(fresh: Path) -> None:
    compiler(fresh, "echo 'error CS9999: not today' >&2", "exit 1")
    with pytest.raises(
        Unsupported, match=r"could not compile Ixxat\.Vci4\.Contract: error CS9999: not today"
    ):
        dotnet.assembly_directory()
    assert os.listdir(fresh / "state" / "canwire" / "dotnet") == []


def test_who_was_quicker_has_the_same(fresh: Path) -> None:
    """Another program has filled the folder while this one's compiler ran."""
    expected = fresh / "state" / "canwire" / "dotnet" / dotnet._key(dotnet.library_directory())
    compiler(fresh, f"/bin/mkdir -p {expected}", f": > {expected}/first")
    assert dotnet.assembly_directory() == str(expected)
    assert os.listdir(expected) == ["first"]


@pytest.mark.conforms("N-43")
def test_each_source_belongs_to_a_project() -> None:
    """.NET's own compiler takes the same files as mcs, by the projects' patterns."""
    home = Path(dotnet.source_directory())
    taken = set()
    for project in home.glob("*.csproj"):
        for include in project.read_text("utf-8").split('<Compile Include="')[1:]:
            for pattern in include.split('"')[0].split(";"):
                taken |= set(home.glob(pattern))
    assert taken == set(home.rglob("*.cs"))
    assert {project.stem for project in home.glob("*.csproj")} == {Path(name).stem for name in dotnet.NAMES}
