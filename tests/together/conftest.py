"""Whatever programs do together, they leave nothing open in this process."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator

import pytest

from tests.descriptors import descriptors_before, left_open, open_descriptors

BEFORE = pytest.StashKey[Counter[str]]()
FIRST = pytest.StashKey[Counter[str]]()  # what was open before the first of these tests
FAILED = pytest.StashKey[bool]()
MEMORY = "/memfd:canwire (deleted)"
LINGERING = 8  # rings' memory that an exception's traceback may keep until the next exception


@pytest.fixture(autouse=True)
def _look_what_is_open(request: pytest.FixtureRequest) -> None:
    """Behind the fixtures of modules, in front of the test's own."""
    found = request.node.stash[BEFORE] = descriptors_before()
    request.session.stash.setdefault(FIRST, found)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    item.stash[FAILED] = item.stash.get(FAILED, False) or report.failed
    return report


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """When all of its fixtures are gone. A test that failed is held by its traceback, and so is what its programs had
    made, such as the event of an ACAN program's task block: nothing is said about it."""
    yield
    if BEFORE in item.stash and isinstance(item, pytest.Function) and not item.stash[FAILED]:
        item.funcargs.clear()
        left = left_open(lambda: _more_than_before(item))
        assert not left, f"left open: {dict(left)}"


def _more_than_before(item: pytest.Item) -> Counter[str]:
    found = open_descriptors()
    left = found - item.stash[BEFORE]
    if found[MEMORY] - item.session.stash[FIRST][MEMORY] <= LINGERING:
        del left[MEMORY]
    return left
