"""benchmarks/compare.py: which rows a change could touch, what has to be compiled, and what it finds and says."""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import canwire

BENCHMARKS = Path(__file__).resolve().parent.parent / "benchmarks"
SOURCE = Path(canwire.__file__).parent
SETUP = 'CORE = {"canwire.ring": 3, "canwire.bus.node": 2, "canwire.timeline": 1}'
BUILT = str(sysconfig.get_config_var("EXT_SUFFIX"))
FILES = {
    "_mem.pxd": "",
    "ring.py": "",
    "ring.pxd": "from canwire cimport _mem\n",
    "bus/node.py": "",
    "bus/node.pxd": "cimport cython\nfrom canwire.ring cimport (\n    Ring,\n)\n",
    "timeline.py": "",
    "timeline.pxd": "",
    "candrv/text.py": "",
}


@pytest.fixture
def compare(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import compare

    yield compare
    for name in ("compare", "comparing", "comparing.builds", "comparing.rows"):
        sys.modules.pop(name, None)


def tree(folder: Path, *, setup: str = SETUP, **changed: str) -> Path:
    """A commit's files; in names `__` is a slash, and `_p` begins the ending."""
    files = FILES | {name.replace("__", "/").replace("_p", ".p"): text for name, text in changed.items()}
    for name, text in files.items():
        path = folder / "src" / "canwire" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (folder / "setup.py").write_text(setup)
    return folder


def builds() -> ModuleType:
    return sys.modules["comparing.builds"]


def made(compare: ModuleType, folder: Path) -> list[str]:
    """As if everything was compiled: the names of its extensions."""
    names = list(compare.recipes(folder / "src", folder / "setup.py"))
    for name in names:
        (folder / "src" / (name.replace(".", "/") + BUILT)).write_text(folder.name)
    return names


@pytest.fixture
def compiling(compare: ModuleType, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What would be compiled."""
    compiled: list[str] = []
    monkeypatch.setattr(builds(), "compile_in", lambda _, names: compiled.extend(names))
    return compiled


def test_a_row_is_run_if_a_file_that_it_needs_is_another_one(compare: ModuleType, tmp_path: Path) -> None:
    old = tree(tmp_path / "old")
    assert compare.touched(old, tree(tmp_path / "same")) == []
    candrv = compare.touched(old, tree(tmp_path / "candrv", candrv__text_py="other"))
    assert candrv == ["CANDRV, ReadFile", "CANDRV, IOCTL_CAN_READ_EVENT_DATA"]
    ring = compare.touched(old, tree(tmp_path / "ring", ring_py="other"))
    assert {"core, classic", *candrv} <= set(ring)
    assert "slcan, frames out of text" not in ring
    level = compare.touched(old, tree(tmp_path / "level", setup=SETUP.replace("2", "3")))
    assert set(level) == {name for name, row in compare.ROWS.items() if "bus" in row.touched}


@pytest.mark.parametrize(
    ("changed", "compiled"),
    [
        ({}, []),
        ({"candrv__text_py": "other"}, []),
        ({"ring_py": "other"}, ["canwire.ring"]),
        ({"bus__node_pxd": "cdef class Node: pass"}, ["canwire.bus.node"]),
        ({"ring_pxd": "cdef class Ring: pass"}, ["canwire.ring", "canwire.bus.node"]),
        ({"_mem_pxd": "# other"}, ["canwire.ring", "canwire.bus.node"]),  # through ring.pxd
        ({"setup": SETUP.replace("1", "2")}, ["canwire.timeline"]),
        ({"setup": SETUP + "\nFLAGS = 1"}, ["canwire.ring", "canwire.bus.node", "canwire.timeline"]),
    ],
)
def test_only_what_differs_is_compiled(
    compare: ModuleType, compiling: list[str], tmp_path: Path, changed: dict[str, str], compiled: list[str]
) -> None:
    new, old = tree(tmp_path / "new"), tree(tmp_path / "old", **changed)
    names = made(compare, new)
    assert compare.build(old, [compare.Compiled(new / "src", new / "setup.py")]) == compiling == compiled
    copied = {path.read_text() for path in old.rglob("*" + BUILT)}
    assert copied == ({"new"} if len(compiled) < len(names) else set())


def test_what_nobody_has_compiled_is_compiled(
    compare: ModuleType, compiling: list[str], tmp_path: Path
) -> None:
    """The same sources, but no compiled files there: a package that was installed uncompiled."""
    new, folder = tree(tmp_path / "new"), tree(tmp_path / "installed")
    compare.build(new, [compare.Compiled(folder / "src", new / "setup.py")])
    assert compiling == ["canwire.ring", "canwire.bus.node", "canwire.timeline"]


def test_the_core_s_own_declarations_are_followed(compare: ModuleType) -> None:
    found = {path.relative_to(SOURCE).as_posix() for path in builds().sources(SOURCE.parent, "canwire.ring")}
    assert {"ring.py", "ring.pxd", "_mem.pxd"} <= found
    found = {
        path.relative_to(SOURCE).as_posix()
        for path in builds().sources(SOURCE.parent, "canwire.values.slcan_text")
    }
    assert {"values/slcan_text.py", "values/hex_text.pxd", "values/frame.pxd", "_mem.pxd"} <= found
    assert not {"values/frame.py", "values/hex_text.py"} & found


@pytest.fixture
def repository(compare: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A clone with one commit, of which compare.py is part."""
    root = tree(tmp_path / "root")
    git(root, "init", "-q")
    git(root, "add", ".")
    git(root, "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "first")
    monkeypatch.setattr(compare, "ROOT", root)
    return root


def git(root: Path, *words: str) -> str:
    ended = subprocess.run(["git", *words], cwd=root, check=True, capture_output=True, text=True)
    return ended.stdout.strip()


def main(compare: ModuleType, monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["compare.py", *words])
    return int(compare.main())


def test_nothing_to_compare_is_said_in_one_line(
    compare: ModuleType,
    compiling: list[str],
    repository: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Nothing is compiled, and no row is run: a page of the documentation is all that has changed."""
    (repository / "README.md").write_text("other")
    assert main(compare, monkeypatch, "HEAD", "--short") == 0
    said = capfd.readouterr()
    assert (said.out, said.err) == (
        "no row could be touched by what is different from HEAD: nothing is compared\n",
        "",
    )
    assert compiling == []


def test_a_commit_that_is_not_there(
    compare: ModuleType,
    repository: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    with pytest.raises(SystemExit, match=r"^1234567: git knows no such commit$"):
        main(compare, monkeypatch, "1234567", "--short")
    first = git(repository, "rev-parse", "HEAD")
    git(
        repository,
        "-c",
        "user.name=a",
        "-c",
        "user.email=a@b",
        "commit",
        "-q",
        "--allow-empty",
        "-m",
        "second",
    )
    git(tmp_path, "clone", "-q", "--depth", "1", repository.as_uri(), "shallow")
    monkeypatch.setattr(compare, "ROOT", tmp_path / "shallow")
    assert main(compare, monkeypatch, first, "--short") == 0
    assert capfd.readouterr().out == f"{first} is not in this clone, which is shallow: nothing is compared\n"
    with pytest.raises(SystemExit, match="shallow"):
        main(compare, monkeypatch, first)


def test_a_planted_slow_down_is_found(
    compare: ModuleType, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A block of a log is read four times in the copy; the other row's files are the same, and take turns as well."""
    pytest.importorskip("numpy")
    old, new = tmp_path / "old", tmp_path / "new"
    for folder in (old, new):
        shutil.copytree(SOURCE, folder / "src" / "canwire", ignore=shutil.ignore_patterns("__pycache__"))
    with (new / "src/canwire/logs/candump/fast.py").open("a") as file:
        file.write("\n\n_once = plain_lines\n\n\ndef plain_lines(*given):\n")
        file.write("    return [_once(*given) for _ in range(4)][-1]\n")
    rows = ["candump log, read", "slcan, frames out of text"]
    assert compare.row_by_row(old, new, rows, rounds=3, short=True) == rows[:1]
    said = [line[:36].strip() for line in capfd.readouterr().out.splitlines()[1:]]
    assert said[: compare.TRIES] == rows[:1] * compare.TRIES  # measured again
    assert set(said[compare.TRIES :]) == {rows[1]}  # more than once on a busy machine


def test_a_row_prints_its_rates_by_processor_time_and_by_the_clock(compare: ModuleType) -> None:
    for short, clocks in ((False, 2), (True, 1)):
        runner = compare.Runner(BENCHMARKS.parent, "slcan, frames out of text", short=short)
        try:
            slices = [runner.rates(2000), runner.rates(1000)]
        finally:
            runner.close()
        assert [len(rates) for rates in slices] == [clocks, clocks]
        assert all(rate > 0 for rates in slices for rate in rates)


def test_a_row_that_a_commit_does_not_have_is_named(compare: ModuleType) -> None:
    runner = compare.Runner(BENCHMARKS.parent, "a row of tomorrow")
    try:
        with pytest.raises(compare.CannotRun, match="a row of tomorrow"):
            runner.rates(1000)
    finally:
        runner.close()
