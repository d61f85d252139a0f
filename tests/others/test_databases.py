"""Every database of cantools' and canmatrix' tests and of opendbc, decoded by us, one by one and in columns, and by
cantools itself; and encoded."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from tests.others.packages import unpacked

pytest.importorskip("cantools")
from tests.others.database_comparison import SUFFIXES, differences, read_by_both


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    root = unpacked(tmp_path_factory.mktemp("others"))
    return [path for path in sorted(root.rglob("*")) if path.suffix.lower() in SUFFIXES - {".ldf"}]


@pytest.mark.filterwarnings("ignore")
def test_they_say_the_same_as_cantools(files: list[Path], record_property: Any) -> None:
    counts: Counter[str] = Counter()
    found: list[str] = []
    for path in files:
        theirs, ours, why = read_by_both(path)
        counts["files"] += 1
        if theirs is None or ours is None:
            counts["refused"] += 1
            if (theirs is None) != (ours is None):
                found.append(f"{path.name}: {'cantools' if theirs is None else 'we'} alone refuse it: {why}")
            continue
        found += [f"{path.name}: {one}" for one in differences(ours, theirs, counts)]
    for name, count in counts.items():
        record_property(name, count)
    assert found == []
    assert counts["values decoded"] > 1000
    assert counts["encoded"] > 1000
