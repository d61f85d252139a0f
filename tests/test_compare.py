"""benchmarks/compare.py: which rows a change could touch, when compiled files can be shared, and what a row prints."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).resolve().parent.parent / "benchmarks"


@pytest.fixture
def compare(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import compare

    yield compare
    for name in ("compare", "compare_rows"):
        sys.modules.pop(name, None)


def tree(folder: Path, **files: str) -> Path:
    """A commit's files; `__` is a slash."""
    (folder / "src" / "canwire").mkdir(parents=True)
    (folder / "setup.py").write_text('CORE = {"canwire.ring": 3}')
    for name, text in {"ring_py": "", "candrv__text_py": "", **files}.items():
        path = folder / "src" / "canwire" / name.replace("__", "/").replace("_p", ".p")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return folder


def test_a_row_is_run_if_a_file_that_it_needs_is_another_one(compare: ModuleType, tmp_path: Path) -> None:
    old = tree(tmp_path / "old")
    assert compare.touched(old, tree(tmp_path / "same")) == []
    candrv = compare.touched(old, tree(tmp_path / "candrv", candrv__text_py="other"))
    assert candrv == ["CANDRV, ReadFile", "CANDRV, IOCTL_CAN_READ_EVENT_DATA"]
    ring = compare.touched(old, tree(tmp_path / "ring", ring_py="other"))
    assert {"core, classic", *candrv} <= set(ring)
    assert "slcan, frames out of text" not in ring


def test_compiled_files_are_shared_only_between_the_same_sources(compare: ModuleType, tmp_path: Path) -> None:
    old = compare.compiled_sources(tree(tmp_path / "old"))
    assert old == compare.compiled_sources(tree(tmp_path / "candrv", candrv__text_py="other"))
    assert old != compare.compiled_sources(tree(tmp_path / "ring", ring_py="other"))
    assert old != compare.compiled_sources(tree(tmp_path / "declared", ring_pxd="cdef class Ring: pass"))


def test_a_row_prints_its_rates_by_processor_time_and_by_the_clock(compare: ModuleType) -> None:
    runner = compare.Runner(BENCHMARKS.parent, "slcan, frames out of text")
    try:
        slices = [runner.rates(2000), runner.rates(1000)]
    finally:
        runner.close()
    assert all(rate > 0 for rates in slices for rate in rates)


def test_a_row_that_a_commit_does_not_have_is_named(compare: ModuleType) -> None:
    runner = compare.Runner(BENCHMARKS.parent, "a row of tomorrow")
    try:
        with pytest.raises(compare.CannotRun, match="a row of tomorrow"):
            runner.rates(1000)
    finally:
        runner.close()
