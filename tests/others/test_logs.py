"""Every log of python-can's tests, read by us and by python-can itself."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import pytest

from tests.others.packages import unpacked

pytest.importorskip("can")
from tests.others.log_comparison import compare_log

SUFFIXES = {".asc", ".blf", ".trc"}
IMPOSSIBLE = "its bytes are a pattern: frames with 11-bit identifiers of 27 bits, or length codes above 15"
TOO_LONG = "its classic frame has 64 bytes: python-can takes the first eight"
REFUSED = {
    "test_CanFdMessage.blf": IMPOSSIBLE,
    "test_CanFdMessage64.blf": IMPOSSIBLE,
    "test_CanMessage.blf": IMPOSSIBLE,
    "test_CanMessage2.blf": IMPOSSIBLE,
    "single_frame.asc": TOO_LONG,
}
"""What python-can reads and we say is wrong, by file."""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    root = unpacked(tmp_path_factory.mktemp("others"))
    return [path for path in sorted(root.rglob("*")) if path.suffix.lower() in SUFFIXES]


@pytest.mark.filterwarnings("ignore")
def test_they_say_the_same_as_python_can(files: list[Path], record_property: Any) -> None:
    logging.getLogger("can").addHandler(logging.NullHandler())
    record_property("files", len(files))
    told = {path.name: compare_log(path) for path in files}
    wrong = {name: one for name, one in told.items() if one.outcome not in ("same", "explained", "refused")}
    assert wrong == {}
    assert {name for name, one in told.items() if one.outcome == "refused"} == REFUSED.keys() & told.keys()
    assert len(files) > 15
