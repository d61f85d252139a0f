"""What fuzzing has found, read again within a second for all targets; `python -m tests.fuzz` looks for more."""

from __future__ import annotations

import random
import sys

import pytest

from tests.fuzz.__main__ import CORPUS, folder_of, outcome, saved
from tests.fuzz.mutator import LARGEST, mutated
from tests.fuzz.targets import targets

pytestmark = pytest.mark.finding("faults-2 5")

NEEDS = {"log-parquet": "pyarrow"}


@pytest.mark.skipif(sys.platform == "win32", reason="its clock for a process raises no signal there")
@pytest.mark.parametrize("folder", sorted(path.name for path in CORPUS.iterdir()))
def test_what_was_found_stays_mended(folder: str) -> None:
    if folder in NEEDS:
        pytest.importorskip(NEEDS[folder])
    (name,) = (name for name in targets(seeded=False) if folder_of(name) == folder)
    parser, inputs = targets(seeded=False)[name], saved(name)
    assert inputs
    assert [outcome(parser, data) for data in inputs] == [""] * len(inputs)


def test_mutations_repeat_and_differ() -> None:
    seeds = [b"(1.0) can0 123#11\n", bytes(100)]
    one, two = (
        [mutated(chance, seeds) for _ in range(200)] for chance in (random.Random(1), random.Random(1))
    )
    assert one == two
    assert len(set(one)) > 150
    assert max(map(len, one)) <= LARGEST
